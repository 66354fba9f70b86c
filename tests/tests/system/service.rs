//! The daemon as a service: one for a domain, started in vain, stopped cleanly, on two threads.

use std::process::{Command, Stdio};

use iceoryx2::prelude::ServiceName;
use lodestone_client::Domain;
use lodestone_config::model::TrajectoryKind;
use lodestone_schema::SCHEMA_VERSION;
use lodestone_tests::system::{
    Daemon, Follower, Recorded, TestDomain, eventually, lodestone, lodestoned, on_small_shm, said,
};
use rustix::process::Signal;

const ONE_CAMERA: &str = r#"
[[camera]]
name = "front"
driver = "synthetic"
synthetic = { trajectory = "standing", rest_s = 1.0 }
"#;

#[test]
fn given_a_daemon_when_a_second_one_starts_then_it_is_told_the_pid_and_the_first_goes_on() {
    let domain = TestDomain::new();
    let configuration = domain.configuration(ONE_CAMERA);
    let daemon = Daemon::start(&configuration);
    let follower = Follower::start(&domain, "front");
    follower.await_more(10);

    for _ in 0..3 {
        let second = lodestoned().args(["run", "--config"]).arg(&configuration).output().unwrap();
        assert_eq!(second.status.code(), Some(1), "{}", said(&second));
        let pid = format!("pid {}", daemon.pid());
        assert!(said(&second).contains(&pid), "no {pid:?} in {}", said(&second));
    }

    follower.await_more(100);
    assert_eq!(follower.tally().runs_after_first, 0);
    assert_eq!(follower.stop(), Some(0));
    daemon.signal(Signal::TERM);
    assert_eq!(daemon.ended().0, Some(0));
}

#[test]
fn a_signal_ends_daemon_and_consumer_cleanly_and_no_memory_stays_taken() {
    for signal in [Signal::INT, Signal::TERM] {
        let domain = TestDomain::new();
        let daemon = Daemon::start(&domain.configuration(ONE_CAMERA));
        let follower = Follower::start(&domain, "front");
        follower.await_more(10);
        assert_ne!(domain.memory_in_use(), [""; 0]);

        daemon.signal(signal);
        let (code, log) = daemon.ended();
        assert_eq!(code, Some(0), "{log}");
        assert!(log.contains("stopped"), "{log}");
        assert_eq!(follower.stop(), Some(0));

        assert_eq!(domain.memory_in_use(), [""; 0]);
        let left = domain.all_files();
        // The lock file stays by design, and one file for the whole domain is iceoryx2's.
        assert!(left.len() <= 2, "{left:?}");
    }
}

#[test]
fn given_a_full_shared_memory_when_the_daemon_starts_then_it_says_what_it_needs() {
    let Some(mut small) = on_small_shm(1 << 20) else { return };
    let domain = TestDomain::new();
    let output = small
        .arg(lodestoned().get_program())
        .args(["run", "--config"])
        .arg(domain.configuration(ONE_CAMERA))
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("MiB in /dev/shm") && message.contains("MiB free"), "{message}");
    assert!(!message.contains("panicked"), "{message}");
}

#[test]
fn on_two_threads_poses_come_as_well() {
    let domain = TestDomain::new();
    let configuration = domain.configuration(&format!("[lane]\nthreads = \"two\"\n{ONE_CAMERA}"));
    let daemon = Daemon::start(&configuration);
    let follower = Follower::start(&domain, "front");
    // The camera rests for a second before the filter is aligned.
    follower.await_more(600);

    let pose = follower.tally().latest;
    let known: Vec<&str> =
        pose["valid"].as_array().unwrap().iter().filter_map(|v| v.as_str()).collect();
    for field in ["tilt", "heading", "time"] {
        assert!(known.contains(&field), "no {field} in {pose}");
    }
    assert_eq!(follower.stop(), Some(0));
    daemon.signal(Signal::TERM);
    let (code, log) = daemon.ended();
    assert_eq!(code, Some(0), "{log}");
}

#[test]
fn given_a_recording_that_repeats_then_each_round_is_a_new_start_that_consumers_are_told_of() {
    const LENGTH_S: f64 = 4.0;
    const SPEED: f64 = 4.0;
    let domain = TestDomain::new();
    Recorded::of(TrajectoryKind::Standing, 1, LENGTH_S).write(&domain.directory().join("made.csv"));
    let configuration = domain.configuration(&format!(
        "[[camera]]\nname = \"recorded\"\ndriver = \"replay\"\n\
         replay = {{ file = \"made.csv\", speed = {SPEED:?}, repeat = true }}\n",
    ));
    let daemon = Daemon::start(&configuration);
    let follower = Follower::start(&domain, "recorded");

    let first = eventually("the first pose comes", || {
        let pose = follower.tally().latest;
        pose["time_ns"].is_i64().then_some(pose)
    });
    let third = eventually("the third round begins", || {
        let pose = follower.tally().latest;
        (pose["reset_counter"].as_u64()? >= 2).then_some(pose)
    });

    // Host time goes on while the recording's has run back twice, and no round is a new daemon.
    let elapsed_s =
        |key: &str| (third[key].as_i64().unwrap() - first[key].as_i64().unwrap()) as f64 * 1e-9;
    let gone_back_s = SPEED * elapsed_s("time_ns") - elapsed_s("sensor_time_ns");
    assert!(gone_back_s > 1.5 * LENGTH_S, "{gone_back_s} s back, from {first} to {third}");
    assert_eq!(follower.tally().runs_after_first, 0);
    assert_eq!(follower.stop(), Some(0));
    daemon.signal(Signal::TERM);
    assert_eq!(daemon.ended().0, Some(0));
}

#[test]
fn the_embedded_demonstration_serves_two_cameras_until_its_time_is_over() {
    // The embedded configuration has its own domain, so this runs in a mount namespace of its own.
    let Some(mut apart) = on_small_shm(1 << 30) else { return };
    let output =
        apart.arg(lodestoned().get_program()).args(["run", "--duration", "1"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(said(&output).contains("serving 2 cameras"), "{}", said(&output));
    assert!(!said(&output).contains("panicked"), "{}", said(&output));
}

/// The one test of this program that enters a domain itself, which a process can do once.
#[test]
fn given_a_daemon_of_another_schema_version_then_the_consumer_says_so() {
    let other = TestDomain::new();
    let domain = Domain { prefix: other.prefix.clone(), root: other.root.clone() };
    let node = domain.open_node("daemon-of-tomorrow").unwrap();
    let (ours, theirs) = (SCHEMA_VERSION, SCHEMA_VERSION + 1);
    let name = format!("lodestone/v{theirs}/front/pose");
    let name = ServiceName::new(&name).unwrap();
    let _service = node.service_builder(&name).publish_subscribe::<u64>().open_or_create().unwrap();

    for arguments in [
        &["status"][..],
        &["watch"],
        &["echo", "--camera", "front"],
        &["world"],
        &["world", "reset"],
        &["relative"],
        &["transforms"],
    ] {
        let output = in_domain(lodestone().args(arguments), &other).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{}", said(&output));
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(message.contains(&format!("published in schema version {theirs}")), "{message}");
        assert!(message.contains(&format!("this program speaks version {ours}")), "{message}");
    }
}

fn in_domain<'a>(command: &'a mut Command, domain: &TestDomain) -> &'a mut Command {
    command.args(["--prefix", &domain.prefix, "--root", &domain.root]).stdin(Stdio::null())
}
