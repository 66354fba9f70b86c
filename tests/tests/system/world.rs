//! One world for all cameras: kept, restored, untouched by a camera's restart, defined anew on request.

use std::fs;
use std::path::Path;
use std::process::Stdio;

use lodestone_tests::system::{
    Daemon, Follower, TestDomain, eventually, lodestone, lodestoned, said,
};
use rustix::process::Signal;
use serde_json::Value;

/// Both stand; the first one in the origin, the other one beside it.
const TWO_CAMERAS: &str = r#"
[world]
keep = "world.toml"

[[camera]]
name = "front"
driver = "synthetic"
synthetic = { trajectory = "standing", seed = 1 }

[[camera]]
name = "rear"
driver = "synthetic"
start = { position_m = [0.3, -0.4, 0.1], sigma_m = 0.02 }
synthetic = { trajectory = "standing", seed = 2 }
"#;

const REAR_M: [f64; 3] = [0.3, -0.4, 0.1];

/// Longest distance that a standing camera's position errs by, m: its sigma is some centimetres.
const NEAR_M: f64 = 0.1;

/// What a command says in JSON, one value for each line; nothing if it failed.
fn ask(domain: &TestDomain, arguments: &[&str]) -> Option<Vec<Value>> {
    let output = lodestone()
        .args(arguments)
        .args(["--json", "--prefix", &domain.prefix, "--root", &domain.root])
        .stdin(Stdio::null())
        .output()
        .expect("runs");
    let lines = String::from_utf8_lossy(&output.stdout).into_owned();
    let values = lines.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    output.status.success().then_some(values)
}

/// The world, once it is fixed.
fn world(domain: &TestDomain) -> Value {
    eventually("the world is fixed", || {
        ask(domain, &["world"])?.pop().filter(|world| world["epoch"].is_u64())
    })
}

/// The latest pose, once its position is known.
fn placed(follower: &Follower) -> Value {
    eventually("the camera is in the world", || {
        let pose = follower.tally().latest;
        pose["position_m"].is_array().then_some(pose)
    })
}

fn distance(pose: &Value, from: [f64; 3]) -> f64 {
    let position = pose["position_m"].as_array().expect("a position");
    let square = |(at, from): (&Value, f64)| (at.as_f64().expect("a number") - from).powi(2);
    position.iter().zip(from).map(square).sum::<f64>().sqrt()
}

fn sigma_m(pose: &Value) -> f64 {
    pose["position_covariance_m2"][0].as_f64().expect("a variance").sqrt()
}

fn ends_well(daemon: Daemon) {
    daemon.signal(Signal::TERM);
    assert_eq!(daemon.ended().0, Some(0));
}

/// Waits until the file holds both cameras of the present epoch.
fn await_kept(path: &Path) {
    eventually("both cameras are kept", || {
        let text = fs::read_to_string(path).ok()?;
        (text.matches("[[camera]]").count() == 2).then_some(())
    });
}

#[test]
fn given_a_kept_world_when_the_daemon_ends_or_is_killed_then_the_next_one_has_the_same_world() {
    // Given a world that was fixed
    let domain = TestDomain::new();
    let configuration = domain.configuration(TWO_CAMERAS);
    let kept = configuration.with_file_name("world.toml");
    let daemon = Daemon::start(&configuration);
    let first = world(&domain);
    assert_eq!((&first["state"], &first["first_camera"]), (&"fixed".into(), &"front".into()));
    assert_eq!(first["epoch"], 1);
    await_kept(&kept);
    ends_well(daemon);

    for how_it_ends in ["asked", "killed"] {
        // When the next daemon starts
        let daemon = Daemon::start(&configuration);
        let follower = Follower::start(&domain, "rear");
        // Then it is the same world, and the cameras are where they were, if nobody has moved them
        let again = world(&domain);
        assert_eq!(again["state"], "restored");
        for key in ["epoch", "t0_unix_ns", "first_camera", "heading_sigma_deg"] {
            assert_eq!(again[key], first[key], "{key}");
        }
        let rear = placed(&follower);
        assert_eq!(rear["world_epoch"], 1);
        assert!(distance(&rear, REAR_M) < NEAR_M, "{rear}");
        assert!(sigma_m(&rear) >= 0.3, "0.3 m is how far they may have been moved: {rear}");
        if how_it_ends == "killed" { daemon.kill() } else { ends_well(daemon) }
    }
}

