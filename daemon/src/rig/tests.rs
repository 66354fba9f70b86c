//! A rig's lane from readings to poses, in simulated worlds.

use std::path::PathBuf;
use std::time::Duration;

use glam::DVec3;
use lodestone_config::model::{Config, Rig};
use lodestone_config::{Config as Checked, Loaded};
use lodestone_fusion::rig::{Exclusion, GradientVerdict};
use lodestone_schema::Status;

use super::{RigCore, RigSettings, RigStep};
use crate::driver::synthetic::{SyntheticDriver, Truth};
use crate::driver::{Driver, SourceState};
use crate::lane::status_of;
use crate::reading::Reading;

/// The shipped rig, played as fast as it goes for so long.
fn shipped(duration_s: f64, change: impl Fn(&mut Config)) -> Loaded {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../config/shipped/rig.toml");
    let mut loaded = Checked::load(path).unwrap();
    loaded.config.world.year = Some(2026.0);
    for camera in &mut loaded.config.camera {
        camera.imu_delay_s = 0.0;
        let synthetic = camera.synthetic.get_or_insert_default();
        (synthetic.speed, synthetic.duration_s) = (0.0, duration_s);
    }
    change(&mut loaded.config);
    loaded
}

/// Every camera's readings at their true times, and the driver, which knows the truth.
struct Played {
    driver: SyntheticDriver,
    readings: Vec<Reading>,
}

fn play(config: &Config) -> Vec<Played> {
    let play = |camera| {
        let leader = config.leader_of(camera);
        let mut driver = SyntheticDriver::riding(camera, leader, &config.world).unwrap();
        let mut readings = Vec::new();
        while driver.poll(Duration::ZERO, &mut readings) != SourceState::Ended {}
        Played { driver, readings }
    };
    config.camera.iter().map(play).collect()
}

/// Feeds the members' readings in order of arrival, on the host's clock; `use_it` may drop some.
fn follow(
    loaded: &Loaded,
    played: &[Played],
    use_it: impl Fn(usize, f64) -> bool,
    mut on_step: impl FnMut(&RigStep<'_>),
) -> RigCore {
    let rig: Rig = loaded.config.rigs().remove(0);
    let settings = RigSettings::new(loaded, &rig, &[400.0; 3]).unwrap();
    let mut core = RigCore::new(&settings);
    let mut all: Vec<(usize, &Reading)> = played
        .iter()
        .enumerate()
        .flat_map(|(k, played)| played.readings.iter().map(move |reading| (k, reading)))
        .collect();
    all.sort_by_key(|(k, reading)| (reading.arrival, *k));
    for (member, reading) in all {
        let time = lodestone_fusion::SensorTime::from_nanos(reading.arrival.as_nanos());
        if use_it(member, reading.arrival.as_nanos() as f64 * 1e-9) {
            core.take(member, reading, time, &mut on_step);
        }
    }
    core
}

/// The truth of a member at a time on the host's clock, s.
fn truth_at(played: &Played, time_s: f64) -> Truth {
    let first = &played.readings[0];
    let since = (time_s * 1e9) as i64 - first.arrival.as_nanos();
    let at = first.sensor_time + lodestone_fusion::SensorSpan::from_nanos(since);
    played.driver.truth_at(at)
}

#[test]
fn each_members_pose_is_its_own_and_the_gradient_opens_past_steel() {
    let loaded = shipped(40.0, |_| {});
    let played = play(&loaded.config);
    let (mut tilts, mut arms, mut open) = (Vec::new(), Vec::new(), 0);
    let core = follow(
        &loaded,
        &played,
        |_, _| true,
        |step| {
            open += usize::from(
                step.report.gradient.is_some_and(|g| g.verdict == GradientVerdict::Open),
            );
            let (Some(one), Some(other)) = (step.member(0).estimate, step.member(1).estimate)
            else {
                return;
            };
            let time_s = step.body.time.as_nanos() as f64 * 1e-9;
            let truths = [truth_at(&played[0], time_s), truth_at(&played[1], time_s)];
            let up = truths[0].orientation.inverse().apply(DVec3::Z);
            tilts.push(one.orientation.apply(up).truncate().length());
            // What lies between the cameras is surveyed: only the attitude can turn it.
            let seen = one.orientation.inverse().apply(other.position - one.position);
            let between = truths[1].position_m - truths[0].position_m;
            let exact = truths[0].orientation.inverse().apply(between);
            arms.push((seen - exact).length());
        },
    );
    let largest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    assert!(tilts.len() > 10_000 && largest(&tilts) < 0.03, "tilt {}", largest(&tilts));
    assert!(largest(&arms) < 1e-3, "arm {}", largest(&arms));
    assert!(open > 0, "steel bends the field there");
    assert_eq!(core.resets(), 0);
}

#[test]
fn an_unplugged_member_is_left_out_and_taken_back_and_the_rig_goes_on() {
    let loaded = shipped(24.0, |_| {});
    let played = play(&loaded.config);
    let away = |time_s: f64| (10.0..13.0).contains(&time_s);
    let (mut last, mut longest, mut silent) = (None, 0, 0);
    let core = follow(
        &loaded,
        &played,
        |member, time_s| member != 2 || !away(time_s - start_s(&played)),
        |step| {
            let now = step.body.time.as_nanos();
            longest = longest.max(last.replace(now).map_or(0, |last| now - last));
            silent += usize::from(step.is_silent(2));
        },
    );
    assert_eq!(longest, 2_500_000, "a step is missing");
    assert!((1100..2500).contains(&silent), "{silent} steps without it");
    assert_eq!(core.status(2).exclusion, None);
    assert_eq!(core.resets(), 0);
}

fn start_s(played: &[Played]) -> f64 {
    played[0].readings[0].arrival.as_nanos() as f64 * 1e-9
}

#[test]
fn a_member_whose_values_are_stuck_is_voted_out() {
    let loaded = shipped(16.0, |_| {});
    let mut played = play(&loaded.config);
    let from = played[1].readings.len() - 1200;
    let held = played[1].readings[from];
    for reading in &mut played[1].readings[from..] {
        (reading.gyro, reading.accel) = (held.gyro, held.accel);
    }
    let mut last = Status::empty();
    let core =
        follow(&loaded, &played, |_, _| true, |step| last = status_of(&step.member(0), false));
    let why = core.status(1).exclusion;
    assert!(last.contains(Status::ON_BODY | Status::MEMBER_OUT), "{last:?}");
    assert!(matches!(why, Some(Exclusion::Stuck | Exclusion::Deviating)), "{why:?}");
    assert_eq!(core.status(0).exclusion.or(core.status(2).exclusion), None);
}

#[test]
fn the_same_readings_give_the_same_bits() {
    let loaded = shipped(12.0, |_| {});
    let played = play(&loaded.config);
    let poses = || {
        let mut poses = Vec::new();
        follow(&loaded, &played, |_, _| true, |step| poses.push(step.body.estimate));
        poses
    };
    assert_eq!(poses(), poses());
}
