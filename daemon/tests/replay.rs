//! `lodestoned replay` as a process: every row, and what the configuration says of the camera.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod common;

use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Output};

use common::said;
use tempfile::TempDir;

const ROWS: usize = 1_000;

/// A camera at rest for ten seconds, with `row` for the nine values of each row.
fn recording(row: &str) -> String {
    let mut text = String::from("t,gx,gy,gz,ax,ay,az,mx,my,mz\n");
    for n in 0..ROWS {
        writeln!(text, "{:.2},{row}", n as f64 * 0.01).unwrap();
    }
    text
}

const IN_BODY_AXES: &str = "0,0,0,0.125,0.25,9.8125,3.5,20.25,-40.75";

/// A directory with files, in which the daemon's binary runs.
struct Place(TempDir);

impl Place {
    fn with(files: &[(&str, &str)]) -> Self {
        let place = tempfile::tempdir().unwrap();
        for (name, content) in files {
            std::fs::write(place.path().join(name), content).unwrap();
        }
        Self(place)
    }

    fn lodestoned(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lodestoned"));
        command.args(arguments).current_dir(self.0.path()).env_remove("RUST_LOG");
        command.output().unwrap()
    }

    /// The poses of a recording of this place.
    fn replayed(&self, file: &str, config: Option<&str>) -> String {
        let mut arguments = vec!["replay", file, "--out", "poses"];
        arguments.extend(config.iter().flat_map(|config| ["--config", config]));
        let output = self.lodestoned(&arguments);
        assert!(output.status.success(), "{}", said(&output));
        std::fs::read_to_string(self.0.path().join("poses").join(Path::new(file))).unwrap()
    }
}

fn configuration(lane: &str, camera: &str) -> String {
    format!(
        "[lane]\n{lane}\n[[camera]]\nname = \"recorded\"\ndriver = \"replay\"\n{camera}\n\
         [camera.replay]\nfile = \"rest.csv\"\n"
    )
}

#[test]
fn the_smallest_ring_loses_no_row() {
    let config = configuration("ring_capacity = 16", "");
    let place = Place::with(&[("rest.csv", &recording(IN_BODY_AXES)), ("small.toml", &config)]);
    let with_small_ring = place.replayed("rest.csv", Some("small.toml"));
    assert_eq!(with_small_ring.lines().count(), ROWS + 1);
    assert_eq!(with_small_ring, place.replayed("rest.csv", None));
}

#[test]
fn a_recording_in_sensor_axes_is_turned_by_the_axis_map() {
    // Body forward is sensor z, left is y, up is -x.
    let in_sensor_axes = recording("0,0,0,-9.8125,0.25,0.125,40.75,20.25,3.5");
    let config = configuration("", "axis_map = [\"z\", \"y\", \"-x\"]");
    let place = Place::with(&[
        ("rest.csv", &recording(IN_BODY_AXES)),
        ("sensor.csv", &in_sensor_axes),
        ("zed.toml", &config),
    ]);
    let turned = place.replayed("sensor.csv", Some("zed.toml"));
    assert!(!turned.lines().last().unwrap().contains(",,"), "there are poses at the end");
    assert_eq!(turned, place.replayed("rest.csv", None));
}

const CALIBRATION: &str = "serial = 7\ndate = 2026-05-31\n[magnetometer]\n\
     hard_iron_ut = [16.0, -8.0, 4.0]\nhard_iron_slope_ut_k = [0.0, 0.0, 0.0]\n\
     reference_temperature_c = 25.0\n\
     soft_iron = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]\n";

#[test]
fn the_replayed_cameras_calibration_applies() {
    let distorted = recording("0,0,0,0.125,0.25,9.8125,19.5,12.25,-36.75");
    let config = configuration("", "serial = 7\ncalibration = \"camera.toml\"");
    let place = Place::with(&[
        ("rest.csv", &recording(IN_BODY_AXES)),
        ("distorted.csv", &distorted),
        ("camera.toml", CALIBRATION),
        ("calibrated.toml", &config),
    ]);
    // All but the status column, which says that a calibration applies.
    let poses = |text: &str| -> Vec<String> {
        let row = |line: &str| line.split(',').take(15).collect::<Vec<_>>().join(",");
        text.lines().map(row).collect()
    };
    let calibrated = place.replayed("distorted.csv", Some("calibrated.toml"));
    assert_eq!(poses(&calibrated), poses(&place.replayed("rest.csv", None)));
    assert_ne!(poses(&calibrated), poses(&place.replayed("distorted.csv", None)));
}

#[test]
fn a_calibration_that_cannot_be_used_is_a_wrong_configuration_for_every_command() {
    let config = configuration("", "serial = 8\ncalibration = \"camera.toml\"");
    let place = Place::with(&[
        ("rest.csv", &recording(IN_BODY_AXES)),
        ("camera.toml", CALIBRATION),
        ("other.toml", &config),
    ]);
    let replay = ["replay", "rest.csv", "--out", "poses", "--config", "other.toml"];
    for arguments in [&["run", "--config", "other.toml"][..], &replay] {
        let output = place.lodestoned(arguments);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(said(&output).contains("camera.toml"), "{}", said(&output));
    }
}