#[test]
fn given_no_keeping_then_each_run_has_a_world_of_its_own_and_a_number_of_its_own() {
    let domain = TestDomain::new();
    let configuration = domain.configuration(&TWO_CAMERAS.replace("keep = \"world.toml\"", ""));
    for epoch in 1..=2 {
        let daemon = Daemon::start(&configuration);
        let world = world(&domain);
        assert_eq!((&world["state"], &world["kept"]), (&"fixed".into(), &false.into()));
        assert_eq!(world["epoch"], epoch, "worlds of different runs are told apart");
        ends_well(daemon);
    }
}

#[test]
fn when_the_first_camera_is_unplugged_then_it_comes_back_to_its_place_and_no_other_camera_notices()
{
    // Given two standing cameras, of which the first is unplugged for a while after some seconds
    let domain = TestDomain::new();
    let fault = "[[camera.fault]]\nkind = \"unplug\"\nat_s = 4.0\nduration_s = 0.6\n";
    let with_fault = TWO_CAMERAS.replacen("seed = 1 }\n", &format!("seed = 1 }}\n{fault}"), 1);
    let daemon = Daemon::start(&domain.configuration(&with_fault));
    let (front, rear) = (Follower::start(&domain, "front"), Follower::start(&domain, "rear"));
    let (front_before, rear_before) = (placed(&front), placed(&rear));
    let t0 = world(&domain)["t0_unix_ns"].clone();
    assert_eq!(front_before["reset_counter"], 0);

    // When it is there again
    let front_after = eventually("the camera is aligned again", || {
        let pose = front.tally().latest;
        (pose["reset_counter"] == 1 && pose["position_covariance_m2"].is_array()).then_some(pose)
    });
    // Then it stands where it stood, less surely, in the same world
    assert_eq!(front_after["world_epoch"], front_before["world_epoch"]);
    assert!(distance(&front_after, [0.0; 3]) < NEAR_M, "{front_after}");
    assert!(sigma_m(&front_after) > 3.0 * sigma_m(&front_before), "{front_after}");
    assert_eq!(world(&domain)["t0_unix_ns"], t0);
    // And the other one has missed nothing: no reset, no jump, no pose lost
    rear.await_more(100);
    let rear_after = rear.tally().latest;
    assert_eq!(rear_after["reset_counter"], 0);
    assert_eq!(rear_after["world_epoch"], rear_before["world_epoch"]);
    assert!(distance(&rear_after, REAR_M) < NEAR_M, "{rear_after}");
    ends_well(daemon);
}

#[test]
fn a_new_world_on_request_or_signal_raises_epoch_and_reset_counters_and_goes_to_the_starts() {
    let domain = TestDomain::new();
    let daemon = Daemon::start(&domain.configuration(TWO_CAMERAS));
    let (front, rear) = (Follower::start(&domain, "front"), Follower::start(&domain, "rear"));
    let before = world(&domain);
    for follower in [&front, &rear] {
        assert_eq!(placed(follower)["world_epoch"], before["epoch"]);
    }

    let asked = ask(&domain, &["world", "reset"]).expect("it is done").pop().unwrap();
    assert_eq!((&asked["epoch"], &asked["state"]), (&2.into(), &"fixed".into()));
    assert!(asked["t0_unix_ns"].as_i64() > before["t0_unix_ns"].as_i64());
    daemon.signal(Signal::USR1);
    let signalled = eventually("the signal is heard", || {
        Some(world(&domain)).filter(|world| world["epoch"] == 3)
    });
    assert_eq!(signalled["first_camera"], "front");

    for (follower, place) in [(&front, [0.0; 3]), (&rear, REAR_M)] {
        let pose = eventually("the camera is in the third world", || {
            let pose = follower.tally().latest;
            (pose["world_epoch"] == 3 && pose["position_m"].is_array()).then_some(pose)
        });
        assert_eq!(pose["reset_counter"], 2, "once for each new world");
        assert!(distance(&pose, place) < NEAR_M, "{pose}");
    }
    ends_well(daemon);
}

