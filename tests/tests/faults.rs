//! Faults between camera and lane, by configuration, in a daemon that serves twelve cameras with
//! one fault each, one without, and two in worlds that run faster than time.
//!
//! Every camera gives five seconds of samples at exactly 400 Hz and ends, so that the counters in
//! the last health message are known to the sample.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::collections::BTreeMap;
use std::fmt::Write;
use std::thread::sleep;
use std::time::{Duration, Instant};

use lodestone_client::{
    Client, Health, HealthStream, LaneState, Pose, PoseStream, Status, Validity,
};
use lodestone_tests::system::{Daemon, PATIENCE, TestDomain, eventually};

/// Samples of each camera: 5 s at 400 Hz.
const SAMPLES: u64 = 2000;

/// Faults begin after alignment.
const AT_S: f64 = 2.5;

/// Name of the camera, kind of its fault, duration s.
const FAULTS: [(&str, &str, f64); 12] = [
    ("drop", "drop", 0.08),
    ("duplicate", "duplicate", 0.3),
    ("backwards", "time-backwards", 0.3),
    ("stuck", "stuck", 0.3),
    ("nan", "not-a-number", 0.3),
    ("infinite", "infinite", 0.3),
    ("saturated", "saturated", 0.3),
    ("huge", "huge", 0.3),
    ("unplug", "unplug", 0.6),
    ("stall", "stall", 0.3),
    ("no-magnetometer", "no-magnetometer", 1.5),
    ("reorder", "reorder", 0.3),
];

const CLEAN: &str = "clean";

/// Its world runs twice as fast as time.
const TWICE: &str = "twice";

/// Its world runs as fast as it goes, on a clock of its own.
const AT_ONCE: &str = "at-once";

fn names() -> impl Iterator<Item = &'static str> {
    FAULTS.iter().map(|fault| fault.0).chain([CLEAN, TWICE, AT_ONCE])
}

fn cameras() -> String {
    let mut text = String::new();
    for (seed, name) in names().enumerate() {
        let speed = match name {
            TWICE => 2.0,
            AT_ONCE => 0.0,
            _ => 1.0,
        };
        let source =
            format!("trajectory = \"standing\", rest_s = 1.0, duration_s = 5.0, speed = {speed:?}");
        writeln!(text, "[[camera]]\nname = \"{name}\"\ndriver = \"synthetic\"").unwrap();
        writeln!(text, "synthetic = {{ {source}, seed = {seed} }}").unwrap();
        // All stand in one place: without a start, nobody knows where but of the first.
        writeln!(text, "start = {{ position_m = [0.0, 0.0, 0.0] }}").unwrap();
        for (_, kind, duration_s) in FAULTS.iter().filter(|fault| fault.0 == name) {
            writeln!(text, "[[camera.fault]]\nkind = \"{kind}\"").unwrap();
            writeln!(text, "at_s = {AT_S}\nduration_s = {duration_s}").unwrap();
        }
    }
    text
}

/// One camera, followed to its end.
struct Followed {
    poses: PoseStream,
    health: HealthStream,
    /// What the poses said, all together.
    seen: Seen,
}

#[derive(Default)]
struct Seen {
    /// Sequence of the first pose received: poses before it came before this consumer did.
    first: Option<u64>,
    received: u64,
    lost: u64,
    invalid: u64,
    oriented: u64,
    status: Status,
    /// Poses without an orientation after the first with one.
    fell_back: u64,
    most_resets: u32,
    held_headings: u64,
    last_health: Option<Health>,
    /// Sensor time and host time of the latest pose, ns.
    last_times_ns: Option<(i64, i64)>,
    /// Host seconds per sensor second between neighbouring poses, once the clocks are known.
    host_rates: Vec<f64>,
}

impl Seen {
    fn pose(&mut self, pose: &Pose) {
        let status = Status::from_bits_truncate(pose.status);
        self.first.get_or_insert(pose.sequence);
        self.received += 1;
        self.follow_clock(pose);
        self.status |= status;
        self.most_resets = self.most_resets.max(pose.reset_counter);
        self.held_headings += u64::from(pose.heading_source == 2);
        if status.contains(Status::INITIALISED) {
            self.oriented += 1;
            assert_usable(pose);
        } else {
            self.fell_back += u64::from(self.oriented > 0);
            assert_eq!(pose.validity & !Validity::TIME.bits(), 0, "{pose:?}");
        }
    }

