//! The daemon as processes: one at a time, stopped cleanly, killed, starved, failing.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod common;

use std::io::{BufRead, BufReader, Read};
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use common::{
    child, child_on_small_shm, in_child, is_child, on_small_shm, own_domain, pose, said,
    shared_memory_files, small,
};
use lodestone_config::Loaded;
use lodestone_config::model::{Camera, Config, DriverKind, SharedMemory};
use lodestone_daemon::cli::RunArgs;
use lodestone_daemon::commands::run::run;
use lodestone_daemon::commands::supervision::{
    LaneContext, LaneFailure, LaneThread, Ready, StartedLane,
};
use lodestone_daemon::console::Console;
use lodestone_daemon::logging;
use lodestone_daemon::publisher::LanePublisher;
use lodestone_daemon::service::housekeeping::TruthProvider;
use lodestone_daemon::service::space::needed_bytes;
use lodestone_daemon::status_board::{LaneStatus, SensorStatus};
use lodestone_schema::transport::{Domain, open_for_reading};
use lodestone_schema::{Health, LaneState, Pose, ServiceKind};
use rustix::process::{Pid, Signal, kill_process};

const DAEMON: &str = "play_the_daemon";
/// What is waited for comes within milliseconds; this is for a machine that is very busy.
const PATIENCE: Duration = Duration::from_secs(30);

/// A daemon whose lanes publish made-up poses; a part played in child processes.
#[test]
fn play_the_daemon() {
    if !is_child(DAEMON) {
        return;
    }
    let text = |key: &str| std::env::var(key).unwrap_or_default();
    let config = configured(SharedMemory { prefix: text("PREFIX"), root: text("ROOT"), ..small() });
    let duration = text("DURATION").parse().ok().map(Duration::from_secs_f64);
    logging::init(None, None).unwrap();
    let loaded = Loaded { config, path: PathBuf::new() };
    let result = run(loaded, &RunArgs { duration }, Console::choose(), start_lane);
    if let Err(e) = &result {
        eprintln!("lodestoned: {e}");
    }
    std::process::exit(result.map_or_else(|e| e.exit_code().into(), |()| 0));
}

fn configured(shared_memory: SharedMemory) -> Config {
    let camera = |name: &str| Camera {
        name: name.into(),
        serial: 7,
        driver: DriverKind::Synthetic,
        ..Camera::default()
    };
    Config { camera: vec![camera("front"), camera("rear")], shared_memory, ..Config::default() }
}

fn start_lane(context: LaneContext) -> Result<StartedLane, LaneFailure> {
    let handle = Box::new(LaneThread::start(context, lane)?);
    Ok(StartedLane { handle, truth: Some(Box::new(MadeUpTruth)) })
}

struct MadeUpTruth;

impl TruthProvider for MadeUpTruth {
    fn truth_at_now(&mut self) -> Option<Pose> {
        Some(pose(99))
    }
}

/// Publishes until it is stopped, or does what `MISHAP` says after a few poses.
fn lane(context: &LaneContext, ready: Ready) -> Result<(), LaneFailure> {
    let (settings, name) = (&context.loaded.config.shared_memory, &context.settings().name);
    let mishap = std::env::var("MISHAP").unwrap_or_default();
    assert!(mishap != "at once", "bad luck at once");
    let mut publisher =
        LanePublisher::open(&context.domain, settings, name).map_err(LaneFailure::of)?;
    ready.tell();
    context.board.set_state(LaneState::Running);
    if mishap == "deaf" {
        loop {
            std::thread::park();
        }
    }
    for n in 0.. {
        if context.stop.is_raised() || (mishap == "end" && n > 20) {
            break;
        }
        assert!(!(mishap == "panic" && n > 20 && name == "rear"), "bad luck");
        let published = publisher.publish_pose(&pose(n));
        context.board.counters.poses.add(published.is_some().into());
        context.board.latency.record(20_000);
        context.board.latest.report(&LaneStatus::of(&pose(n), SensorStatus::default()));
        std::thread::sleep(Duration::from_millis(2));
    }
    Ok(())
}

