//! `lodestoned calibrate` as a process: a recording or a synthetic camera in, a file out, and the
//! file applied by `lodestoned replay`.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]
#![allow(unreachable_pub, dead_code, reason = "the simulator serves several tests")]

#[path = "../calibration/tests/simulator/mod.rs"]
mod simulator;

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::{Command, Output};

use glam::{DMat3, DVec3};
use lodestone_calibration::Sample;
use lodestone_config::Calibration;
use lodestone_daemon::service::instance::InstanceLock;
use simulator::{Motion, Scene, Tilt, Unit, unit};
use tempfile::TempDir;

/// A directory in which the daemon's binary runs.
struct Place(TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, content: &str) {
        std::fs::write(self.path(name), content).unwrap();
    }

    fn lodestoned(&self, line: &str) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lodestoned"));
        command.args(line.split_whitespace()).current_dir(self.0.path()).env_remove("RUST_LOG");
        command.output().unwrap()
    }

    /// Runs a line that must end with this code; gives what it said.
    fn expect(&self, code: i32, line: &str) -> (String, String) {
        let output = self.lodestoned(line);
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let (out, err) = (text(&output.stdout), text(&output.stderr));
        assert_eq!(output.status.code(), Some(code), "{line}\n{out}\n{err}");
        (out, err)
    }

    fn calibration(&self, name: &str, serial: u64) -> Calibration {
        Calibration::load(self.path(name), serial).unwrap()
    }
}

fn csv(samples: &[Sample]) -> String {
    let mut text = String::from("t,gx,gy,gz,ax,ay,az,mx,my,mz\n");
    for sample in samples {
        let (g, a) = (sample.gyro_rad_s, sample.accel_m_s2);
        let t = sample.time_ns as f64 * 1e-9;
        write!(text, "{t:.6},{},{},{},{},{},{},", g.x, g.y, g.z, a.x, a.y, a.z).unwrap();
        match sample.mag_ut {
            Some(m) => writeln!(text, "{},{},{}", m.x, m.y, m.z).unwrap(),
            None => text.push_str(",,\n"),
        }
    }
    text
}

/// A scene of the yardstick as `turned.csv`.
fn recorded(place: &Place, scene: &Scene, seed: u64) -> Unit {
    let (samples, unit) = scene.draw(seed);
    place.write("turned.csv", &csv(&samples));
    unit
}

fn matrix(rows: [[f64; 3]; 3]) -> DMat3 {
    DMat3::from_cols_array_2d(&rows).transpose()
}

#[test]
fn a_recording_gives_a_file_that_corrects_the_heading() {
    for rate_hz in [50.0, 400.0] {
        let place = Place::new();
        let mag_every = if rate_hz > 100.0 { 8 } else { 1 };
        let scene = Scene { rate_hz, mag_every, ..Scene::yardstick(Tilt::Rock(5.0)) };
        let unit = recorded(&place, &scene, 4);
        place.expect(0, "calibrate turned.csv --serial 77 --out c.toml --mounting mast");
        let calibration = place.calibration("c.toml", 77);
        assert_eq!(calibration.mounting.as_deref(), Some("mast"));
        let m = calibration.magnetometer.unwrap();
        let hard = DVec3::from(m.hard_iron_ut);
        let error = scene.heading_error_of(&unit, matrix(m.soft_iron), hard, 4);
        assert!(error < 0.4, "{error}");
        assert!(error < 2.0 * m.heading_sigma_deg.unwrap(), "{error} {m:?}");
        assert_eq!(m.covariance.unwrap().len(), 12);
    }
}

#[test]
fn the_numbers_come_as_json_and_the_file_has_a_name_of_its_own() {
    let place = Place::new();
    recorded(&place, &Scene::yardstick(Tilt::Tumble), 5);
    let (out, _) = place.expect(0, "calibrate turned.csv --serial 78 --json");
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(json["accepted"], true);
    let m = place.calibration("calibration-78.toml", 78).magnetometer.unwrap();
    assert_eq!(json["heading_sigma_deg"].as_f64(), m.heading_sigma_deg);
}

#[test]
fn a_file_is_not_overwritten_unless_it_is_asked_for() {
    let place = Place::new();
    recorded(&place, &Scene::yardstick(Tilt::Tumble), 6);
    place.write("c.toml", "mine");
    let (_, err) = place.expect(2, "calibrate turned.csv --serial 79 --out c.toml");
    assert!(err.contains("c.toml: exists") && err.contains("--force"), "{err}");
    assert_eq!(std::fs::read_to_string(place.path("c.toml")).unwrap(), "mine");
    place.expect(0, "calibrate turned.csv --serial 79 --out c.toml --force");
    place.calibration("c.toml", 79);
    assert_eq!(std::fs::read_dir(place.0.path()).unwrap().count(), 2, "nothing is left beside it");
}

#[test]
fn a_movement_that_cannot_tell_is_refused_and_writes_nothing() {
    let place = Place::new();
    recorded(&place, &Scene::yardstick(Tilt::None), 7);
    let (out, err) = place.expect(1, "calibrate turned.csv --serial 80 --json");
    assert!(err.contains("no calibration: tilt to each side"), "{err}");
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(json["accepted"], false);
    assert!(json["missing"][0].as_str().unwrap().contains("tilt"), "{json}");
    assert!(!place.path("calibration-80.toml").exists());
}

