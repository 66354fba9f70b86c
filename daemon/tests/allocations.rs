//! What the lane's end allocates: exactly iceoryx2's one per message, and nothing of ours.
#![allow(unsafe_code)] // A global allocator is an unsafe trait.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::fmt::Write as _;
use std::sync::Arc;

use common::{in_child, own_domain, pose, sample, small};
use lodestone_config::Loaded;
use lodestone_config::model::Config;
use lodestone_daemon::clock::UnixOffset;
use lodestone_daemon::lane::Publish;
use lodestone_daemon::publisher::LanePublisher;
use lodestone_daemon::reading::{HostTime, Reading, RecordedAiding};
use lodestone_daemon::rig::{Outlet, RigCore, RigSettings, RigWorker};
use lodestone_daemon::status_board::{LaneBoard, LaneStatus, SensorStatus};
use lodestone_schema::{LaneState, Pose, ServiceKind};

struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
    static RELEASES: Cell<u64> = const { Cell::new(0) };
}

fn count(counter: &'static std::thread::LocalKey<Cell<u64>>) {
    // A thread that is ending has no counters left, and nothing to count.
    let _ = counter.try_with(|n| n.set(n.get() + 1));
}

// SAFETY: every call goes to the system's allocator with the arguments unchanged; counting in a
// constant-initialised thread-local without destructor does not allocate.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(&ALLOCATIONS);
        // SAFETY: the caller's promise, handed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(&RELEASES);
        // SAFETY: the caller's promise, handed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn counted(work: impl FnOnce()) -> (u64, u64) {
    let before = (ALLOCATIONS.get(), RELEASES.get());
    work();
    (ALLOCATIONS.get() - before.0, RELEASES.get() - before.1)
}

#[test]
fn a_message_costs_the_one_allocation_of_iceoryx2_and_reporting_costs_none() {
    in_child("a_message_costs_the_one_allocation_of_iceoryx2_and_reporting_costs_none", || {
        let (domain, _root) = own_domain("alloc");
        let mut publisher = LanePublisher::open(&domain, &small(), "front").unwrap();
        let node = domain.open_node("alloc").unwrap();
        let service = lodestone_schema::transport::open_for_reading::<Pose>(
            &node,
            ServiceKind::Pose,
            "front",
        );
        let _consumer = service.unwrap().subscriber_builder().create().unwrap();
        let board = LaneBoard::new();
        // The consumer joins at the first send.
        publisher.publish_pose(&pose(0)).unwrap();

        let poses = counted(|| {
            assert!((1..=1000).all(|n| publisher.publish_pose(&pose(n)).is_some()));
        });
        let samples = counted(|| (0..1000).for_each(|n| publisher.publish_sample(&sample(n))));
        let reports = counted(|| {
            for n in 0..1000 {
                board.counters.samples.add(1);
                board.latency.record(n);
                board.latest.report(&LaneStatus::of(&pose(n as u64), SensorStatus::default()));
                board.set_state(LaneState::Running);
            }
        });

        assert_eq!(poses, (1000, 1000));
        assert_eq!(samples, (1000, 1000));
        assert_eq!(reports, (0, 0));
        assert!(
            counted(|| drop(std::hint::black_box(Box::new(1)))) == (1, 1),
            "the counter counts"
        );
    });
}

/// Takes messages and keeps none.
struct Nowhere;

impl Publish for Nowhere {
    fn pose(&mut self, pose: &Pose) -> Option<HostTime> {
        Some(HostTime::from_nanos(pose.arrival_time_ns))
    }

    fn sample(&mut self, _: &lodestone_schema::CalibratedSample) {}

    fn errors(&self) -> u64 {
        0
    }
}

/// Three cameras on one body.
fn rig() -> Loaded {
    let mut text = String::from("[[body]]\nname = \"rig\"\n");
    for (name, x, y) in [("a", 0.3, 0.0), ("b", -0.15, 0.25), ("c", -0.15, -0.25)] {
        write!(
            text,
            "[[camera]]\nname = \"{name}\"\ndriver = \"synthetic\"\nbody = \"rig\"\n\
             axis_map = [\"x\", \"y\", \"z\"]\n[camera.mounting]\nposition_m = [{x}, {y}, 0.0]\n"
        )
        .unwrap();
    }
    let config = Config::from_toml("rig", &text).unwrap();
    Loaded { config, path: std::path::PathBuf::new() }
}

/// A level camera that is turned slowly to and fro, with a magnetometer.
fn reading(n: i64) -> Reading {
    let mut random = n.wrapping_mul(6_364_136_223_846_793_005).rotate_left(17) % 1000;
    let mut small = || {
        random = random.wrapping_mul(48_271) % 2_147_483_647;
        (random % 1000) as f64 * 1e-6
    };
    let time = 1_000_000_000 + n * 2_500_000;
    Reading {
        sensor_time: lodestone_fusion::SensorTime::from_nanos(time),
        arrival: HostTime::from_nanos(time + 100_000),
        gyro: lodestone_fusion::Gyro::new(glam::DVec3::new(small(), small(), small())),
        accel: lodestone_fusion::Accel::new(glam::DVec3::new(small(), small(), 9.81 + small())),
        mag: (n % 8 == 0)
            .then(|| lodestone_fusion::Mag::new(glam::DVec3::new(20.0 + small(), small(), -43.0))),
        temperature_c: None,
        saturated: false,
        epoch: 0,
        aiding: RecordedAiding::NONE,
    }
}

#[test]
fn a_rigs_lane_allocates_nothing_after_it_was_made() {
    let loaded = rig();
    let rig = loaded.config.rigs().remove(0);
    let settings = RigSettings::new(&loaded, &rig, &[400.0; 3]).unwrap();
    let outlet = || Outlet { publisher: Nowhere, board: Arc::new(LaneBoard::new()) };
    let members = (0..3).map(|_| (outlet(), 1.0)).collect();
    let core = RigCore::new(&settings);
    let mut worker = RigWorker::new(core, settings, outlet(), members, UnixOffset::sampled());
    let mut feed = |from: i64, to: i64, present: &[usize]| {
        for n in from..to {
            for (noise, &member) in (3 * n..).zip(present) {
                let reading = reading(noise).at(n);
                worker.take(member, &reading, reading.arrival);
            }
        }
    };
    feed(0, 100, &[0, 1, 2]);
    let counted = counted(|| {
        feed(100, 2000, &[0, 1, 2]);
        // One is silent for a while, and comes back.
        feed(2000, 2400, &[0, 2]);
        feed(2400, 4400, &[0, 1, 2]);
    });
    assert_eq!(counted, (0, 0));
}

trait At {
    /// The same, taken at another step.
    fn at(self, step: i64) -> Self;
}

impl At for Reading {
    fn at(self, step: i64) -> Self {
        let time = 1_000_000_000 + step * 2_500_000;
        Self {
            sensor_time: lodestone_fusion::SensorTime::from_nanos(time),
            arrival: HostTime::from_nanos(time + 100_000),
            ..self
        }
    }
}
