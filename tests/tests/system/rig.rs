//! A rig whose member fails, as its users see it.

use lodestone_tests::system::{Daemon, Follower, TestDomain, eventually, lodestone};
use serde_json::Value;

/// Three cameras on a body, one of which gives nothing that can be used from ten seconds on, and one beside it.
const RIG: &str = r#"
[[body]]
name = "rig"

[[camera]]
name = "front"
driver = "synthetic"
body = "rig"
mounting = { position_m = [0.3, 0.0, 0.0] }
synthetic = { trajectory = "standing", seed = 1 }

[[camera]]
name = "left"
driver = "synthetic"
body = "rig"
mounting = { position_m = [0.0, 0.3, 0.0], roll_pitch_yaw_deg = [0.0, 0.0, 90.0] }
synthetic = { trajectory = "standing", seed = 2 }
[[camera.fault]]
kind = "not-a-number"
at_s = 10.0
duration_s = 86400.0

[[camera]]
name = "right"
driver = "synthetic"
body = "rig"
mounting = { position_m = [0.0, -0.3, 0.0], roll_pitch_yaw_deg = [0.0, 0.0, -90.0] }
synthetic = { trajectory = "standing", seed = 3 }

[[camera]]
name = "outside"
driver = "synthetic"
start = { position_m = [2.0, 0.0, 0.0] }
synthetic = { trajectory = "standing", seed = 4 }
"#;

/// What `lodestone status` says of one camera or body.
fn status(domain: &TestDomain, name: &str) -> Value {
    let output = lodestone()
        .args(["status", "--json", "--camera", name, "--prefix", &domain.prefix])
        .args(["--root", &domain.root])
        .output()
        .expect("runs");
    serde_json::from_slice(&output.stdout).unwrap_or_default()
}

fn says(report: &Value, status: &str) -> bool {
    report["status"].as_array().is_some_and(|words| words.iter().any(|word| word == status))
}

#[test]
fn given_a_member_that_fails_then_the_rig_says_so_and_its_pose_goes_on() {
    // Given a rig of three, all of which count
    let domain = TestDomain::new();
    let daemon = Daemon::start(&domain.configuration(RIG));
    let failing = Follower::start(&domain, "left");
    let outside = Follower::start(&domain, "outside");
    let all = eventually("all members count", || {
        let rig = status(&domain, "rig");
        (rig["members_in_use"] == serde_json::json!([true, true, true])).then_some(rig)
    });
    assert!(says(&all, "on_body") && !says(&all, "member_out"), "{all}");
    assert!(all["sample_rate_hz"].is_null(), "a body has no sensor: {all}");
    // When one of them gives nothing that can be used
    let rig = eventually("the rig says who is out", || {
        let rig = status(&domain, "rig");
        (rig["members_in_use"] == serde_json::json!([true, false, true])).then_some(rig)
    });
    assert!(says(&rig, "member_out"), "{rig}");
    // Then its pose, which is the rig's, goes on and is valid, with its sensor said to be silent
    failing.await_more(400);
    let report = status(&domain, "left");
    assert!(says(&report, "sensor_stale") && says(&report, "on_body"), "{report}");
    assert!(report["pose_rate_hz"].as_f64().is_some_and(|rate_hz| rate_hz > 0.0), "{report}");
    assert!(report["heading_deg"].is_f64(), "{report}");
    // And nobody else notices
    assert!(!says(&outside.tally().latest, "member_out"));
    assert_eq!(outside.tally().latest["reset_counter"], 0);
    assert_eq!(failing.tally().latest["reset_counter"], 0);
    assert_eq!((failing.stop(), outside.stop()), (Some(0), Some(0)));
    drop(daemon);
}