#[test]
fn two_recordings_of_one_name_are_wrong_usage() {
    let place = Place::with(&[("rest.csv", &recording(IN_BODY_AXES))]);
    let output = place.lodestoned(&["replay", "rest.csv", "rest.csv", "--out", "poses"]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
}

/// Three cameras at rest on one rig, in recordings of their own.
fn rig_of_three() -> String {
    let mut text = String::from("[[body]]\nname = \"rig\"\n");
    for (name, x) in [("left", "0.3"), ("middle", "0.0"), ("right", "-0.3")] {
        write!(
            text,
            "[[camera]]\nname = \"{name}\"\ndriver = \"replay\"\nbody = \"rig\"\n\
             [camera.mounting]\nposition_m = [0.0, {x}, 0.0]\n\
             [camera.replay]\nfile = \"{name}.csv\"\n"
        )
        .unwrap();
    }
    text
}

#[test]
fn a_configurations_recordings_are_replayed_together_and_a_short_one_is_left_out() {
    let (whole, short) = (recording(IN_BODY_AXES), recording(IN_BODY_AXES));
    let short: Vec<&str> = short.lines().take(ROWS / 2).collect();
    let place = Place::with(&[
        ("left.csv", &whole),
        ("middle.csv", &whole),
        ("right.csv", &short.join("\n")),
        ("rig.toml", &rig_of_three()),
    ]);
    let output = place.lodestoned(&["replay", "--config", "rig.toml", "--out", "poses"]);
    assert!(output.status.success(), "{}", said(&output));
    let rows = |name: &str| {
        let text = std::fs::read_to_string(place.0.path().join("poses").join(name)).unwrap();
        text.lines().skip(1).map(str::to_owned).collect::<Vec<_>>()
    };
    for name in ["rig.csv", "left.csv", "middle.csv", "right.csv"] {
        let rows = rows(name);
        assert_eq!(rows.len(), ROWS - 1, "{name}");
        let known = rows.last().unwrap().split(',').nth(4).is_some_and(|w| !w.is_empty());
        assert!(known, "{name}: the pose goes on without one member");
    }
    assert!(rows("rig-gradient.csv").is_empty(), "three in a line tell no gradient");
}

#[test]
fn without_any_recording_it_says_what_it_needs() {
    let place = Place::with(&[]);
    let output = place.lodestoned(&["replay", "--out", "poses"]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(said(&output).contains("no recording: name FILE"), "{}", said(&output));
}

/// Values of a column of a CSV, row by row.
fn column(text: &str, name: &str) -> Vec<String> {
    let mut lines = text.lines();
    let at = lines.next().unwrap().split(',').position(|column| column == name).unwrap();
    lines.map(|line| line.split(',').nth(at).unwrap().to_owned()).collect()
}

fn number(text: &str) -> f64 {
    text.parse().unwrap()
}

#[test]
fn pairs_of_replayed_cameras_are_written_with_the_distances_source() {
    let mut config = rig_of_three();
    config += "[[camera]]\nname = \"outside\"\ndriver = \"replay\"\n\
               start = { position_m = [2.0, 0.0, 0.0] }\nreplay = { file = \"left.csv\" }\n";
    let whole = recording(IN_BODY_AXES);
    let place = Place::with(&[
        ("left.csv", &whole),
        ("middle.csv", &whole),
        ("right.csv", &whole),
        ("rig.toml", &config),
    ]);
    let output = place.lodestoned(&["replay", "--config", "rig.toml", "--out", "poses"]);
    assert!(output.status.success(), "{}", said(&output));
    // What became of the single camera's rows is said as for a recording of its own.
    assert!(said(&output).contains("rows=1000"), "{}", said(&output));
    let pairs = std::fs::read_to_string(place.0.path().join("poses/relative.pairs.csv")).unwrap();
    let names: Vec<(String, String)> =
        column(&pairs, "a").into_iter().zip(column(&pairs, "b")).collect();
    let last = |a: &str, b: &str| {
        let at = names.iter().rposition(|(x, y)| (x.as_str(), y.as_str()) == (a, b)).unwrap();
        let at = |name| number(&column(&pairs, name)[at]);
        (at("distance_source"), [at("dx"), at("dy"), at("dz")])
    };
    // Given members in one body: as surveyed. Given one beside them: by where both began.
    assert_eq!(last("left", "right"), (1.0, [0.0, -0.6, 0.0]));
    let (source, distance) = last("left", "outside");
    assert!((source - 2.0).abs() < 1e-9, "common start: {source}");
    let length = distance.iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!((length - 2.0).abs() < 0.05, "{distance:?}");
}

#[test]
fn a_rigs_poses_are_written_in_the_axes_that_were_asked_for() {
    let whole = recording(IN_BODY_AXES);
    let place = Place::with(&[
        ("left.csv", &whole),
        ("middle.csv", &whole),
        ("right.csv", &whole),
        ("rig.toml", &rig_of_three()),
    ]);
    let poses = |frame: &str| {
        let arguments = ["replay", "--config", "rig.toml", "--out", frame, "--frame", frame];
        let output = place.lodestoned(&arguments);
        assert!(output.status.success(), "{}", said(&output));
        let text = std::fs::read_to_string(place.0.path().join(frame).join("right.csv")).unwrap();
        ["px", "py", "pz"].map(|name| number(column(&text, name).last().unwrap()))
    };
    let [east, north, up] = poses("enu");
    assert!((east * east + north * north).sqrt() > 0.5, "it stands beside the first camera");
    let swapped = poses("ned").map(f64::to_bits);
    assert_eq!(swapped, [north, east, -up].map(f64::to_bits));
}

#[test]
fn a_fix_without_sense_is_counted_and_corrects_nothing() {
    for fix in ["1,2,3,-0.1", "1e300,2,3,0.1", "1,2,3,0"] {
        let text = recording(&format!("{IN_BODY_AXES},{fix}"));
        let text = text.replacen("mx,my,mz", "mx,my,mz,fix_x,fix_y,fix_z,fix_sigma", 1);
        let place = Place::with(&[("rest.csv", &text)]);
        let output = place.lodestoned(&["replay", "rest.csv", "--out", "poses"]);
        assert!(output.status.success(), "{}", said(&output));
        assert!(said(&output).contains("aiding_used=0"), "{fix}: {}", said(&output));
    }
}
