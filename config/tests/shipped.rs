//! The shipped files: valid, and saying what they are meant to say.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use lodestone_config::model::{CameraModel, DriverKind, TrajectoryKind};
use lodestone_config::{Config, DYNAMIC_SCENARIO, EMBEDDED, STATIC_SCENARIOS};

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("shipped").join(name)
}

fn load(name: &str) -> Config {
    Config::load(shipped(name)).unwrap_or_else(|error| panic!("{error}")).config
}

#[test]
fn every_shipped_file_is_valid_and_serde_reads_the_same() {
    let entries = std::fs::read_dir(shipped("")).expect("the directory is in the repository");
    let files: Vec<PathBuf> = entries
        .map(|entry| entry.expect("readable").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .collect();
    assert!(files.len() >= 3);
    for path in files {
        let loaded = Config::load(&path).unwrap_or_else(|error| panic!("{error}"));
        let text = std::fs::read_to_string(&path).expect("readable");
        assert_eq!(loaded.config, toml::from_str(&text).expect("serde agrees"));
    }
}

#[test]
fn the_embedded_configuration_is_two_walks_with_different_seeds() {
    let config = Config::embedded();
    assert_eq!(config, toml::from_str(EMBEDDED).expect("valid"));
    let names: Vec<&str> = config.camera.iter().map(|camera| camera.name.as_str()).collect();
    assert_eq!(names, ["front", "rear"]);
    let walks = config.camera.iter().filter_map(|camera| camera.synthetic.as_ref());
    let walks: Vec<_> = walks.filter(|s| s.trajectory == TrajectoryKind::Walk).collect();
    let seeds: BTreeSet<u64> = walks.iter().map(|synthetic| synthetic.seed).collect();
    assert_eq!(seeds.len(), 2);
    for synthetic in walks {
        assert!(synthetic.rest_s > config.estimator.alignment_rest_s, "no time to align");
        assert!((synthetic.speed - 1.0).abs() < f64::EPSILON);
        assert!(synthetic.duration_s == 0.0, "the demonstration would end");
    }
}

#[test]
fn the_vehicle_has_one_camera_of_each_model_found_by_serial() {
    let config = load("zed2-vehicle.toml");
    let models: Vec<CameraModel> = config.camera.iter().map(|camera| camera.model).collect();
    assert_eq!(models, [CameraModel::Zed2, CameraModel::Zed2i]);
    for camera in &config.camera {
        assert_eq!(camera.driver, DriverKind::Zed2);
        assert!(camera.serial > 0);
        assert!(camera.mounting.position_m.iter().any(|&coordinate| coordinate != 0.0));
    }
    let rigs = config.rigs();
    assert_eq!(rigs.len(), 1, "both are on the vehicle");
    assert_eq!(rigs[0].members, [0, 1]);
    assert!(config.body[rigs[0].body].vehicle);
}

#[test]
fn the_replay_finds_its_recording_beside_it() {
    let loaded = Config::load(shipped("replay.toml")).expect("valid");
    let recording = loaded.recording(&loaded.config.camera[0]);
    assert_eq!(recording, Some(shipped("recording.csv.zst")));
}

#[test]
fn the_summary_names_cameras_sources_and_rates() {
    let text = Config::embedded().summary();
    for part in [
        "2 cameras",
        "front",
        "rear",
        "synthetic walk, seed 1, 401.6 Hz",
        "397.6 Hz",
        "depth 400 × 250 at 15 Hz",
        "6.6 × 7 × 2.6 m with 12 solids",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    let text = load("zed2-vehicle.toml").summary();
    for part in ["zed2, 400 Hz nominal", "serial 23456789", "not calibrated", "true north"] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    let text = load("replay.toml").summary();
    for part in ["1 camera\n", "replay of recording.csv.zst", "real speed, repeated"] {
        assert!(text.contains(part), "{part}\n{text}");
    }
}

#[test]
fn the_scenarios_are_valid_places_of_one_camera_each() {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let files = std::fs::read_dir(&directory).expect("the directory is in the repository");
    let embedded = STATIC_SCENARIOS.len() + 1;
    assert_eq!(files.count(), embedded, "a scenario is not embedded");
    let mut names = BTreeSet::new();
    let mut biases = BTreeSet::new();
    for (file, text) in STATIC_SCENARIOS {
        let config = Config::from_toml(file, text).unwrap_or_else(|errors| panic!("{errors}"));
        assert_eq!(config, toml::from_str(text).expect("serde agrees"));
        assert_eq!(config.camera.len(), 1);
        let camera = &config.camera[0];
        assert_eq!(format!("{}.toml", camera.name), file);
        names.insert(camera.name.clone());
        let synthetic = camera.synthetic.as_ref().expect("a synthetic camera");
        assert!(config.world.year.is_some(), "{file}: the field would change with the day");
        assert!(synthetic.duration_s > 0.0, "{file} never ends");
        let movable = [TrajectoryKind::Tumble, TrajectoryKind::Circles];
        assert!(movable.contains(&synthetic.trajectory), "{file} does not calibrate");
        assert!(synthetic.distortion.hard_iron_ut.iter().any(|&b| b != 0.0));
        biases.insert(format!("{:?}", synthetic.errors));
    }
    assert_eq!(names.len(), STATIC_SCENARIOS.len());
    assert_eq!(biases.len(), 1, "it is one camera that is carried from place to place");
}

#[test]
fn the_dynamic_scenes_are_one_camera_that_rests_long_enough_and_then_moves_in_its_own_way() {
    let (file, text) = DYNAMIC_SCENARIO;
    let config = Config::from_toml(file, text).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(config, toml::from_str(text).expect("serde agrees"));
    assert!(config.world.year.is_some(), "the field would change with the day");
    let scenes = config.camera.iter().map(|c| c.synthetic.as_ref().expect("a synthetic camera"));
    let scenes: Vec<_> = scenes.collect();
    let stairs = TrajectoryKind::Stairs;
    let kinds = [TrajectoryKind::Standing, TrajectoryKind::Walk, stairs, stairs];
    assert_eq!(scenes.iter().map(|s| s.trajectory).collect::<Vec<_>>(), kinds);
    assert_eq!(scenes[2].seed, scenes[3].seed, "one walker");
    assert!(scenes[2].halt_s == 0.0 && scenes[3].halt_s > 0.0);
    for scene in &scenes {
        assert!(scene.duration_s - scene.rest_s > 60.0, "the table ends at 60 s of motion");
        assert_eq!(scene.errors, scenes[0].errors, "one camera");
        assert_eq!(scene.distortion, scenes[0].distortion, "one camera");
        assert_eq!(scene.errors.accel_bias_m_s2, None, "biases are drawn for each run");
    }
}

#[test]
fn the_rig_is_three_cameras_that_ride_on_one_body_and_are_not_in_a_line() {
    let config = load("rig.toml");
    let rigs = config.rigs();
    assert_eq!(rigs.len(), 1);
    assert_eq!(rigs[0].members, [0, 1, 2]);
    assert!(!config.world.steel.is_empty());
    let places: Vec<[f64; 3]> = config.camera.iter().map(|c| c.mounting.position_m).collect();
    let [a, b, c] = [places[0], places[1], places[2]];
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    assert!(area.abs() > 0.1, "{area}");
    let leaders = config.camera.iter().map(|camera| config.leader_of(camera).name.as_str());
    assert!(leaders.into_iter().all(|name| name == "front"));
    assert!(config.summary().contains("rig of front, left, right"));
}