    fn follow_clock(&mut self, pose: &Pose) {
        let (sensor_ns, host_ns) = (pose.sensor_time_ns, pose.time_ns);
        let before = self.last_times_ns.replace((sensor_ns, host_ns));
        if let Some((sensor_before_ns, host_before_ns)) = before.filter(|_| self.oriented > 400) {
            let (host, sensor) = (host_ns - host_before_ns, sensor_ns - sensor_before_ns);
            self.host_rates.push(host as f64 / sensor as f64);
        }
    }
}

/// Finite throughout, with a unit quaternion.
fn assert_usable(pose: &Pose) {
    let norm = pose.orientation.iter().map(|x| x * x).sum::<f64>();
    assert!((norm - 1.0).abs() < 1e-9, "{pose:?}");
    let vectors = [pose.position_m, pose.velocity_m_s, pose.angular_rate_rad_s];
    let finite = vectors.iter().flatten().chain(&pose.specific_force_m_s2).all(|x| x.is_finite());
    assert!(finite, "{pose:?}");
    assert!(pose.orientation_covariance_rad2.iter().all(|x| x.is_finite()), "{pose:?}");
}

impl Followed {
    fn look(&mut self) {
        let batch = self.poses.all();
        self.seen.lost += batch.lost;
        self.seen.invalid += batch.invalid;
        for pose in batch {
            self.seen.pose(pose.message());
        }
        let health = self.health.all();
        self.seen.invalid += health.invalid;
        self.seen.last_health =
            health.into_iter().next_back().map(|h| *h.message()).or(self.seen.last_health);
    }

    fn has_ended(&self) -> bool {
        let ended = LaneState::Ended.code();
        self.seen.last_health.is_some_and(|health| health.state == ended)
    }
}

/// Follows all cameras until each has ended, each on a thread of its own: on a starved machine, one consumer
/// after the other would be connected too late.
fn follow_to_the_end(domain: &TestDomain) -> BTreeMap<String, Seen> {
    std::thread::scope(|scope| {
        let started: Vec<_> =
            names().map(|name| scope.spawn(move || follow(domain, name))).collect();
        names().map(str::to_owned).zip(started.into_iter().map(|s| s.join().unwrap())).collect()
    })
}

/// Follows one camera until it has ended.
fn follow(domain: &TestDomain, name: &str) -> Seen {
    let client = eventually("the daemon is there", || {
        Client::builder().prefix(&domain.prefix).root(&domain.root).connect().ok()
    });
    let poses = client.pose_stream(name).unwrap().capacity(4096).open();
    let health = client.health(name).unwrap();
    let mut camera = Followed { poses, health, seen: Seen::default() };
    let begin = Instant::now();
    while !camera.has_ended() {
        assert!(begin.elapsed() < PATIENCE, "{name} never ended");
        camera.look();
        sleep(Duration::from_millis(5));
    }
    camera.look();
    camera.seen
}

#[test]
fn given_a_fault_on_each_of_twelve_cameras_then_each_is_counted_and_the_others_are_untouched() {
    let domain = TestDomain::new();
    // Followed from the first: where the machine is busy, some cameras end before the last ones begin.
    let daemon = Daemon::spawn(&domain.configuration(&cameras()));
    let seen = follow_to_the_end(&domain);
    let (code, log) = daemon.ended();
    assert_eq!(code, Some(0), "{log}");
    assert!(log.contains("every source ended"), "{log}");
    assert!(!log.contains("panicked"), "{log}");

    for (name, seen) in &seen {
        let health = seen.last_health.unwrap();
        println!(
            "{name:16} joined after {:4}: {:5} poses, {:4} missed, {:5} oriented, {:4} held, {:?}; samples {} lost {} \
             bridged {} duplicates {} late {} invalid {} reconnects {} resets {}",
            seen.first.unwrap_or_default(),
            seen.received,
            seen.lost,
            seen.oriented,
            seen.held_headings,
            seen.status,
            health.samples,
            health.samples_lost,
            health.steps_bridged,
            health.duplicates,
            health.out_of_order,
            health.invalid,
            health.reconnects,
            health.resets,
        );
    }
    for (name, seen) in &seen {
        assert_eq!(seen.invalid, 0, "{name}: messages that no consumer can use");
        // What runs as fast as it goes has ended before anybody listens.
        let enough = seen.oriented > 800 || name == AT_ONCE;
        assert!(enough, "{name}: only {} poses after the alignment", seen.oriented);
        assert_counts(name, seen);
        assert_status(name, seen);
    }
}

