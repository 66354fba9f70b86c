//! A lane at rest, and what a source may do to it.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use glam::DVec3;
use lodestone_config::model::{AxisMap, Camera, Config};
use lodestone_fusion::{Accel, Gyro, Mag, SensorTime};
use lodestone_schema::{
    Aiding, AidingKind, AnchorRefusal, CalibratedSample, LaneState, Pose, Status,
};

use super::{Core, LaneSettings, Phase, Publish, Worker};
use crate::clock::UnixOffset;
use crate::driver::SourceState;
use crate::reading::{HostTime, Reading, RecordedAiding};
use crate::status_board::LaneBoard;

const MS: i64 = 1_000_000;
/// Between two readings at 100 Hz.
const INTERVAL_MS: i64 = 10;

fn settings() -> LaneSettings {
    let camera = Camera { axis_map: Some(AxisMap::IDENTITY), ..Camera::default() };
    LaneSettings::new(&Config::default(), 0, &camera, None, 100.0).unwrap()
}

/// A level sensor at rest.
fn at_rest(time_ms: i64) -> Reading {
    Reading {
        epoch: 0,
        sensor_time: SensorTime::from_nanos(time_ms * MS),
        arrival: HostTime::from_nanos(time_ms * MS),
        gyro: Gyro::new(DVec3::ZERO),
        accel: Accel::new(DVec3::new(0.0, 0.0, 9.806_65)),
        mag: None,
        temperature_c: None,
        saturated: false,
        aiding: RecordedAiding::NONE,
    }
}

fn rest(from_ms: i64, for_ms: i64) -> impl Iterator<Item = Reading> {
    (0..for_ms / INTERVAL_MS).map(move |n| at_rest(from_ms + n * INTERVAL_MS))
}

fn take_all(core: &mut Core, readings: impl Iterator<Item = Reading>) {
    for reading in readings {
        core.take(&reading, |_| {});
    }
}

#[test]
fn given_one_time_stamp_far_ahead_then_the_lane_starts_anew_and_goes_on() {
    let mut core = Core::new(&settings());
    take_all(&mut core, rest(0, 3_000));
    assert_eq!(core.phase(), Phase::Running);
    let wrong = Reading { sensor_time: SensorTime::from_nanos(i64::MAX / 2), ..at_rest(3_000) };
    core.take(&wrong, |_| {});
    take_all(&mut core, rest(3_010, 5_000));
    assert_eq!(core.phase(), Phase::Running);
    assert!(core.counts().out_of_order <= 110, "{:?}", core.counts());
    assert_eq!(core.counts().resets, 2);
}

#[test]
fn given_a_clock_set_back_by_an_hour_then_the_lane_starts_anew_and_goes_on() {
    let mut core = Core::new(&settings());
    take_all(&mut core, rest(3_600_000, 3_000));
    take_all(&mut core, rest(0, 5_000));
    assert_eq!(core.phase(), Phase::Running);
    assert_eq!(core.counts().resets, 1);
}

#[test]
fn given_late_readings_shorter_than_a_reset_then_they_are_refused_and_nothing_else() {
    let mut core = Core::new(&settings());
    take_all(&mut core, rest(0, 3_000));
    take_all(&mut core, rest(1_000, 400));
    take_all(&mut core, rest(3_000, 100));
    take_all(&mut core, rest(1_000, 400));
    assert_eq!((core.counts().out_of_order, core.counts().resets), (80, 0));
    assert_eq!(core.phase(), Phase::Running);
}

#[derive(Clone, Default)]
struct Published(Rc<RefCell<Vec<Pose>>>);

impl Publish for Published {
    fn pose(&mut self, pose: &Pose) -> Option<HostTime> {
        self.0.borrow_mut().push(*pose);
        Some(HostTime::now())
    }

    fn sample(&mut self, _: &CalibratedSample) {}

    fn errors(&self) -> u64 {
        0
    }
}

impl Published {
    fn newest(&self) -> Pose {
        *self.0.borrow().last().expect("a pose")
    }
}

/// A live lane whose host clock is the readings' own.
struct Live {
    worker: Worker<Published>,
    published: Published,
    board: Arc<LaneBoard>,
}

impl Live {
    fn new() -> Self {
        let (published, board) = (Published::default(), Arc::new(LaneBoard::new()));
        let offset = UnixOffset::sampled();
        let worker = Worker::new(
            Core::new(&settings()),
            settings(),
            published.clone(),
            Arc::clone(&board),
            offset,
            1.0,
        );
        Self { worker, published, board }
    }

    fn take(&mut self, readings: impl Iterator<Item = Reading>) {
        for reading in readings {
            self.worker.take(&reading);
            self.worker.watch(SourceState::Streaming, reading.arrival);
        }
    }

