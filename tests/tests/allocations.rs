//! What a running lane allocates: nothing of its own.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use lodestone_client::Domain;
use lodestone_config::Config;
use lodestone_config::model::{
    Camera, DriverKind, Fault, FaultKind, Replay, SharedMemory, TrajectoryKind, World,
};
use lodestone_daemon::clock::UnixOffset;
use lodestone_daemon::driver::faulty::FaultyDriver;
use lodestone_daemon::driver::replay::ReplayDriver;
use lodestone_daemon::driver::synthetic::SyntheticDriver;
use lodestone_daemon::driver::{Driver, SourceState};
use lodestone_daemon::lane::{Core, LaneSettings, Publish, Worker};
use lodestone_daemon::publisher::LanePublisher;
use lodestone_daemon::reading::HostTime;
use lodestone_daemon::ring::{Consumer, Producer, ring};
use lodestone_daemon::status_board::LaneBoard;
use lodestone_schema::{CalibratedSample, Pose};
use lodestone_tests::system::{Counting, Recorded, TestDomain, counted, synthetic_camera};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const WARM_UP: u64 = 2_000;
const COUNTED: u64 = 20_000;
/// Enough for both, with samples lost on purpose; s at 400 Hz.
const DURATION_S: f64 = 70.0;

/// Takes messages and drops them.
struct Nowhere;

impl Publish for Nowhere {
    fn pose(&mut self, _: &Pose) -> Option<HostTime> {
        Some(HostTime::now())
    }

    fn sample(&mut self, _: &CalibratedSample) {}

    fn errors(&self) -> u64 {
        0
    }
}

/// A lane on this thread, as the daemon's pipeline runs it.
struct Lane<P> {
    driver: Box<dyn Driver>,
    producer: Producer,
    consumer: Consumer,
    worker: Worker<P>,
    board: Arc<LaneBoard>,
}

impl<P: Publish> Lane<P> {
    fn new(camera: &Camera, driver: impl Driver + 'static, publisher: P) -> Self {
        let config = Config::default();
        let rate_hz = driver.info().nominal_rate_hz;
        let settings = LaneSettings::new(&config, 0, camera, None, rate_hz)
            .expect("magnetic north needs no model");
        let board = Arc::new(LaneBoard::new());
        let offset = UnixOffset::sampled();
        let core = Core::new(&settings);
        let worker = Worker::new(core, settings, publisher, Arc::clone(&board), offset, 1.0);
        let (producer, consumer) = ring(config.lane.ring_capacity);
        Self { driver: Box::new(driver), producer, consumer, worker, board }
    }

    /// Runs until so many readings went through; gives how many did.
    fn run(&mut self, readings: u64) -> u64 {
        let mut taken = 0;
        while taken < readings {
            let state = self.driver.poll(Duration::ZERO, &mut self.producer);
            let mut now = None;
            while let Some(reading) = self.consumer.pop() {
                self.worker.take(&reading, reading.arrival);
                now = Some(reading.arrival);
                taken += 1;
            }
            if let Some(now) = now {
                self.worker.watch(state, now);
            }
            if state == SourceState::Ended {
                break;
            }
        }
        taken
    }

    /// Poses published so far.
    fn poses(&self) -> u64 {
        self.board.counter_values().poses
    }
}

fn camera() -> Camera {
    synthetic_camera(TrajectoryKind::Walk, 1, DURATION_S)
}

fn synthetic() -> SyntheticDriver {
    SyntheticDriver::new(&camera(), &World::default()).unwrap()
}

/// Warms a lane up, counts, and expects that poses came and nothing was allocated.
fn assert_allocates_nothing(mut lane: Lane<Nowhere>) {
    assert!(lane.run(WARM_UP) >= WARM_UP);
    let poses_before = lane.poses();
    let mut taken = 0;
    let allocations = counted(|| taken = lane.run(COUNTED));
    assert!(taken >= COUNTED, "only {taken} readings");
    assert!(lane.poses() > poses_before + COUNTED / 2, "hardly any poses");
    assert_eq!(allocations, 0, "in {taken} readings");
}

#[test]
fn the_counter_counts() {
    assert_eq!(counted(|| drop(std::hint::black_box(Box::new(1)))), 1);
}

#[test]
fn a_lane_on_a_synthetic_camera_allocates_nothing() {
    assert_allocates_nothing(Lane::new(&camera(), synthetic(), Nowhere));
}

#[test]
fn a_lane_on_a_recording_allocates_nothing() {
    let directory = tempfile::tempdir().unwrap();
    Recorded::of(TrajectoryKind::Walk, 1, DURATION_S).write(&directory.path().join("walk.csv"));
    let settings = Replay { file: "walk.csv".into(), speed: 0.0, repeat: false };
    let driver = ReplayDriver::open(&settings, Path::new(directory.path())).unwrap();
    let camera = Camera { driver: DriverKind::Replay, ..camera() };
    assert_allocates_nothing(Lane::new(&camera, driver, Nowhere));
}

#[test]
fn a_lane_that_meets_every_fault_allocates_nothing() {
    let kinds = [
        FaultKind::Drop,
        FaultKind::Duplicate,
        FaultKind::TimeBackwards,
        FaultKind::Stuck,
        FaultKind::NotANumber,
        FaultKind::Infinite,
        FaultKind::Saturated,
        FaultKind::Huge,
        FaultKind::Stall,
        FaultKind::NoMagnetometer,
        FaultKind::Reorder,
        FaultKind::Unplug,
    ];
    let fault = |(n, kind)| Fault { kind, at_s: 8.0 + 3.0 * n as f64, duration_s: 0.5 };
    let faults: Vec<Fault> = kinds.into_iter().enumerate().map(fault).collect();
    // It aligns again after the unplugging, for which it must rest.
    let camera = synthetic_camera(TrajectoryKind::Standing, 1, DURATION_S);
    let driver = SyntheticDriver::new(&camera, &World::default()).unwrap();
    let lane = Lane::new(&camera, FaultyDriver::new(driver, &faults), Nowhere);
    assert_allocates_nothing(lane);
}

/// The one test of this program that enters a domain, which a process can do once.
#[test]
fn a_lane_that_publishes_costs_one_allocation_of_iceoryx2_for_each_message() {
    let place = TestDomain::new();
    let domain = Domain { prefix: place.prefix.clone(), root: place.root.clone() };
    let shared_memory =
        SharedMemory { pose_history: 64, max_subscribers: 2, ..SharedMemory::default() };
    let publisher = LanePublisher::open(&domain, &shared_memory, "front").unwrap();
    let mut lane = Lane::new(&camera(), synthetic(), publisher);
    lane.run(WARM_UP);
    let poses_before = lane.poses();
    let mut samples = 0;
    let allocations = counted(|| samples = lane.run(COUNTED));
    let poses = lane.poses() - poses_before;
    assert!(samples >= COUNTED && poses > COUNTED / 2, "{samples} samples, {poses} poses");
    assert_eq!(lane.board.counter_values().publish_errors, 0);
    assert_eq!(allocations, samples + poses, "{samples} samples and {poses} poses");
}