#[test]
fn wrong_usage_is_said_before_anything_is_done() {
    let place = Place::new();
    recorded(&place, &Scene { duration_s: 5.0, ..Scene::yardstick(Tilt::Tumble) }, 8);
    assert!(place.expect(2, "calibrate turned.csv").1.contains("--serial"));
    place.expect(1, "calibrate missing.csv --serial 1");
    let (_, err) = place.expect(1, "calibrate turned.csv --serial 1");
    assert!(err.contains("record for longer"), "{err}");
}

/// The last heading of a file of poses, degrees clockwise from magnetic north of the body's x.
fn last_attitude(poses: &str) -> glam::DQuat {
    let mut lines = poses.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let last: Vec<&str> = lines.next_back().unwrap().split(',').collect();
    let value = |name: &str| -> f64 {
        let at = head.iter().position(|column| *column == name).unwrap();
        last[at].parse().unwrap()
    };
    glam::DQuat::from_xyzw(value("qx"), value("qy"), value("qz"), value("qw"))
}

#[test]
fn replay_applies_it_and_refuses_that_of_another_camera() {
    let place = Place::new();
    let scene = Scene { rest_s: 10.0, ..Scene::yardstick(Tilt::Rock(8.0)) };
    let unit = recorded(&place, &scene, 9);
    place.expect(0, "calibrate turned.csv --serial 81 --out c.toml");
    let (_, err) = place.expect(2, "replay turned.csv --out d --calibration c.toml --serial 82");
    assert!(err.contains("81") && err.contains("82"), "{err}");
    // The same unit on another way.
    let motion = Motion::drawn(&scene, 555);
    place.write("other.csv", &csv(&unit::record(&scene, &unit, &motion, 555)));
    let truth = motion.attitude(scene.duration_s - 0.02);
    let error = |options: &str| {
        place.expect(0, &format!("replay other.csv --out d {options}"));
        let poses = std::fs::read_to_string(place.path("d/other.csv")).unwrap();
        let error = truth * last_attitude(&poses).inverse();
        (2.0 * error.z.atan2(error.w)).to_degrees().rem_euclid(360.0)
    };
    let small = |angle: f64| angle.min(360.0 - angle);
    let with = small(error("--calibration c.toml --serial 81"));
    assert!(with < 1.5, "{with}");
    assert!((with - small(error("--calibration c.toml"))).abs() < 1e-9);
    let without = small(error(""));
    assert!(without > 3.0 * with.max(0.5), "{without} without, {with} with");
}

fn live_configuration(place: &Place, trajectory: &str, more: &str) -> String {
    format!(
        "[shared_memory]\nroot = \"{}\"\n[[camera]]\nname = \"front\"\nserial = 90\n\
         driver = \"synthetic\"\n[camera.synthetic]\ntrajectory = \"{trajectory}\"\nspeed = 0.0\n\
         seed = 3\n{more}\n[camera.synthetic.distortion]\nhard_iron_ut = [20.0, -25.0, 10.0]\n\
         soft_iron = [[1.08, 0.03, -0.04], [0.01, 0.93, 0.05], [-0.03, 0.02, 1.02]]\n",
        place.path("root").display()
    )
}

#[test]
fn a_camera_is_calibrated_live() {
    let place = Place::new();
    for (trajectory, hard_ut) in [("turns", 6.0), ("tumble", 1.0)] {
        let more = "duration_s = 100.0\nrest_s = 2.0";
        place.write("live.toml", &live_configuration(&place, trajectory, more));
        let out = format!("{trajectory}.toml");
        let line = format!("calibrate --camera 90 --config live.toml --out {out}");
        let (_, err) = place.expect(0, &line);
        assert!(err.contains("expected heading σ"), "{err}");
        let m = place.calibration(&out, 90).magnetometer.unwrap();
        let off = DVec3::from(m.hard_iron_ut) - DVec3::new(20.0, -25.0, 10.0);
        assert!(off.length() < hard_ut, "{trajectory}: {off}");
        assert!(m.heading_sigma_deg.unwrap() < 0.5, "{m:?}");
    }
}

#[test]
fn standing_live_is_refused_in_the_end() {
    let place = Place::new();
    place.write("live.toml", &live_configuration(&place, "standing", "duration_s = 40.0"));
    let (_, err) = place.expect(1, "calibrate --camera 90 --config live.toml");
    assert!(err.contains("turn through a whole circle"), "{err}");
    assert!(!place.path("calibration-90.toml").exists());
}

#[test]
fn a_camera_that_is_not_there_or_taken_is_said() {
    let place = Place::new();
    place.write("live.toml", &live_configuration(&place, "turns", ""));
    let (_, err) = place.expect(2, "calibrate --camera 91 --config live.toml");
    assert!(err.contains("--camera 91") && err.contains("90"), "{err}");
    let _daemon = InstanceLock::acquire(&place.path("root").display().to_string()).unwrap();
    let (_, err) = place.expect(1, "calibrate --camera 90 --config live.toml");
    assert!(err.contains("the cameras are taken: another lodestoned"), "{err}");
}
