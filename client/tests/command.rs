//! The command, as a user runs it.

mod support;

use std::fs;
use std::io::{BufRead, BufReader};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use lodestone_client::monotonic_now_ns;
use lodestone_schema::SCHEMA_VERSION;
use rustix::process::{Pid, Signal, geteuid, kill_process};
use serde_json::Value;
use support::publisher::{Publisher, UNIX_OFFSET_NS, publish_as_ordered};
use support::{TestDomain, eventually};

#[test]
#[ignore = "the publisher's side of the other tests, which start it themselves"]
fn publisher_process() {
    publish_as_ordered();
}

/// `lodestone ARGS` in a domain.
fn lodestone(domain: &TestDomain, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lodestone"));
    command.args(args).args(["--prefix", &domain.prefix, "--root", &domain.root]);
    command
}

fn output(domain: &TestDomain, args: &[&str]) -> Output {
    lodestone(domain, args).output().expect("runs")
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn json_lines(output: &Output) -> Vec<Value> {
    assert_eq!(output.status.code(), Some(0), "{}", stderr(output));
    let text = String::from_utf8_lossy(&output.stdout);
    text.lines().map(|line| serde_json::from_str(line).expect("is JSON")).collect()
}

fn running(domain: &TestDomain, camera: &str) -> Publisher {
    let mut publisher = Publisher::start(domain, camera, 256);
    publisher.run();
    publisher
}

fn signal(child: &Child, signal: Signal) {
    let pid = Pid::from_child(child);
    kill_process(pid, signal).expect("signals");
}

#[test]
fn without_a_daemon_every_command_says_so_and_leaves_nothing_behind() {
    let domain = TestDomain::named("none");
    let commands: [&[&str]; 4] = [
        &["status"],
        &["watch"],
        &["echo", "--camera", "front"],
        &["lookup", "--camera", "front", "--ago", "0.1"],
    ];
    for args in commands {
        let ended = output(&domain, args);
        assert_eq!(ended.status.code(), Some(1), "{args:?}");
        assert!(stderr(&ended).starts_with("lodestone: no daemon in domain"), "{}", stderr(&ended));
        assert_eq!(stderr(&ended).lines().count(), 1, "{}", stderr(&ended));
    }
    assert!(!Path::new(&domain.root).exists());
}

#[test]
fn wrong_usage_ends_with_2() {
    let domain = TestDomain::named("usage");
    let wrong: [&[&str]; 7] = [
        &["fly"],
        &["lookup", "--camera", "front"],
        &["lookup", "--camera", "front", "--time", "soon"],
        &["lookup", "--camera", "front", "--time", "1", "--ago", "1"],
        &["echo", "--camera", "../front"],
        &["echo", "--camera", "front", "--count", "0"],
        &["status", "--wait", "-1"],
    ];
    for args in wrong {
        let ended = output(&domain, args);
        assert_eq!(ended.status.code(), Some(2), "{args:?}: {}", stderr(&ended));
        assert!(!ended.stderr.is_empty());
    }
    let relative = Command::new(env!("CARGO_BIN_EXE_lodestone"))
        .args(["status", "--root", "not/absolute"])
        .output()
        .expect("runs");
    assert_eq!(relative.status.code(), Some(2), "{}", stderr(&relative));
}

#[test]
fn status_shows_state_rates_and_what_is_wrong() {
    let domain = TestDomain::named("status");
    let _publisher = running(&domain, "front");
    let lines = json_lines(&output(&domain, &["status", "--json"]));
    assert_eq!(lines.len(), 1);
    let front = &lines[0];
    assert_eq!(front["camera"], "front");
    assert_eq!(front["state"], "running");
    assert_eq!(front["serial"], 4711);
    assert_eq!(front["samples_lost"], 3);
    assert_eq!(front["temperature_c"], Value::Null, "unknown is null");
    assert_eq!(front["heading_deg"], 90.0);
    assert!((front["heading_sigma_deg"].as_f64().unwrap() - 0.573).abs() < 1e-3);
    assert!(front["problems"].to_string().contains("3 samples lost since start"));
    let text = output(&domain, &["status", "--camera", "front"]);
    let text = String::from_utf8_lossy(&text.stdout).into_owned();
    assert!(text.starts_with("front: running  serial 4711"), "{text}");
    assert!(text.contains("heading   90.0° ± 0.6° clockwise from north (magnetometer)"), "{text}");
}

#[test]
fn echo_prints_so_many_poses_in_order() {
    let domain = TestDomain::named("echo");
    let _publisher = running(&domain, "front");
    let lines = json_lines(&output(&domain, &["echo", "--json", "--count", "20"]));
    let sequences: Vec<u64> = lines.iter().map(|l| l["sequence"].as_u64().unwrap()).collect();
    assert_eq!(sequences.len(), 20);
    assert!(sequences.is_sorted_by(|a, b| a < b), "{sequences:?}");
    for line in &lines {
        let seconds = line["time_ns"].as_f64().unwrap() * 1e-9;
        assert!((line["position_m"][0].as_f64().unwrap() - seconds).abs() < 1e-6);
        assert_eq!(line["origin"], "published");
    }
}

#[test]
fn echo_ends_quietly_when_nobody_reads() {
    let domain = TestDomain::named("pipe");
    let _publisher = running(&domain, "front");
    let mut command = lodestone(&domain, &["echo"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("starts");
    let mut first = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut first).expect("reads");
    assert!(first.starts_with("front #"), "{first}");
    // Given that the reader is gone, when the next pose is printed, then the command ends well
    let ended = child.wait_with_output().expect("ends");
    assert_eq!(ended.status.code(), Some(0), "{}", stderr(&ended));
    assert_eq!(stderr(&ended), "");
}

#[test]
fn lookup_finds_the_past_in_both_clocks() {
    let domain = TestDomain::named("lookup");
    let mut publisher = Publisher::start(&domain, "front", 256);
    // A consumer gets the history with the first pose after it has joined.
    publisher.run();
    eventually("there is history", || {
        let ended = output(&domain, &["lookup", "--ago", "0.1", "--json"]);
        (ended.status.code() == Some(0)).then_some(())
    });
    let asked_ns = monotonic_now_ns() - 20_000_000;
    let expected = asked_ns as f64 * 1e-9;
    let monotonic = format!("{asked_ns}ns");
    let unix = format!("{}ns", asked_ns + UNIX_OFFSET_NS);
    for (clock, time) in [("monotonic", monotonic), ("unix", unix)] {
        let args = ["lookup", "--json", "--camera", "front", "--clock", clock, "--time", &time];
        let found = &json_lines(&output(&domain, &args))[0];
        assert_eq!(found["time_ns"].as_i64(), Some(asked_ns));
        assert!((found["position_m"][0].as_f64().unwrap() - expected).abs() < 1e-6);
    }
    let old = output(&domain, &["lookup", "--clock", "monotonic", "--time", "1"]);
    assert_eq!(old.status.code(), Some(1));
    assert!(stderr(&old).contains("before the oldest pose kept"), "{}", stderr(&old));
    let far_ns = format!("{}ns", monotonic_now_ns() + 3_600_000_000_000);
    let new = output(&domain, &["lookup", "--clock", "monotonic", "--time", &far_ns]);
    assert!(stderr(&new).contains("after the newest pose"), "{}", stderr(&new));
}

#[test]
fn an_unknown_camera_is_answered_with_those_there_are() {
    let domain = TestDomain::named("unknown");
    let _front = running(&domain, "front");
    let _rear = running(&domain, "rear");
    let ended = output(&domain, &["echo", "--camera", "left"]);
    assert_eq!(ended.status.code(), Some(1));
    assert_eq!(stderr(&ended), "lodestone: no camera \"left\"; there are: front, rear\n");
    let which = output(&domain, &["echo"]);
    assert_eq!(which.status.code(), Some(2));
    assert!(stderr(&which).contains("front, rear"), "{}", stderr(&which));
}

#[test]
fn another_schema_version_is_told_apart_from_no_daemon() {
    let domain = TestDomain::named("version");
    let _publisher = Publisher::start_version(&domain, "front", SCHEMA_VERSION + 1);
    let expected = format!("published in schema version {}", SCHEMA_VERSION + 1);
    for args in [&["status"][..], &["echo", "--camera", "front"]] {
        let ended = output(&domain, args);
        assert_eq!(ended.status.code(), Some(1));
        assert!(stderr(&ended).contains(&expected), "{}", stderr(&ended));
    }
}

#[test]
fn a_domain_of_another_user_is_told_apart_from_no_daemon() {
    // Given a domain that is open to its owner only
    const NOBODY: u32 = 65534;
    let domain = TestDomain::named("other_user");
    let program = Path::new(&domain.root).with_extension("program");
    fs::create_dir(&domain.root).expect("makes");
    fs::copy(env!("CARGO_BIN_EXE_lodestone"), &program).expect("copies");
    // When somebody else comes (root is never shut out, so root becomes nobody)
    let mut command = Command::new(&program);
    command.args(["status", "--prefix", &domain.prefix, "--root", &domain.root]);
    let mode = if geteuid().is_root() { 0o700 } else { 0o000 };
    if geteuid().is_root() {
        command.uid(NOBODY).gid(NOBODY);
    }
    fs::set_permissions(&domain.root, fs::Permissions::from_mode(mode)).expect("closes");
    // A copy cannot run while a process that another test has just forked still holds it open.
    let ended = eventually("it runs", || command.output().ok());
    fs::set_permissions(&domain.root, fs::Permissions::from_mode(0o700)).expect("opens");
    fs::remove_file(&program).expect("removes");
    // Then they are told whose it is
    assert_eq!(ended.status.code(), Some(1));
    let whose = format!("belongs to another user (uid {})", geteuid().as_raw());
    assert!(stderr(&ended).contains(&whose), "{}", stderr(&ended));
}

#[test]
fn a_daemon_that_was_killed_is_not_taken_for_a_running_one() {
    let domain = TestDomain::named("corpse");
    running(&domain, "front").kill();
    let ended = output(&domain, &["status"]);
    assert_eq!(ended.status.code(), Some(1), "{}", String::from_utf8_lossy(&ended.stdout));
    assert!(stderr(&ended).contains("no daemon in domain"), "{}", stderr(&ended));
}

#[test]
fn doctor_judges_a_machine_by_its_files_and_ends_with_1_if_something_is_bad() {
    const SOURCE: &str = "sys/devices/system/clocksource/clocksource0";
    let (domain, machine) = (TestDomain::named("doctor"), tempfile::tempdir().unwrap());
    for directory in ["dev/shm", SOURCE] {
        fs::create_dir_all(machine.path().join(directory)).unwrap();
    }
    let current = machine.path().join(SOURCE).join("current_clocksource");
    for (source, verdict) in [("hpet", "bad"), ("tsc", "ok")] {
        fs::write(&current, source).unwrap();
        let args = ["doctor", "--json", "--machine", &machine.path().display().to_string()];
        let ended = output(&domain, &args);
        let text = String::from_utf8_lossy(&ended.stdout);
        let lines: Vec<Value> =
            text.lines().map(|line| serde_json::from_str(line).expect("is JSON")).collect();
        let clock = lines.iter().find(|line| line["check"] == "clock source").expect("is checked");
        assert_eq!((&clock["found"], &clock["verdict"]), (&source.into(), &verdict.into()));
        assert_eq!(clock["change"].is_string(), verdict == "bad");
        // /dev/shm is as full as the file system the test runs on.
        let any_bad = lines.iter().any(|line| line["verdict"] == "bad");
        assert_eq!(ended.status.code(), Some(i32::from(any_bad)), "{}", stderr(&ended));
    }
}

#[test]
fn wait_waits_for_the_daemon() {
    let domain = TestDomain::named("wait");
    let mut command = lodestone(&domain, &["echo", "--count", "1", "--wait", "30"]);
    let child = command.stdout(Stdio::piped()).spawn().expect("starts");
    let _publisher = running(&domain, "front");
    let ended = child.wait_with_output().expect("ends");
    assert_eq!(ended.status.code(), Some(0));
    assert!(ended.stdout.starts_with(b"front #"));
}

#[test]
fn watch_goes_on_through_a_restart_and_stops_on_a_signal() {
    let domain = TestDomain::named("watch");
    let publisher = running(&domain, "front");
    let mut command = lodestone(&domain, &["watch", "--json", "--interval", "0.05"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("starts");
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let mut until = |what: &str, good: &dyn Fn(&Value) -> bool| {
        eventually(what, || {
            let line = lines.next().expect("goes on").expect("reads");
            good(&serde_json::from_str(&line).expect("is JSON")).then_some(())
        });
    };
    let at_rate = |report: &Value| report["pose_rate_hz"].as_f64().is_some_and(|hz| hz > 1.0);
    until("a rate is shown", &at_rate);
    publisher.kill();
    until("no rate is shown", &|report| report["pose_rate_hz"] == 0.0);
    let _second = running(&domain, "front");
    until("a rate is shown again", &|report| at_rate(report) && report["restarts_seen"] == 1);
    signal(&child, Signal::TERM);
    let ended = child.wait_with_output().expect("ends");
    assert_eq!(ended.status.code(), Some(0), "{}", stderr(&ended));
    assert_eq!(stderr(&ended), "");
}

#[test]
fn watch_without_a_terminal_prints_plain_lines() {
    let domain = TestDomain::named("plain");
    let _publisher = running(&domain, "front");
    let ended = output(&domain, &["watch", "--count", "2", "--interval", "0.3"]);
    assert_eq!(ended.status.code(), Some(0), "{}", stderr(&ended));
    let text = String::from_utf8_lossy(&ended.stdout).into_owned();
    assert_eq!(text.lines().count(), 2, "{text}");
    assert!(text.lines().all(|line| line.starts_with("front: state ")), "{text}");
    assert!(!text.contains('\x1b'));
}

#[test]
fn bench_measures_a_running_daemon_and_writes_a_page() {
    let domain = TestDomain::named("bench");
    let _publisher = running(&domain, "front");
    let page = std::env::temp_dir().join(format!("{}bench.html", domain.prefix));
    let path = page.to_string_lossy();
    let args = ["bench", "front", "--duration", "1", "--warm-up", "0.2", "--json", "--html", &path];
    let ended = output(&domain, &args);
    let report = &json_lines(&ended)[0];
    let camera = &report["cameras"][0];
    assert_eq!(camera["camera"], "front");
    let measured = camera["counted"]["measured"].as_u64().expect("a count");
    assert!(measured > 10, "{report}");
    let whole = &camera["all"]["arrival_to_seen"];
    assert_eq!(whole["count"], measured);
    assert!(whole["p50_ns"].as_u64() <= whole["max_ns"].as_u64() && whole["p50_ns"].is_u64());
    assert_eq!(whole["p99_99_ns"], Value::Null, "so few samples cannot tell");
    assert_eq!(camera["all"]["published_to_seen"]["count"], measured);
    let without = camera["without_gaps"]["arrival_to_seen"]["count"].as_u64();
    assert_eq!(without, measured.checked_sub(camera["counted"]["across_gaps"].as_u64().unwrap()));
    // The stand-in for a daemon has no lanes that could be pinned.
    let warnings = report["warnings"].to_string();
    assert!(warnings.contains("scheduled is unknown"), "{warnings}");
    let markup = fs::read_to_string(&page).expect("the page");
    assert!(markup.contains("<svg") && markup.contains("<h2>front</h2>"));
    fs::remove_file(&page).expect("removes");
}

#[test]
fn bench_refuses_a_processor_that_is_not_there_and_says_when_no_pose_came() {
    let domain = TestDomain::named("benchno");
    let mut publisher = Publisher::start(&domain, "front", 16);
    let ended = output(&domain, &["bench", "--cpu", "1000000"]);
    assert_eq!(ended.status.code(), Some(2));
    assert!(stderr(&ended).contains("--cpu: allowed: "), "{}", stderr(&ended));
    publisher.burst(3);
    let ended = output(&domain, &["bench", "front", "--duration", "0.2", "--warm-up", "0"]);
    assert_eq!(ended.status.code(), Some(1));
    assert!(stderr(&ended).contains("no pose came"), "{}", stderr(&ended));
}

#[test]
fn a_signal_ends_the_wait_for_a_daemon() {
    let domain = TestDomain::named("impatient");
    let mut command = lodestone(&domain, &["watch", "--wait", "600"]);
    let mut child = command.stderr(Stdio::piped()).spawn().expect("starts");
    std::thread::sleep(Duration::from_millis(300));
    signal(&child, Signal::INT);
    eventually("it ends", || child.try_wait().expect("waits"));
}
