//! The stand-in for a daemon: this test program run again, told what to do through a pipe.

use std::env;
use std::io::{BufRead, BufReader, Write, stdin};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread::{sleep, spawn};
use std::time::Duration;

use iceoryx2::port::publisher::Publisher as Port;
use iceoryx2::prelude::{ServiceName, ipc};
use lodestone_client::{Domain, Health, OpenError, Pose, Status, Validity, monotonic_now_ns};
use lodestone_schema::ServiceKind;
use lodestone_schema::transport::{Qos, open_for_writing};

use super::TestDomain;

const CAMERA: &str = "LODESTONE_TEST_CAMERA";
const VERSION: &str = "LODESTONE_TEST_VERSION";
const HISTORY: &str = "LODESTONE_TEST_HISTORY";
const STEP: Duration = Duration::from_micros(2500);
/// UNIX time of the synthetic world minus monotonic time, ns.
pub(crate) const UNIX_OFFSET_NS: i64 = 1_700_000_000_000_000_000;

/// A publisher in its own process; dies with this value.
pub(crate) struct Publisher {
    child: Child,
    orders: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

impl Publisher {
    /// Starts one that keeps so many poses for late consumers.
    pub(crate) fn start(domain: &TestDomain, camera: &str, history: usize) -> Self {
        Self::try_start(domain, camera, history).expect("gets ready")
    }

    /// The same; `None` if the service cannot be had with this history.
    pub(crate) fn try_start(domain: &TestDomain, camera: &str, history: usize) -> Option<Self> {
        Self::spawn(domain, camera, history, 1)
    }

    /// Starts one of another schema version, which publishes nothing.
    pub(crate) fn start_version(domain: &TestDomain, camera: &str, version: u32) -> Self {
        Self::spawn(domain, camera, 1, version).expect("gets ready")
    }

    fn spawn(domain: &TestDomain, camera: &str, history: usize, version: u32) -> Option<Self> {
        let mut child = Command::new(env::current_exe().expect("this program"))
            .args(["--exact", "publisher_process", "--ignored", "--nocapture"])
            .env("LODESTONE_SHM_PREFIX", &domain.prefix)
            .env("LODESTONE_SHM_ROOT", &domain.root)
            .env(CAMERA, camera)
            .env(HISTORY, history.to_string())
            .env(VERSION, version.to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("starts");
        let orders = child.stdin.take();
        let answers = BufReader::new(child.stdout.take().expect("a pipe"));
        let mut publisher = Self { child, orders, answers };
        publisher.answers("ready").then_some(publisher)
    }

    /// Publishes so many poses at once, a step apart by their times, up to now.
    pub(crate) fn burst(&mut self, poses: u64) {
        self.order(&format!("burst {poses}"));
        assert!(self.answers("done"), "the publisher has ended");
    }

    /// Publishes 400 poses a second, and health, from now on.
    pub(crate) fn run(&mut self) {
        self.order("run");
        assert!(self.answers("done"), "the publisher has ended");
    }

    /// kill -9.
    pub(crate) fn kill(mut self) {
        self.child.kill().expect("kills");
        self.child.wait().expect("is gone");
    }

    fn order(&mut self, text: &str) {
        let orders = self.orders.as_mut().expect("a pipe");
        writeln!(orders, "{text}").expect("writes");
    }

    /// Whether this answer comes before the publisher ends.
    fn answers(&mut self, answer: &str) -> bool {
        let mut line = String::new();
        while self.answers.read_line(&mut line).expect("reads") > 0 {
            // The test harness writes to the same pipe.
            if line.trim_end().ends_with(answer) {
                return true;
            }
            line.clear();
        }
        false
    }
}

impl Drop for Publisher {
    fn drop(&mut self) {
        // The end of its orders ends the process.
        drop(self.orders.take());
        let _ = self.child.wait();
    }
}

/// What the publisher process does; nothing if it was not started by [`Publisher::start`].
pub(crate) fn publish_as_ordered() {
    let Ok(camera) = env::var(CAMERA) else { return };
    let number = |variable| env::var(variable).expect("is set").parse().expect("a number");
    if number(VERSION) == 1 {
        match World::open(&camera, number(HISTORY)) {
            Ok(world) => world.obey(),
            Err(error) => eprintln!("publisher of {camera:?}: {error}"),
        }
    } else {
        publish_other_version(&camera, number(VERSION));
    }
}

fn domain() -> Domain {
    let set = |variable| env::var(variable).expect("is set");
    Domain { prefix: set("LODESTONE_SHM_PREFIX"), root: set("LODESTONE_SHM_ROOT") }
}

/// Holds a service of another schema version until the orders end.
fn publish_other_version(camera: &str, version: usize) {
    let node = domain().open_node("publisher").expect("a node");
    let name = ServiceName::new(&format!("lodestone/v{version}/{camera}/pose")).expect("a name");
    let builder = node.service_builder(&name).publish_subscribe::<u64>();
    let _service = builder.open_or_create().expect("a service");
    println!("ready");
    let _ = stdin().lock().lines().count();
}

struct World {
    poses: Port<ipc::Service, Pose, ()>,
    health: Port<ipc::Service, Health, ()>,
    sequence: u64,
}

impl World {
    fn open(camera: &str, history: usize) -> Result<Self, OpenError> {
        let node = domain().open_node("publisher").expect("a node");
        let qos = |history| Qos { history, max_subscribers: 8, max_publishers: 2, max_borrowed: 2 };
        let poses = open_for_writing::<Pose>(&node, ServiceKind::Pose, camera, qos(history))?;
        let health = open_for_writing::<Health>(&node, ServiceKind::Health, camera, qos(1))?;
        let poses = poses.publisher_builder().create().expect("a port");
        let health = health.publisher_builder().create().expect("a port");
        println!("ready");
        Ok(Self { poses, health, sequence: 0 })
    }

