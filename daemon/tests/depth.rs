//! `lodestoned depth` as a process beside a daemon: its clouds lie on the scene, it outlives the daemon,
//! and says what is wrong with a command line.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod common;

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use common::{in_child, own_domain, said};
use glam::DVec3;
use lodestone_client::{
    Body, Client, Cloud, CloudFrame, CloudInfo, CloudStream, LookupError, LookupLimits, PoseStream,
    Time, Transform, World, body_from_optical_axes,
};
use lodestone_config::Config;
use lodestone_daemon::scene::Scene;
use lodestone_schema::transport::Domain;
use rustix::process::{Pid, Signal, kill_process};

/// What is waited for comes within seconds; this is for a machine that is very busy.
const PATIENCE: Duration = Duration::from_mins(1);
const SIGMA_PER_M: f64 = 0.0032;

/// A camera that turns and moves at once, in a room with something that moves, as few points as tell.
const SCENE: &str = r#"
[scene.room]
size_m = [6.0, 5.0, 2.6]
heading_deg = 20.0

[[scene.box]]
centre_m = [1.6, 0.4, -0.5]
size_m = [0.5, 0.9, 0.8]
heading_deg = 35.0

[scene.mover]
shape = "ball"
centre_m = [0.0, 0.0, -0.9]
reach_east_m = 1.4
period_s = 5.0

[[camera]]
name = "front"
driver = "synthetic"
[camera.synthetic]
trajectory = "turns"
rest_s = 0.5
seed = 3
[camera.depth]
width = 100
height = 60
rolling_shutter_s = 0.03
"#;

fn configuration(directory: &Path, domain: &Domain, rest: &str) -> PathBuf {
    let Domain { prefix, root } = domain;
    let path = directory.join("depth.toml");
    let text = format!("[shared_memory]\nprefix = \"{prefix}\"\nroot = \"{root}\"\n{rest}");
    std::fs::write(&path, text).unwrap();
    path
}

fn lodestoned(line: &str, configuration: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lodestoned"));
    command.args(line.split_whitespace()).arg("--config").arg(configuration);
    command.env_remove("RUST_LOG").stdin(Stdio::null()).stdout(Stdio::null());
    command
}

/// A process that ends with the test if not before.
struct Running(Child);

impl Running {
    fn start(line: &str, configuration: &Path, log: &Path) -> Self {
        let log = File::create(log).unwrap();
        Self(lodestoned(line, configuration).stderr(log).spawn().unwrap())
    }

    fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.0), signal).unwrap();
    }

    fn ended(mut self) -> Option<i32> {
        self.0.wait().unwrap().code()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Takes clouds, and places them by the truth.
struct Consumer {
    scene: Scene,
    truth: PoseStream,
    clouds: CloudStream,
}

impl Consumer {
    fn new(domain: &Domain, configuration: &Path) -> Self {
        let scene = Config::load(configuration).unwrap().config.scene.unwrap();
        let client = Client::builder().prefix(&domain.prefix).root(&domain.root).connect().unwrap();
        let no_guess = LookupLimits { prediction: Duration::ZERO, ..LookupLimits::default() };
        let truth = client.pose_stream("front").unwrap().truth().limits(no_guess).open();
        let clouds = client.clouds("front").unwrap();
        Self { scene: Scene::new(&scene), truth, clouds }
    }

    fn next_cloud(&mut self) -> Cloud {
        self.clouds.wait(PATIENCE).unwrap()
    }

    fn next_cloud_after(&mut self, time_ns: i64) -> Cloud {
        loop {
            let cloud = self.next_cloud();
            if cloud.info().time_ns() > time_ns {
                return cloud;
            }
        }
    }

    fn await_turning(&mut self) {
        let turns = |truth: &mut PoseStream| {
            let rate = truth.latest().ok().and_then(|pose| pose.angular_rate_rad_s());
            rate.is_some_and(|rate| rate.length() > 0.15)
        };
        while !turns(&mut self.truth) {
            self.next_cloud();
        }
    }

    /// Distances of a cloud's points from the scene in sigmas of their depth, root mean square, placed by
    /// the truth of so much earlier.
    fn off(&mut self, cloud: &Cloud, earlier_ns: i64) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for point in cloud.points().iter().filter(|point| point.position_m[2].is_finite()) {
            let seen_ns = cloud.info().time_ns() + i64::from(point.time_offset_ns);
            let place = pose_at(&mut self.truth, seen_ns - earlier_ns) * body_from_optical_axes();
            let optical = DVec3::from_array(point.position_m.map(f64::from));
            let distance_m = self.scene.distance_m(place.apply(optical), Some(seen_ns));
            sum += (distance_m / (SIGMA_PER_M * optical.z * optical.z)).powi(2);
            count += 1.0;
        }
        assert!(count > 0.8 * cloud.points().len() as f64, "{count} points have depth");
        f64::sqrt(sum / count)
    }
}

