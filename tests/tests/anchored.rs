//! A process that lays one camera's clouds over another's tells the daemon: over real shared memory.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::process::{Child, Command, Stdio};
use std::time::Duration;

use glam::{DMat3, DQuat, DVec3};
use lodestone_client::{AidingOrigin, Client, Rotation};
use lodestone_schema::transport::{Domain, PublishSubscribe, open_for_reading};
use lodestone_schema::{Pose, ServiceKind};
use lodestone_tests::system::{Daemon, TestDomain, eventually, lodestone};
use serde_json::Value;

const PART: &str = "LODESTONE_TEST_PART";
/// Which camera is told, and against which one it was measured.
const TOLD: &str = "LODESTONE_TEST_TOLD";
const ANCHOR: &str = "LODESTONE_TEST_ANCHOR";

/// Both stand. Where the second one starts is known to some centimetres, and headings to some degrees.
const TWO_CAMERAS: &str = r#"
[[camera]]
name = "front"
driver = "synthetic"
synthetic = { trajectory = "standing", seed = 1 }

[[camera]]
name = "rear"
driver = "synthetic"
start = { position_m = [0.05, -0.04, 0.02], sigma_m = 0.05 }
synthetic = { trajectory = "standing", seed = 2 }
"#;

/// By how much the second one's start was measured too low, m: what clouds show, and poses do not know.
const TOO_LOW_M: f64 = 0.03;
/// What is told to be the error of a registration, 1σ.
const TURN_RAD: f64 = 1e-3;
const SHIFT_M: f64 = 3e-3;

/// Ends with the test.
struct Part(Child);

impl Drop for Part {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// This test binary again, as the process that registers clouds.
fn start_registration(domain: &TestDomain, told: &str, anchor: &str) -> Part {
    let child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "registration", "--nocapture"])
        .env(PART, "registration")
        .env(TOLD, told)
        .env(ANCHOR, anchor)
        .env("LODESTONE_SHM_PREFIX", &domain.prefix)
        .env("LODESTONE_SHM_ROOT", &domain.root)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    Part(child)
}

/// The truth of a camera.
fn truth_of(domain: &Domain, camera: &str) -> PublishSubscribe<Pose> {
    let Domain { prefix, root } = domain.clone();
    let node = Domain { prefix, root }.open_node("registration").unwrap();
    open_for_reading::<Pose>(&node, ServiceKind::Truth, camera).unwrap()
}

/// Not a test of its own: what a registration of two standing cameras finds, until it is killed.
#[test]
fn registration() {
    if std::env::var_os(PART).is_none() {
        return;
    }
    let (told, anchor) = (std::env::var(TOLD).unwrap(), std::env::var(ANCHOR).unwrap());
    let client = Client::connect().unwrap();
    let mut aiding = client.aiding(&told).unwrap();
    aiding = aiding.made_with(AidingOrigin::CloudRegistration).anchored_to(&anchor).unwrap();
    let services = [&told, &anchor].map(|camera| truth_of(client.domain(), camera));
    let ports = services.map(|service| service.subscriber_builder().create().unwrap());
    let mut newest = [None; 2];
    loop {
        for (newest, port) in newest.iter_mut().zip(&ports) {
            while let Some(pose) = port.receive().unwrap() {
                *newest = Some((DQuat::from_array(pose.orientation), DVec3::from(pose.position_m)));
            }
        }
        if let [Some((own, at)), Some((other, other_at))] = newest {
            let turned = Rotation::from_quaternion(other.conjugate() * own).unwrap();
            let distance = other.conjugate() * (at + DVec3::Z * TOO_LOW_M - other_at);
            let square = |sigma: f64| DMat3::IDENTITY * (sigma * sigma);
            // A registration takes its time: it is of where both were a little while ago.
            let then_ns = lodestone_client::monotonic_now_ns() - 80_000_000;
            // Until both lanes publish, nobody can be told.
            let _ = aiding.relative_pose(
                then_ns,
                (distance, square(SHIFT_M)),
                (turned, square(TURN_RAD)),
            );
        }
        std::thread::sleep(Duration::from_millis(200));
    }
}

/// What a command says in JSON, its last line; nothing if it failed.
fn ask(domain: &TestDomain, arguments: &[&str]) -> Option<Value> {
    let output = lodestone()
        .args(arguments)
        .args(["--json", "--prefix", &domain.prefix, "--root", &domain.root])
        .stdin(Stdio::null())
        .output()
        .expect("runs");
    let lines = String::from_utf8_lossy(&output.stdout).into_owned();
    let last = lines.lines().last()?;
    output.status.success().then(|| serde_json::from_str(last).expect("JSON"))
}

/// The pair, once both positions are known.
fn pair(domain: &TestDomain, wanted: impl Fn(&Value) -> bool) -> Value {
    eventually("the relative pose is as wanted", || {
        ask(domain, &["relative", "front", "rear"]).filter(|pair| {
            pair["distance_m"].is_array() && pair["orientation_xyzw"].is_array() && wanted(pair)
        })
    })
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or(f64::NAN)
}

fn distance_m(pair: &Value) -> DVec3 {
    let at = |k: usize| pair["distance_m"][k].as_f64().unwrap();
    DVec3::new(at(0), at(1), at(2))
}

#[test]
fn given_two_cameras_when_a_process_registers_their_clouds_then_their_relative_pose_is_exact() {
    let domain = TestDomain::new();
    let daemon = Daemon::start(&domain.configuration(TWO_CAMERAS));
    let before = pair(&domain, |_| true);
    assert!(number(&before, "orientation_sigma_deg") > 0.3, "{before}");
    assert!(number(&before, "distance_sigma_m") > 0.03, "{before}");

    // When rear is measured against front, again and again
    let clouds = start_registration(&domain, "rear", "front");
    let exact = |pair: &Value| {
        number(pair, "orientation_sigma_deg") < 0.1 && number(pair, "distance_sigma_m") < 5e-3
    };
    let after = pair(&domain, exact);
    // Then they are as far apart as they were measured
    assert_eq!(after["distance_source"], "cloud_registration", "{after}");
    let moved_m = (distance_m(&after) - distance_m(&before)).length();
    assert!((moved_m - TOO_LOW_M).abs() < 0.01, "{before} {after}");
    // And each is as unsure of the world as front is
    let health = ask(&domain, &["status", "--camera", "rear"]).unwrap();
    assert!(number(&health, "heading_sigma_deg") > 0.3, "{health}");

    // When somebody measures front against rear, then that is refused, and said why
    let backwards = start_registration(&domain, "front", "rear");
    eventually("the loop is refused", || {
        let status = ask(&domain, &["status", "--camera", "front"])?;
        let problems = status["problems"].as_array()?;
        let said = |problem: &Value| problem.as_str().is_some_and(|said| said.contains("anchor"));
        (number(&status, "aiding_refused") > 0.0 && problems.iter().any(said)).then_some(())
    });
    drop(backwards);

    // When nobody measures any more, then they stay close for a while, ever less surely
    drop(clouds);
    let at_once = number(&pair(&domain, exact), "orientation_sigma_deg");
    let later = pair(&domain, |pair| number(pair, "orientation_sigma_deg") > at_once);
    assert!(number(&later, "orientation_sigma_deg") < 0.3, "{later}");
    drop(daemon);
}