    fn obey(mut self) {
        let orders = orders();
        while let Ok(order) = orders.recv() {
            let Some(count) = order.strip_prefix("burst ") else {
                println!("done");
                return self.run(&orders);
            };
            self.burst(count.parse().expect("a number"));
            println!("done");
        }
    }

    fn burst(&mut self, count: i64) {
        let now_ns = monotonic_now_ns();
        for left in (0..count).rev() {
            self.publish(now_ns - left * STEP.as_nanos() as i64);
        }
    }

    fn run(mut self, orders: &Receiver<String>) {
        while orders.try_recv() != Err(TryRecvError::Disconnected) {
            self.publish(monotonic_now_ns());
            if self.sequence % 100 == 1 {
                let _ = self.health.send_copy(health(self.sequence));
            }
            sleep(STEP);
        }
    }

    fn publish(&mut self, time_ns: i64) {
        self.poses.send_copy(pose(self.sequence, time_ns)).expect("sends");
        self.sequence += 1;
    }
}

fn orders() -> Receiver<String> {
    let (sender, orders) = channel();
    spawn(move || {
        stdin().lock().lines().map_while(Result::ok).try_for_each(|line| sender.send(line))
    });
    orders
}

/// East at 1 m/s, so that the position in m is the monotonic time in s.
pub(crate) fn pose(sequence: u64, time_ns: i64) -> Pose {
    Pose {
        sequence,
        camera_id: 0,
        reset_counter: 0,
        status: Status::INITIALISED.bits(),
        validity: Validity::all().bits(),
        heading_source: 1,
        position_source: 5,
        aids_used: 0,
        aids_refused: 0,
        world_epoch: 1,
        sensor_time_ns: time_ns,
        time_ns,
        arrival_time_ns: time_ns,
        ring_time_ns: time_ns,
        step_start_time_ns: time_ns,
        step_end_time_ns: time_ns,
        published_time_ns: time_ns,
        unix_offset_ns: UNIX_OFFSET_NS,
        position_m: [time_ns as f64 * 1e-9, 0.0, 0.0],
        velocity_m_s: [1.0, 0.0, 0.0],
        orientation: [0.0, 0.0, 0.0, 1.0],
        angular_rate_rad_s: [0.0; 3],
        specific_force_m_s2: [0.0, 0.0, 9.806_65],
        position_covariance_m2: [1e-4, 0.0, 0.0, 1e-4, 0.0, 1e-4],
        velocity_covariance_m2_s2: [1e-4, 0.0, 0.0, 1e-4, 0.0, 1e-4],
        orientation_covariance_rad2: [1e-6, 0.0, 0.0, 1e-6, 0.0, 1e-4],
    }
}

#[expect(clippy::too_many_lines, reason = "a line for each field")]
fn health(poses: u64) -> Health {
    Health {
        sequence: poses / 100,
        camera_id: 0,
        camera_count: 1,
        serial: 4711,
        time_ns: monotonic_now_ns(),
        daemon_start_time_ns: 1,
        daemon_pid: std::process::id(),
        status: Status::INITIALISED.bits(),
        validity: Validity::all().bits(),
        state: 2,
        heading_source: 1,
        position_source: 5,
        alignment_wait: 0,
        aids_used: 0,
        aids_refused: 0,
        member_count: 0,
        anchor_refusal: 0,
        world_epoch: 1,
        sample_rate_hz: 400.0,
        pose_rate_hz: 400.0,
        latency_p50_s: 50e-6,
        latency_p99_s: 120e-6,
        temperature_c: f64::NAN,
        heading_sigma_rad: 0.01,
        magnetic_norm_ut: 48.0,
        clock_drift: f64::NAN,
        samples: poses,
        poses,
        ring_dropped: 0,
        samples_lost: 3,
        steps_bridged: 3,
        duplicates: 0,
        out_of_order: 0,
        invalid: 0,
        reconnects: 0,
        resets: 0,
        publish_errors: 0,
        aiding_used: 0,
        aiding_refused: 0,
        aiding_invalid: 0,
        members_in_use: 0,
        real_time_refused: 0,
        reserved: [0; 3],
        group_delay_s: 0.0,
    }
}