fn pose_at(truth: &mut PoseStream, time_ns: i64) -> Transform<World, Body> {
    let begin = Instant::now();
    loop {
        match truth.lookup(Time::Monotonic(time_ns)) {
            Ok(pose) => return pose.world_from_body().unwrap(),
            // The same message comes to everyone, to us perhaps a little later.
            Err(LookupError::TooNew { .. } | LookupError::Empty | LookupError::NotConnected(_))
                if begin.elapsed() < PATIENCE =>
            {
                std::thread::sleep(Duration::from_millis(1));
            }
            Err(error) => panic!("{error}"),
        }
    }
}

#[test]
fn clouds_lie_on_the_scene_and_outlive_the_daemon() {
    in_child("clouds_lie_on_the_scene_and_outlive_the_daemon", || {
        // Given a depth source that was there first, and a daemon
        let (domain, _guard) = own_domain("depth");
        let files = tempfile::tempdir().unwrap();
        let config = configuration(files.path(), &domain, SCENE);
        let (log, daemon_log) = (files.path().join("depth.log"), files.path().join("run.log"));
        let source = Running::start("depth --camera front", &config, &log);
        let daemon = Running::start("run", &config, &daemon_log);
        // When a consumer takes clouds while the camera turns, and places them by the truth
        let mut consumer = Consumer::new(&domain, &config);
        consumer.await_turning();
        let info = lie_on_the_scene(&mut consumer);
        assert_says_what_it_is(&info);

        // When the daemon is killed and another one begins
        daemon.signal(Signal::KILL);
        daemon.ended();
        let daemon = Running::start("run", &config, &daemon_log);
        let resumed = consumer.next_cloud_after(lodestone_client::monotonic_now_ns());
        // Then clouds go on, and still lie on the scene
        assert!(resumed.info().sequence() > info.sequence());
        let resumed_off = consumer.off(&resumed, 0);
        assert!((0.5..1.1).contains(&resumed_off), "{resumed_off}");

        // When it is asked to stop, it says what it did
        source.signal(Signal::TERM);
        assert_eq!(source.ended(), Some(0));
        let said = std::fs::read_to_string(&log).unwrap();
        assert_eq!(said.matches("the camera's truth is there").count(), 2, "{said}");
        assert!(said.contains("clouds published"), "{said}");
        daemon.signal(Signal::TERM);
        assert_eq!(daemon.ended(), Some(0));
    });
}

/// Points are as far from the surfaces as noise along rays says, and poses that are late show.
fn lie_on_the_scene(consumer: &mut Consumer) -> CloudInfo {
    const CLOUDS: usize = 8;
    let mut newest = consumer.next_cloud();
    let (mut with_truth, mut with_older) = (0.0, 0.0);
    for _ in 0..CLOUDS {
        newest = consumer.next_cloud();
        with_truth += consumer.off(&newest, 0) / CLOUDS as f64;
        with_older += consumer.off(&newest, 300_000_000) / CLOUDS as f64;
    }
    // The noise is along the ray, the distance across the surface, which is never more.
    assert!((0.5..1.02).contains(&with_truth), "{with_truth}");
    assert!(with_older > 1.5 * with_truth, "{with_older} {with_truth}");
    *newest.info()
}

fn assert_says_what_it_is(info: &CloudInfo) {
    assert_eq!((info.width(), info.height()), (100, 60));
    assert_eq!(info.frame(), CloudFrame::Optical);
    assert!(info.has_colour() && info.has_point_time());
    assert!((f64::from(info.depth_sigma_per_m().unwrap()) - SIGMA_PER_M).abs() < 1e-6);
}

#[test]
fn what_cannot_be_is_said_with_exit_code_2() {
    let files = tempfile::tempdir().unwrap();
    let (domain, _guard) = own_domain("depth_usage");
    let config = configuration(files.path(), &domain, SCENE);
    let bare = files.path().join("bare.toml");
    std::fs::write(&bare, "[[camera]]\nname = \"front\"\ndriver = \"synthetic\"\n").unwrap();
    let real = files.path().join("real.toml");
    std::fs::write(&real, "[scene.room]\n[[camera]]\nname = \"front\"\nserial = 7\n").unwrap();
    for (line, config, expected) in [
        ("depth --camera rear", &config, "there is no camera \"rear\"; allowed: front"),
        ("depth --camera front --camera front", &config, "\"front\" is named twice"),
        ("depth --camera front", &bare, "the configuration has no scene"),
        ("depth --camera front", &real, "camera \"front\" is not synthetic"),
    ] {
        let output: Output = lodestoned(line, config).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{line}: {}", said(&output));
        assert!(said(&output).contains(expected), "{line}: {}", said(&output));
    }
}