#[test]
fn who_comes_late_gets_every_pair_and_the_whole_tree() {
    let third = "[[camera]]\nname = \"hand\"\ndriver = \"synthetic\"\n\
                 synthetic = { trajectory = \"standing\", seed = 3 }\n";
    let domain = TestDomain::new();
    let daemon = Daemon::start(&domain.configuration(&format!("{TWO_CAMERAS}\n{third}")));
    let follower = Follower::start(&domain, "hand");
    follower.await_more(800);

    let pairs = ask(&domain, &["relative"]).expect("every pair");
    let named: Vec<_> = pairs.iter().map(|p| (&p["camera_a"], &p["camera_b"])).collect();
    let expected = [("front", "rear"), ("front", "hand"), ("rear", "hand")].map(|(a, b)| {
        let names: (Value, Value) = (a.into(), b.into());
        names
    });
    assert_eq!(named, expected.iter().map(|(a, b)| (a, b)).collect::<Vec<_>>());
    // The rear camera's place was declared: the distance is known, and where from.
    assert_eq!(pairs[0]["distance_source"], "common_start");
    let length: f64 = pairs[0]["distance_m"]
        .as_array()
        .unwrap()
        .iter()
        .map(|x| x.as_f64().unwrap().powi(2))
        .sum::<f64>()
        .sqrt();
    assert!((length - 0.26_f64.sqrt()).abs() < NEAR_M, "{length} m");
    // Nobody has said where the third one stands: no distance, and no zero either.
    for pair in &pairs[1..] {
        assert_eq!(pair["distance_source"], "unknown");
        assert!(pair["distance_m"].is_null() && pair["orientation_xyzw"].is_array(), "{pair}");
    }
    // The other way round on demand.
    let turned = ask(&domain, &["relative", "rear", "front"]).expect("a pair").pop().unwrap();
    assert_eq!(turned["camera_a"], "rear");

    let edges = ask(&domain, &["transforms"]).expect("the tree");
    assert_eq!(edges.len(), 9, "a camera, its lens and its magnetometer, three times");
    assert!(edges.iter().all(|edge| edge["moving"] == edge["rotation_xyzw"].is_null()));
    let hand = follower.tally().latest;
    assert!(hand["position_m"].is_null(), "{hand}");
    assert!(hand["world_epoch"].is_u64(), "{hand}");
    ends_well(daemon);
}

#[test]
fn when_the_first_camera_never_comes_then_after_a_while_the_next_one_fixes_the_world() {
    let domain = TestDomain::new();
    let absent = TWO_CAMERAS
        .replacen("driver = \"synthetic\"", "driver = \"zed2\"\nserial = 1", 1)
        .replacen("synthetic = { trajectory = \"standing\", seed = 1 }", "", 1)
        .replace("[world]", "[world]\npatience_s = 0.5");
    let daemon = Daemon::start(&domain.configuration(&absent));
    let rear = Follower::start(&domain, "rear");
    let world = world(&domain);
    assert_eq!((&world["first_camera"], &world["epoch"]), (&"rear".into(), &1.into()));
    // It has a start, so it stands there, and the origin is where the first camera would be.
    let pose = placed(&rear);
    assert!(distance(&pose, REAR_M) < NEAR_M, "{pose}");
    assert!(daemon.log().contains("front is not there: rear fixes the world"), "{}", daemon.log());
    ends_well(daemon);
}

#[test]
fn a_damaged_world_is_refused_with_its_line_and_nothing_is_overwritten() {
    let domain = TestDomain::new();
    let configuration = domain.configuration(TWO_CAMERAS);
    let kept = configuration.with_file_name("world.toml");
    let damaged = "format = 1\nepoch = -3\n";
    fs::write(&kept, damaged).unwrap();
    for command in ["check", "run"] {
        let output = lodestoned()
            .args([command, "--config"])
            .arg(&configuration)
            .stdin(Stdio::null())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(said(&output).contains("world.toml:2: epoch: -3"), "{}", said(&output));
    }
    assert_eq!(fs::read_to_string(&kept).unwrap(), damaged);
}