/// What the last health message must have counted.
#[derive(Debug, Default, PartialEq)]
struct Counts {
    samples: u64,
    lost: u64,
    duplicates: u64,
    out_of_order: u64,
    invalid: u64,
    reconnects: u64,
    resets: u64,
}

fn assert_counts(name: &str, seen: &Seen) {
    let h = seen.last_health.unwrap();
    let counted = Counts {
        samples: h.samples,
        lost: h.samples_lost,
        duplicates: h.duplicates,
        out_of_order: h.out_of_order,
        invalid: h.invalid,
        reconnects: h.reconnects,
        resets: h.resets,
    };
    let all = Counts { samples: SAMPLES, ..Counts::default() };
    let expected = match name {
        "drop" => Counts { samples: SAMPLES - 32, lost: 32, ..all },
        "duplicate" => Counts { samples: SAMPLES + 120, duplicates: 120, ..all },
        // The first of the mirrored stamps is its own mirror image.
        "backwards" => Counts { out_of_order: 119, lost: 119, ..all },
        "nan" | "infinite" | "huge" => Counts { invalid: 120, lost: 120, ..all },
        // How long a source was away is not known, so nothing is counted as lost.
        "unplug" => Counts { samples: SAMPLES - 240, reconnects: 1, resets: 1, ..all },
        "reorder" => Counts { out_of_order: 60, lost: 60, ..all },
        _ => all,
    };
    assert_eq!(counted, expected, "{name}");
    assert_eq!((h.ring_dropped, h.publish_errors), (0, 0), "{name}");
    assert_eq!(u64::from(seen.most_resets), expected.resets, "{name}");
}

fn assert_status(name: &str, seen: &Seen) {
    let expected = match name {
        "drop" => Status::BRIDGED,
        "backwards" | "nan" | "infinite" | "huge" => Status::DEGRADED,
        "saturated" => Status::SATURATED,
        "unplug" | "stall" => Status::SENSOR_STALE,
        _ => Status::empty(),
    };
    // A consumer that was starved may have missed just those poses: it has counted them.
    let missed = seen.lost > 0 || seen.first != Some(0);
    assert!(missed || seen.status.contains(expected), "{name}: {:?}", seen.status);
    // Only a source that was opened again has to be aligned again.
    assert_eq!(seen.fell_back > 0, name == "unplug", "{name}: {}", seen.fell_back);
    let health = seen.last_health.unwrap();
    if [CLEAN, TWICE, AT_ONCE].contains(&name) {
        let wrong = Status::BRIDGED | Status::DEGRADED | Status::SATURATED;
        assert!(!seen.status.intersects(wrong), "{name}: {:?}", seen.status);
        let last = Status::from_bits_truncate(health.status);
        assert!(last.contains(Status::INITIALISED), "{name}: {last:?}");
    }
    if name == CLEAN {
        let joined_after = seen.first.unwrap_or_default();
        assert_eq!(joined_after + seen.received + seen.lost, health.poses, "{name}");
        assert_host_rate(name, seen, 1.0);
    }
    if name == TWICE {
        assert_host_rate(name, seen, 0.5);
    }
    if name == AT_ONCE {
        let last = Status::from_bits_truncate(health.status);
        assert!(!last.contains(Status::SENSOR_STALE), "{name}: {last:?}");
        assert_eq!(health.poses, SAMPLES - 1, "{name}: poses were repeated as stale");
    }
}

/// Poses follow each other in host time as they do in sensor time, times a rate; a restart of the
/// mapping on a starved machine may spoil a few.
fn assert_host_rate(name: &str, seen: &Seen, rate: f64) {
    let close = seen.host_rates.iter().filter(|r| (*r / rate - 1.0).abs() < 0.05).count();
    let all = seen.host_rates.len();
    assert!(all > 500 && close * 10 > all * 9, "{name}: {close} of {all} steps at rate {rate}");
}