fn daemon(domain: &Domain) -> Command {
    let mut command = child(DAEMON);
    command.env("PREFIX", &domain.prefix).env("ROOT", &domain.root).env_remove("RUST_LOG");
    command.stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

/// A daemon that serves; ended with the test if not before.
struct Serving {
    child: Child,
    log: BufReader<std::process::ChildStderr>,
}

impl Serving {
    fn start(domain: &Domain) -> Self {
        Self::start_with(domain, "")
    }

    fn start_with(domain: &Domain, mishap: &str) -> Self {
        let mut child = daemon(domain).env("MISHAP", mishap).spawn().unwrap();
        let mut log = BufReader::new(child.stderr.take().unwrap());
        let mut heard = String::new();
        while !heard.contains("serving 2 cameras") {
            let read = log.read_line(&mut heard).unwrap();
            assert!(read > 0, "ended instead of serving: {heard}");
        }
        Self { child, log }
    }

    fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.child), signal).unwrap();
    }

    /// Waits for the end: exit code and the rest of the log.
    fn ended(mut self) -> (Option<i32>, String) {
        let mut rest = String::new();
        self.log.read_to_string(&mut rest).unwrap();
        (self.child.wait().unwrap().code(), rest)
    }
}

impl Drop for Serving {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn a_second_daemon_is_refused_by_pid_until_the_first_is_killed() {
    let (domain, _guard) = own_domain("two");
    let first = Serving::start(&domain);

    let second = daemon(&domain).output().unwrap();
    assert_eq!(second.status.code(), Some(1), "{}", said(&second));
    let pid = format!("pid {}", first.child.id());
    assert!(said(&second).contains(&pid), "no {pid:?} in {}", said(&second));

    first.signal(Signal::KILL);
    assert_eq!(first.ended().0, None);
    let third = Serving::start(&domain);
    third.signal(Signal::TERM);
    assert_eq!(third.ended().0, Some(0));
}

#[test]
fn a_signal_stops_it_cleanly_and_no_memory_stays_taken() {
    for signal in [Signal::TERM, Signal::INT] {
        let (domain, _guard) = own_domain("stop");
        let daemon = Serving::start(&domain);
        assert!(shared_memory_files(&domain.prefix).iter().any(|name| is_data(name)));
        daemon.signal(signal);
        let (code, log) = daemon.ended();
        assert_eq!(code, Some(0), "{log}");
        assert!(log.contains("stopped"), "{log}");
        let left = shared_memory_files(&domain.prefix);
        assert!(!left.iter().any(|name| is_data(name)), "{left:?}");
    }
}

fn is_data(file_name: &str) -> bool {
    [".data", ".dynamic", ".connection"].iter().any(|suffix| file_name.ends_with(suffix))
}

fn run_with(mishap: &str) -> Output {
    let (domain, _guard) = own_domain("mishap");
    daemon(&domain).env("MISHAP", mishap).output().unwrap()
}

#[test]
fn a_lane_that_panics_is_named_and_ends_the_daemon() {
    let output = run_with("panic");
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(said(&output).contains(r#"camera "rear": panicked: bad luck"#), "{}", said(&output));
}

#[test]
fn a_lane_that_panics_before_it_is_ready_is_told_apart_from_a_slow_one() {
    let output = run_with("at once");
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(said(&output).contains("panicked: bad luck at once"), "{}", said(&output));
}

#[test]
fn the_end_of_every_source_is_a_good_end() {
    let output = run_with("end");
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(said(&output).contains("every source ended"), "{}", said(&output));
}

#[test]
fn a_second_signal_ends_it_at_once_even_if_a_lane_does_not_listen() {
    let (domain, _guard) = own_domain("deaf");
    let daemon = Serving::start_with(&domain, "deaf");
    daemon.signal(Signal::INT);
    // A signal that comes before the first was handled would merge with it.
    await_some(|| is_handled(&daemon.child).then_some(()));
    daemon.signal(Signal::INT);
    assert_eq!(daemon.ended().0, Some(130));
}

/// Whether no SIGINT waits to be delivered.
fn is_handled(child: &Child) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
    let pending = status.lines().find_map(|line| line.strip_prefix("ShdPnd:")).unwrap();
    u64::from_str_radix(pending.trim(), 16).unwrap() & 0b10 == 0
}

#[test]
fn a_daemon_killed_again_and_again_does_not_eat_up_shared_memory() {
    const NAME: &str = "a_daemon_killed_again_and_again_does_not_eat_up_shared_memory";
    if is_child(NAME) {
        let (domain, _guard) = own_domain("lives");
        for _ in 0..4 {
            let daemon = Serving::start(&domain);
            daemon.signal(Signal::KILL);
            daemon.ended();
        }
        return;
    }
    // Room for one daemon, not for two.
    let room = needed_bytes(&configured(small())) * 3 / 2;
    let Some(mut child) = child_on_small_shm(NAME, room) else { return };
    let output = child.output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
}

#[test]
fn a_duration_ends_it() {
    let (domain, _guard) = own_domain("duration");
    let output = daemon(&domain).env("DURATION", "0.3").output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
}

#[test]
fn health_and_truth_reach_a_consumer() {
    in_child("health_and_truth_reach_a_consumer", || {
        let (domain, _guard) = own_domain("health");
        let daemon = Serving::start(&domain);
        let node = domain.open_node("consumer").unwrap();
        let health = open_for_reading::<Health>(&node, ServiceKind::Health, "rear").unwrap();
        let health = health.subscriber_builder().create().unwrap();
        let truth = open_for_reading::<Pose>(&node, ServiceKind::Truth, "rear").unwrap();
        let truth = truth.subscriber_builder().create().unwrap();

        assert_eq!(await_some(|| truth.receive().unwrap()).sequence, 99);
        let running = await_some(|| health.receive().unwrap().filter(|h| h.poses > 0));
        assert_eq!((running.camera_id, running.camera_count, running.serial), (1, 2, 7));
        assert_eq!(running.daemon_pid, daemon.child.id());
        assert_eq!(LaneState::from_code(running.state), Some(LaneState::Running));
        assert!(running.pose_rate_hz > 0.0 && (running.latency_p99_s - 20e-6).abs() < 1e-6);

        daemon.signal(Signal::TERM);
        let ended = LaneState::Ended.code();
        await_some(|| health.receive().unwrap().filter(|h| h.state == ended));
        assert_eq!(daemon.ended().0, Some(0));
    });
}

fn await_some<T>(mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed() < PATIENCE, "did not come");
        std::thread::sleep(Duration::from_millis(5));
    }
}

