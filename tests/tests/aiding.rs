//! A process that knows the wheels' speed aids the daemon: over real shared memory, three processes.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::process::{Child, Command, Stdio};
use std::time::Duration;

use glam::{DQuat, DVec3};
use lodestone_client::{AidingOrigin, Client};
use lodestone_schema::transport::{Domain, open_for_reading};
use lodestone_schema::{Pose, ServiceKind};
use lodestone_tests::system::{Daemon, Follower, TestDomain, eventually};

const PART: &str = "LODESTONE_TEST_PART";
/// Whom the wheels tell their speed: a camera or a body.
const TOLD: &str = "LODESTONE_TEST_TOLD";

/// A car that rests for three seconds and then drives. The bounds are wide, so that unsure values show.
const CAR: &str = r#"
[estimator.validity]
velocity_sigma_m_s = 1000.0
position_sigma_m = 1e6

[[body]]
name = "car"
vehicle = true

[[camera]]
name = "front"
driver = "synthetic"
body = "car"
synthetic = { trajectory = "car", rest_s = 3.0, seed = 3 }
"#;

/// The same with two cameras, which are fused to the car's own pose.
const CAR_WITH_TWO: &str = r#"
[estimator.validity]
velocity_sigma_m_s = 1000.0
position_sigma_m = 1e6

[[body]]
name = "car"
vehicle = true

[[camera]]
name = "front"
driver = "synthetic"
body = "car"
mounting = { position_m = [2.1, 0.0, 0.9], roll_pitch_yaw_deg = [0.0, 10.0, 0.0] }
synthetic = { trajectory = "car", rest_s = 3.0, seed = 3 }

[[camera]]
name = "rear"
driver = "synthetic"
body = "car"
mounting = { position_m = [-0.6, 0.0, 1.1], roll_pitch_yaw_deg = [0.0, 0.0, 180.0] }
synthetic = { trajectory = "car", rest_s = 3.0, seed = 4 }
"#;

/// How the car's x axis lies in the front camera of either configuration.
fn forward_in_camera(told: &str) -> DVec3 {
    let nose_down = if told == "car" { 10.0_f64.to_radians() } else { 0.0 };
    DQuat::from_rotation_y(nose_down).inverse() * DVec3::X
}

/// Ends with the test.
struct Part(Child);

impl Drop for Part {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// This test binary again, as the process that knows the speed.
fn start_wheels(domain: &TestDomain, told: &str) -> Part {
    let child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "wheels", "--nocapture"])
        .env(PART, "wheels")
        .env(TOLD, told)
        .env("LODESTONE_SHM_PREFIX", &domain.prefix)
        .env("LODESTONE_SHM_ROOT", &domain.root)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    Part(child)
}

/// Not a test of its own: what the wheels of the simulated car would tell, until it is killed.
#[test]
fn wheels() {
    if std::env::var_os(PART).is_none() {
        return;
    }
    let client = Client::connect().unwrap();
    let told = std::env::var(TOLD).unwrap();
    let forward = forward_in_camera(&told);
    let mut car = client.aiding(&told).unwrap().made_with(AidingOrigin::Odometry);
    let Domain { prefix, root } = client.domain().clone();
    let node = Domain { prefix, root }.open_node("wheels").unwrap();
    let truth = open_for_reading::<Pose>(&node, ServiceKind::Truth, "front").unwrap();
    let truth = truth.subscriber_builder().create().unwrap();
    loop {
        while let Some(pose) = truth.receive().unwrap() {
            let turned = DQuat::from_array(pose.orientation);
            let forward_m_s = (turned.conjugate() * DVec3::from(pose.velocity_m_s)).dot(forward);
            // Until the lane has published, nobody can be told.
            let _ = car.speed(pose.time_ns, forward_m_s, Some(0.05));
        }
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Standard deviation of the horizontal velocity, m/s.
fn velocity_sigma_m_s(pose: &serde_json::Value) -> f64 {
    let at = |k: usize| pose["velocity_covariance_m2_s2"][k].as_f64().unwrap_or(f64::NAN);
    (at(0) + at(3)).sqrt()
}

fn position_source(pose: &serde_json::Value) -> &str {
    pose["position_source"].as_str().unwrap_or_default()
}

#[test]
fn given_a_car_when_a_process_tells_its_speed_then_the_position_is_held_by_it() {
    speed_holds_the_position(CAR, "front");
}

#[test]
fn given_a_car_with_two_cameras_when_its_speed_is_told_to_the_body_then_it_holds_the_cars_position()
{
    speed_holds_the_position(CAR_WITH_TWO, "car");
}

/// The name is the camera's or the body's that is told the speed, and looked at.
fn speed_holds_the_position(configuration: &str, name: &str) {
    let domain = TestDomain::new();
    let daemon = Daemon::start(&domain.configuration(configuration));
    let follower = Follower::start(&domain, name);
    follower.await_more(10);
    // Without the wheels only the constraint holds the position, and the speed is guessed ever worse.
    let unaided = eventually("the car drives", || {
        let latest = follower.tally().latest;
        let driven = position_source(&latest) == "non_holonomic";
        (driven && velocity_sigma_m_s(&latest) > 0.5).then_some(latest)
    });

    let wheels = start_wheels(&domain, name);
    eventually("the speed aids, and is known better", || {
        let latest = follower.tally().latest;
        let surer = velocity_sigma_m_s(&latest) < velocity_sigma_m_s(&unaided);
        (position_source(&latest) == "aiding_speed" && surer).then_some(())
    });
    drop(wheels);
    eventually("the speed is missed once its source is gone", || {
        (position_source(&follower.tally().latest) != "aiding_speed").then_some(())
    });
    assert_eq!(follower.stop(), Some(0));
    drop(daemon);
}
