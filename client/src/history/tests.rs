use core::time::Duration;

use lodestone_schema::{Pose, Validity};
use proptest::prelude::*;

use super::History;
use crate::error::LookupError;
use crate::limits::LookupLimits;
use crate::pose::CameraPose;
use crate::pose::samples::{checked, still};
use crate::time::Time;

const STEP_NS: i64 = 2_500_000;

fn at(sequence: u64) -> Pose {
    let time_ns = 1_000_000_000 + STEP_NS * sequence as i64;
    Pose { position_m: [sequence as f64, 0.0, 0.0], ..still(sequence, time_ns) }
}

fn filled(capacity: usize, sequences: impl IntoIterator<Item = u64>) -> History {
    let mut history = History::new(capacity, LookupLimits::default());
    sequences.into_iter().for_each(|sequence| history.push(checked(at(sequence))));
    history
}

fn found_x(history: &History, time_ns: i64) -> Result<f64, LookupError> {
    Ok(history.lookup(Time::Monotonic(time_ns))?.position_m().unwrap().x)
}

proptest! {
    #[test]
    fn every_pose_kept_is_found_exactly(capacity in 2..50_usize, count in 1..200_u64) {
        let history = filled(capacity, 0..count);
        let kept = (capacity as u64).min(count);
        prop_assert_eq!(history.len() as u64, kept);
        for sequence in count - kept..count {
            let found = history.lookup(Time::Monotonic(at(sequence).time_ns)).unwrap();
            prop_assert_eq!(found, checked(at(sequence)));
        }
    }

    #[test]
    fn no_time_makes_a_lookup_panic(time_ns in any::<i64>(), unix in any::<bool>()) {
        let history = filled(8, 0..20);
        let time = if unix { Time::Unix(time_ns) } else { Time::Monotonic(time_ns) };
        if let Ok(pose) = history.lookup(time) {
            prop_assert!(pose.position_m().is_none_or(glam::DVec3::is_finite));
        }
    }
}

#[test]
fn times_outside_are_refused_with_the_bounds() {
    let history = filled(4, 0..10);
    let (oldest_ns, newest_ns) = (at(6).time_ns, at(9).time_ns);
    let old = history.lookup(Time::Monotonic(oldest_ns - 1)).unwrap_err();
    assert!(matches!(old, LookupError::TooOld { oldest_ns: o, asked_ns }
        if o == oldest_ns && asked_ns == oldest_ns - 1));
    assert!(history.lookup(Time::Monotonic(newest_ns + 50_000_000)).is_ok());
    let new = history.lookup(Time::Monotonic(newest_ns + 50_000_001)).unwrap_err();
    assert!(matches!(new, LookupError::TooNew { cap_ns: 50_000_000, .. }), "{new}");
    assert!(matches!(
        History::new(4, LookupLimits::default()).lookup(Time::Unix(0)),
        Err(LookupError::Empty)
    ));
}

#[test]
fn both_clocks_find_the_same_pose() {
    let history = filled(10, 0..10);
    let (mono, offset) = (at(4).time_ns + 17, at(4).unix_offset_ns);
    let by_monotonic = history.lookup(Time::Monotonic(mono)).unwrap();
    assert_eq!(history.lookup(Time::Unix(mono + offset)).unwrap(), by_monotonic);
}

#[test]
fn a_gap_is_bridged_only_up_to_the_limit() {
    // Given 38 lost poses (97.5 ms) and later 40 (102.5 ms)
    let history = filled(10, [0, 39, 80]);
    assert!(found_x(&history, at(20).time_ns).is_ok());
    let gap = found_x(&history, at(50).time_ns).unwrap_err();
    assert!(matches!(gap, LookupError::Gap { limit_ns: 100_000_000, .. }), "{gap}");
    // The poses beside the gap are known.
    assert!(found_x(&history, at(80).time_ns).is_ok());
    assert!(found_x(&history, at(39).time_ns).is_ok());
}

#[test]
fn nothing_is_interpolated_across_a_reset_nor_from_one_world_to_the_next() {
    let breaks: [fn(&mut Pose); 2] = [|pose| pose.reset_counter = 1, |pose| pose.world_epoch = 2];
    for break_at in breaks {
        let mut history = filled(10, 0..4);
        for mut pose in [at(4), at(5)] {
            break_at(&mut pose);
            history.push(checked(pose));
        }
        assert_eq!(history.len(), 2);
        let before = history.lookup(Time::Monotonic(at(4).time_ns - 1));
        assert!(matches!(before, Err(LookupError::TooOld { .. })));
        assert!(history.lookup(Time::Monotonic(at(4).time_ns + 1)).is_ok());
    }
}

#[test]
fn a_sequence_or_time_that_runs_back_begins_a_new_history() {
    let mut history = filled(10, 5..8);
    history.push(checked(Pose { sequence: 0, ..at(9) }));
    assert_eq!(history.len(), 1);
    history.push(checked(at(1)));
    assert_eq!(history.newest().unwrap().sequence(), 1);
    assert_eq!(history.len(), 1);
}

#[test]
fn two_poses_of_one_time_are_no_division_by_zero() {
    let mut history = filled(10, 0..2);
    history.push(checked(Pose { time_ns: at(1).time_ns, ..at(2) }));
    history.push(checked(at(3)));
    assert!(found_x(&history, at(1).time_ns).is_ok());
    assert!(found_x(&history, at(1).time_ns + 1).unwrap().is_finite());
}

#[test]
fn reading_continues_across_breaks_and_counts_what_was_pushed_out() {
    let mut history = filled(4, 0..3);
    history.break_off();
    assert!(history.is_empty());
    history.push(checked(at(3)));
    let (gone, poses) = history.since(1);
    assert_eq!((gone, poses.map(CameraPose::sequence).collect::<Vec<_>>()), (0, vec![1, 2, 3]));
    (4..10).for_each(|sequence| history.push(checked(at(sequence))));
    let (gone, poses) = history.since(4);
    assert_eq!((gone, poses.len()), (2, 4));
}

#[test]
fn fields_asked_for_must_be_known() {
    let valid = Validity::all().difference(Validity::POSITION);
    let mut history = History::new(4, LookupLimits::default());
    history.push(checked(Pose { validity: valid.bits(), ..at(0) }));
    let now = Time::Monotonic(at(0).time_ns);
    assert!(history.lookup(now).is_ok());
    let refused = history.lookup_with(now, Validity::POSITION).unwrap_err();
    assert_eq!(refused.to_string(), "not valid: position");
}

#[test]
fn prediction_can_be_forbidden() {
    let limits = LookupLimits { prediction: Duration::ZERO, ..LookupLimits::default() };
    let mut history = History::new(4, limits);
    history.push(checked(at(0)));
    let later = Time::Monotonic(at(0).time_ns + 1);
    assert!(matches!(history.lookup(later), Err(LookupError::TooNew { cap_ns: 0, .. })));
}