static CONFIGURATIONS: AtomicU64 = AtomicU64::new(0);

/// A configuration file of two synthetic cameras in a domain of its own.
fn configuration(directory: &std::path::Path) -> std::path::PathBuf {
    let number = CONFIGURATIONS.fetch_add(1, Ordering::Relaxed);
    let prefix = format!("t{}_binary{number}_", std::process::id());
    let text = format!(
        r#"
            [shared_memory]
            prefix = "{prefix}"
            root = "{root}/"
            [[camera]]
            name = "front"
            serial = 1
            driver = "synthetic"
            [[camera]]
            name = "rear"
            serial = 2
            driver = "synthetic"
        "#,
        root = directory.join("root").display(),
    );
    let path = directory.join("lodestone.toml");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn the_daemon_does_not_start_on_a_full_shared_memory_and_says_what_it_needs() {
    let Some(mut small) = on_small_shm(1 << 20) else { return };
    let directory = tempfile::tempdir().unwrap();
    let output = small
        .args([env!("CARGO_BIN_EXE_lodestoned"), "run", "--config"])
        .arg(configuration(directory.path()))
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("MiB in /dev/shm") && message.contains("MiB free"), "{message}");
}

#[test]
fn it_says_the_same_if_its_own_directory_lies_on_the_full_file_system() {
    let Some(mut small) = on_small_shm(1 << 20) else { return };
    let directory = tempfile::tempdir().unwrap();
    let file = configuration(directory.path());
    let text = std::fs::read_to_string(&file).unwrap();
    let root = directory.path().join("root").display().to_string();
    std::fs::write(&file, text.replace(&root, "/dev/shm/root")).unwrap();
    // Less than a page is left: not even the lock file's text finds room.
    let fill = "head -c 2M /dev/zero > /dev/shm/filler 2>/dev/null; exec \"$0\" \"$@\"";
    let output = small
        .args(["sh", "-c", fill, env!("CARGO_BIN_EXE_lodestoned"), "run", "--config"])
        .arg(&file)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("MiB in /dev/shm, 0 MiB free"), "{message}");
}

#[test]
fn wrong_usage_and_wrong_configurations_end_with_2() {
    let directory = tempfile::tempdir().unwrap();
    let broken = directory.path().join("broken.toml");
    std::fs::write(&broken, "[shared_memory]\nhistory = 3\n").unwrap();
    let lodestoned =
        |args: &[&str]| Command::new(env!("CARGO_BIN_EXE_lodestoned")).args(args).output().unwrap();
    for args in [
        &["--unknown"][..],
        &["run", "--duration", "0"],
        &["check", "--config", broken.to_str().unwrap()],
        &["run", "--config", broken.to_str().unwrap()],
        &["run", "--config", "/nowhere/lodestone.toml"],
        &["--log", "=[", "check"],
    ] {
        let output = lodestoned(args);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", said(&output));
        assert!(!output.stderr.is_empty());
    }
    assert_eq!(lodestoned(&["--help"]).status.code(), Some(0));
}
