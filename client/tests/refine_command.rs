//! `lodestone merge --refine`: two cameras that are not of one mind about where they look.

mod support;

use std::f64::consts::FRAC_PI_2;
use std::process::{Command, Output, Stdio};

use lodestone_client::{AidingKind, AidingOrigin};
use serde_json::Value;
use support::TestDomain;
use support::scanner::{HALF_ROOM_M, Scanner, Setup, scan_as_ordered};

/// What the second camera's poses are wrong by.
const YAW_RAD: f64 = 1.5 * std::f64::consts::PI / 180.0;
const SHIFT_M: [f64; 2] = [0.03, -0.04];

#[test]
#[ignore = "the source's side of the other tests, which start it themselves"]
fn scanner_process() {
    scan_as_ordered();
}

fn start_pair(domain: &TestDomain) -> [Scanner; 2] {
    let front = Setup { room: true, ..Setup::at([0.3, 0.5], FRAC_PI_2 - 0.3) };
    let side = Setup {
        room: true,
        pose_error: [SHIFT_M[0], SHIFT_M[1], YAW_RAD],
        camera_id: 1,
        ..Setup::at([-0.4, 0.2], FRAC_PI_2)
    };
    [Scanner::start(domain, "front", front), Scanner::start(domain, "side", side)]
}

fn merge(domain: &TestDomain, arguments: &[&str]) -> Output {
    let directory = tempfile::tempdir().expect("a directory");
    Command::new(env!("CARGO_BIN_EXE_lodestone"))
        .args(["--prefix", &domain.prefix, "--root", &domain.root, "merge", "front", "side"])
        .args(["--json"])
        .args(arguments)
        .current_dir(directory.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .output()
        .expect("runs")
}

fn report(output: &Output) -> Value {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// How far the merged cloud sticks out of the room's wall to the north, m.
fn beyond_wall_m(report: &Value) -> f64 {
    report["files"][0]["to_m"][1].as_f64().expect("an extent") - HALF_ROOM_M.y
}

#[test]
fn walls_of_two_cameras_coincide_after_refinement() {
    let domain = TestDomain::named("refine");
    let _pair = start_pair(&domain);
    let plain = report(&merge(&domain, &["--duration", "3"]));
    assert!(plain["cameras"][1]["refinement"].is_null());
    assert!(beyond_wall_m(&plain) > 0.03, "{} m", beyond_wall_m(&plain));

    let refined = report(&merge(&domain, &["--refine", "--duration", "12"]));
    let told = &refined["cameras"][1]["refinement"];
    assert!(told["accepted"].as_u64().unwrap() >= 1, "{refined}");
    assert_eq!(told["clouds_unrefined"], 0, "{refined}");
    assert!(beyond_wall_m(&refined) < 0.02, "{} m; {told}", beyond_wall_m(&refined));
    let turned = told["turn_rad"][2].as_f64().unwrap();
    assert!((turned + YAW_RAD).abs() < 0.003, "{told}");
    assert!(told["rmse_after_m"].as_f64().unwrap() < told["rmse_before_m"].as_f64().unwrap() / 2.0);
    assert!(told["fixes_offered"].is_null());
    // The anchor is never registered.
    assert!(refined["cameras"][0]["refinement"].is_null());
}

#[test]
fn fixes_arrive_at_the_lane_that_is_wrong() {
    let domain = TestDomain::named("aid");
    let _pair = start_pair(&domain);
    // A lane that listens, as the daemon's does.
    let listening = support::listener::start(&domain, "side");
    let output = merge(&domain, &["--refine", "--aid", "--duration", "12"]);
    let told = &report(&output)["cameras"][1]["refinement"];
    assert!(told["fixes_offered"].as_u64().unwrap() >= 1, "{told}");
    let fix = listening.last();
    assert_eq!(
        (fix.kind, fix.origin),
        (AidingKind::Pose.code(), AidingOrigin::CloudRegistration.code())
    );
    assert_eq!((fix.camera_id, fix.anchor, fix.world_epoch), (1, 1, 1));
    let yaw = 2.0 * fix.orientation[2].atan2(fix.orientation[3]);
    assert!((yaw - FRAC_PI_2).abs() < 0.003, "{yaw}");
    assert!((fix.value[0] + 0.4).abs() < 0.01 && (fix.value[1] - 0.2).abs() < 0.01, "{fix:?}");
    assert!(fix.value_covariance[0] > 0.0 && fix.value_covariance[0] < 2.5e-3);
}

#[test]
fn wrong_usage_is_said() {
    let domain = TestDomain::named("refine-usage");
    let _pair = start_pair(&domain);
    for (arguments, what) in [
        (&["--aid"][..], "--refine"),
        (&["--refine", "--anchor", "rear"][..], "no clouds of camera \"rear\" are merged"),
    ] {
        let output = merge(&domain, arguments);
        assert_eq!(output.status.code(), Some(2));
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.contains(what), "{said}");
    }
}