    fn is_stale(&self) -> bool {
        Status::from_bits_retain(self.published.newest().status).contains(Status::SENSOR_STALE)
    }
}

#[test]
fn given_silence_then_one_stale_pose_is_published_and_counted_and_samples_bring_the_lane_back() {
    let mut live = Live::new();
    live.take(rest(0, 3_000));
    assert_eq!((live.board.state(), live.is_stale()), (LaneState::Running, false));
    let before = live.published.0.borrow().len();
    for ms in [3_050, 3_200, 3_300] {
        live.worker.watch(SourceState::Streaming, HostTime::from_nanos(ms * MS));
    }
    assert_eq!((live.board.state(), live.is_stale()), (LaneState::Lost, true));
    assert_eq!(live.published.newest().validity, 0);
    assert_eq!(live.published.0.borrow().len(), before + 1);
    assert_eq!(live.board.counters.poses.get(), before as u64 + 1);
    live.take(rest(3_350, 100));
    assert!(!live.is_stale());
    let times: Vec<_> = live.published.0.borrow().iter().map(|pose| pose.time_ns).collect();
    assert!(times.is_sorted());
}

#[test]
fn given_readings_that_cannot_be_used_then_the_lane_says_that_its_sensor_is_lost() {
    let mut live = Live::new();
    live.take(rest(0, 3_000));
    let broken = |r: Reading| Reading { gyro: Gyro::new(DVec3::NAN), ..r };
    live.take(rest(3_000, 500).map(broken));
    assert_eq!((live.board.state(), live.is_stale()), (LaneState::Lost, true));
    assert_eq!(live.board.counters.invalid.get(), 50);
}

#[test]
fn a_source_that_is_lost_before_its_first_reading_is_searched_for_and_afterwards_lost() {
    let mut live = Live::new();
    live.worker.watch(SourceState::Lost, HostTime::from_nanos(0));
    assert_eq!(live.board.state(), LaneState::Searching);
    live.take(rest(0, 3_000));
    live.worker.watch(SourceState::Lost, HostTime::from_nanos(3_000 * MS));
    assert_eq!(live.board.state(), LaneState::Lost);
    live.take(rest(3_000, 20));
    assert_eq!(live.board.state(), LaneState::Running);
}

#[test]
fn given_a_field_that_is_not_the_earths_at_the_place_then_each_step_says_so() {
    let unlike = |field_ut: DVec3| {
        let mut core = Core::new(&settings());
        let mut last = None;
        for reading in rest(0, 4_000) {
            let reading = Reading { mag: Some(Mag::new(field_ut)), ..reading };
            core.take(&reading, |step| last = Some(step.field_unlike_earth));
        }
        last.unwrap()
    };
    // At the default place the World Magnetic Model has 21 µT northward and 44 µT down.
    let earth = DVec3::new(21.0, 0.0, -44.0);
    assert!(!unlike(earth));
    assert!(!unlike(earth + DVec3::new(3.0, -4.0, 3.0)), "rooms are like that");
    assert!(unlike(earth + DVec3::new(30.0, 0.0, 15.0)), "a car's iron is not the earth's");
    assert!(unlike(DVec3::new(44.0, 0.0, -21.0)), "nor is another dip");
}

#[test]
fn given_a_measurement_against_what_is_no_anchor_then_it_is_refused_counted_and_said_why() {
    let mut live = Live::new();
    live.take(rest(0, 3_000));
    let message = |kind: AidingKind, anchor: u16| Aiding {
        sequence: 0,
        camera_id: 0,
        world_epoch: 0,
        kind: kind.code(),
        origin: 0,
        anchor,
        reserved: [0; 4],
        time_ns: 2_900 * MS,
        value: [0.0; 3],
        orientation: [0.0, 0.0, 0.0, 1.0],
        value_covariance: [1e-4, 0.0, 0.0, 1e-4, 0.0, 1e-4],
        orientation_covariance_rad2: [1e-6, 0.0, 0.0, 1e-6, 0.0, 1e-6],
        lever_arm_m: [0.0; 3],
    };
    // Anchors are counted from 1: this camera is the only one, and the first.
    let told = [
        (message(AidingKind::Pose, 1), AnchorRefusal::Itself),
        (message(AidingKind::Pose, 2), AnchorRefusal::Unknown),
        (message(AidingKind::Pose, u16::MAX), AnchorRefusal::Unknown),
        (message(AidingKind::Velocity, 2), AnchorRefusal::NoPose),
    ];
    for (k, (message, why)) in told.into_iter().enumerate() {
        live.worker.hear(&message);
        assert_eq!(live.board.anchor_refusal(), why);
        assert_eq!(live.board.counters.aiding_refused.get(), k as u64 + 1);
    }
    assert_eq!(live.board.counters.aiding_used.get(), 0);
}
