//! The key table and the types say the same.

use std::collections::{BTreeMap, BTreeSet};

use lodestone_config::model::{
    AxisMap, Camera, CameraModel, Config, Cylinder, Depth, Disturbance, DriverKind, Estimator,
    Fault, FaultKind, HeadingMode, Instrument, Lane, MagneticDistortion, Motor, Mounting,
    MoverShape, North, Pattern, Policy, Preset, Realtime, Replay, RigidBody, Scene, SceneBox,
    SceneMover, SensorErrors, SharedMemory, Start, Steel, Synthetic, Threads, TrajectoryKind,
    Transport, ValidityBounds, World,
};
use lodestone_config::{KeyInfo, explain, keys};
use serde::de::DeserializeOwned;
use toml::{Table, Value};

/// A camera with every optional part; no `..`, so that a new field must be added here.
fn full_camera() -> Camera {
    Camera {
        name: "front".into(),
        serial: 7,
        driver: DriverKind::Synthetic,
        model: CameraModel::Zed2i,
        body: Some("car".into()),
        mounting: Mounting::default(),
        cpu: Some(1),
        start: Some(Start { position_m: [1.0, 2.0, 0.0], sigma_m: 0.1 }),
        magnetometer_position_m: [0.0; 3],
        lens_position_m: Some([0.0; 3]),
        low_pass_hz: Some(80.0),
        axis_map: Some(AxisMap::default()),
        noise: Some(CameraModel::Zed2i.noise()),
        imu_delay_s: 0.004,
        calibration: Some("front.toml".into()),
        synthetic: Some(full_synthetic()),
        depth: Some(Depth::default()),
        replay: Some(Replay { file: "walk.csv".into(), speed: 1.0, repeat: false }),
        fault: vec![Fault { kind: FaultKind::Drop, at_s: 1.0, duration_s: 2.0 }],
    }
}

/// Two of these make the body a rig, which alone has a thread to pin, whatever the first camera is.
fn companion(name: &str) -> Camera {
    let first = full_camera();
    Camera {
        name: name.into(),
        driver: DriverKind::Replay,
        body: first.body,
        replay: first.replay,
        fault: first.fault,
        ..Camera::default()
    }
}

fn full_synthetic() -> Synthetic {
    Synthetic {
        trajectory: TrajectoryKind::Standing,
        rest_s: 1.0,
        tilt_deg: 5.0,
        arm_m: 0.3,
        position_m: Some([1.0, 2.0, 0.0]),
        heading_deg: Some(0.0),
        pitch_deg: Some(0.0),
        roll_deg: Some(0.0),
        halt_s: 2.0,
        seed: 1,
        speed: 1.0,
        duration_s: 10.0,
        errors: SensorErrors {
            gyro_bias_rad_s: Some([0.0; 3]),
            accel_bias_m_s2: Some([0.0; 3]),
            ..SensorErrors::default()
        },
        distortion: MagneticDistortion::default(),
        disturbance: vec![Disturbance {
            at_s: 1.0,
            duration_s: 1.0,
            field_ut: [1.0, 2.0, 3.0],
            frequency_hz: 0.0,
        }],
        motor: vec![Motor { field_ut: [1.0, 2.0, 3.0], idle_hz: 13.3, hz_per_m_s: 0.0 }],
        instrument: vec![Instrument { field_ut: [1.0, 2.0, 3.0], on_s: 1.0, off_s: 0.0 }],
        transport: Transport::default(),
    }
}

/// A scene with everything in it.
fn full_scene() -> Scene {
    let (boxes, cylinder) = (SceneBox::default(), Cylinder::default());
    Scene {
        boxes: vec![SceneBox { size_m: [1.0, 0.5, 0.5], ..boxes }],
        cylinder: vec![Cylinder { radius_m: 0.2, height_m: 1.0, ..cylinder }],
        mover: Some(SceneMover::default()),
        ..Scene::default()
    }
}

fn full_config() -> Config {
    Config {
        world: World {
            year: Some(2026.0),
            keep: Some("world.toml".into()),
            steel: vec![Steel { position_m: [1.0; 3], moment_a_m2: [1.0; 3] }],
            ..World::default()
        },
        shared_memory: SharedMemory::default(),
        lane: Lane { step_rate_hz: Some(400.0), ..Lane::default() },
        realtime: Realtime::default(),
        scene: Some(full_scene()),
        estimator: Estimator { validity: ValidityBounds::default(), ..Estimator::default() },
        body: vec![RigidBody {
            name: "car".into(),
            vehicle: true,
            antenna_m: Some([0.0; 3]),
            gradient: true,
            cpu: Some(0),
        }],
        camera: vec![full_camera(), companion("left"), companion("right")],
    }
}

/// A configuration that is valid and names every key but those of `replay`.
fn valid_table() -> Table {
    let mut config = full_config();
    config.camera[0].replay = None;
    Table::try_from(config).expect("serialises")
}

/// A configuration that is valid and has the keys of `replay`.
fn replay_table() -> Table {
    let mut config = full_config();
    config.camera[0].synthetic = None;
    config.camera[0].depth = None;
    config.camera[0].driver = DriverKind::Replay;
    Table::try_from(config).expect("serialises")
}

/// Dotted paths of all values; lists of tables count as tables.
fn paths(prefix: &str, value: &Value, into: &mut BTreeSet<String>) {
    let join = |name: &str| match prefix {
        "" => name.to_string(),
        _ => format!("{prefix}.{name}"),
    };
    match value {
        Value::Table(table) => {
            for (name, value) in table {
                paths(&join(name), value, into);
            }
        }
        Value::Array(list) if list.iter().any(Value::is_table) => {
            for element in list {
                paths(prefix, element, into);
            }
        }
        _ => {
            into.insert(prefix.into());
        }
    }
}

/// The table that holds a key: down the path, into the first element of lists.
fn table_of<'t>(root: &'t mut Table, path: &str) -> (&'t mut Table, String) {
    let (parents, name) = path.rsplit_once('.').unwrap_or(("", path));
    let mut table = root;
    for part in parents.split('.').filter(|part| !part.is_empty()) {
        table = match table.get_mut(part).expect("a table on the way") {
            Value::Table(inner) => inner,
            Value::Array(list) => list[0].as_table_mut().expect("a list of tables"),
            other => panic!("{part} is {other:?}"),
        };
    }
    (table, name.into())
}

/// A valid configuration in which the key stands.
fn valid_with(key: &KeyInfo) -> Table {
    if key.key.starts_with("camera.replay") { replay_table() } else { valid_table() }
}

fn check(table: &Table) -> Result<Config, String> {
    let text = toml::to_string(table).expect("serialises");
    Config::from_toml("test.toml", &text).map_err(|errors| errors.to_string())
}

#[test]
fn table_and_types_name_the_same_keys() {
    let mut of_types = BTreeSet::new();
    paths("", &Value::try_from(full_config()).expect("serialises"), &mut of_types);
    let of_table: BTreeSet<String> = keys().into_iter().map(|key| key.key).collect();
    assert_eq!(of_table, of_types);
    assert_eq!(keys().len(), of_table.len(), "a key stands in the table twice");
}

#[test]
fn every_key_is_accepted_and_comes_back_with_its_value() {
    for table in [valid_table(), replay_table()] {
        let config = check(&table).expect("valid");
        assert_eq!(Table::try_from(&config).expect("serialises"), table);
    }
}

#[test]
fn required_keys_and_only_those_cannot_be_left_out() {
    // The rules between keys want these; the table alone does not.
    let by_rule = ["camera.serial", "camera.driver", "camera.synthetic.trajectory"];
    for key in keys().into_iter().filter(|key| !by_rule.contains(&key.key.as_str())) {
        let mut table = valid_with(&key);
        let (parent, name) = table_of(&mut table, &key.key);
        parent.remove(&name).expect("the key was there");
        let expected = format!(" {}: is missing; allowed: ", key.key);
        match check(&table) {
            Ok(_) => assert!(!key.required, "{} was not missed", key.key),
            Err(message) => assert!(key.required && message.contains(&expected), "{message}"),
        }
    }
}

#[test]
fn a_value_of_the_wrong_type_is_refused_at_every_key() {
    let odd = [
        Value::Boolean(true),
        Value::Integer(-99_999_999),
        Value::Float(f64::NAN),
        Value::Float(f64::INFINITY),
        Value::String("\0".into()),
        Value::Array(vec![]),
        Value::Table(Table::new()),
    ];
    for key in keys() {
        for value in
            odd.iter().filter(|value| !(value.is_bool() && key.allowed.contains("true or")))
        {
            let mut table = valid_with(&key);
            let (parent, name) = table_of(&mut table, &key.key);
            parent.insert(name, value.clone());
            let message = check(&table).expect_err(&key.key);
            assert!(message.contains(&format!(": {}: ", key.key)), "{value}: {message}");
            assert!(message.contains(&format!("; allowed: {}", key.allowed)), "{message}");
        }
    }
}

/// The words that serde knows, out of its own message.
fn words_of<T: DeserializeOwned>() -> BTreeSet<String> {
    let error = Value::String("?".into()).try_into::<T>().err().expect("refused").to_string();
    error.split('`').skip(1).step_by(2).filter(|word| *word != "?").map(String::from).collect()
}

#[test]
fn choices_are_the_words_of_the_enums() {
    let choices: BTreeMap<&str, BTreeSet<String>> = [
        ("world.north", words_of::<North>()),
        ("lane.threads", words_of::<Threads>()),
        ("realtime.policy", words_of::<Policy>()),
        ("estimator.preset", words_of::<Preset>()),
        ("estimator.heading", words_of::<HeadingMode>()),
        ("estimator.preset", words_of::<Preset>()),
        ("camera.driver", words_of::<DriverKind>()),
        ("camera.model", words_of::<CameraModel>()),
        ("camera.synthetic.trajectory", words_of::<TrajectoryKind>()),
        ("camera.fault.kind", words_of::<FaultKind>()),
        ("scene.room.wall_pattern", words_of::<Pattern>()),
        ("scene.room.floor_pattern", words_of::<Pattern>()),
        ("scene.box.pattern", words_of::<Pattern>()),
        ("scene.cylinder.pattern", words_of::<Pattern>()),
        ("scene.mover.pattern", words_of::<Pattern>()),
        ("scene.mover.shape", words_of::<MoverShape>()),
    ]
    .into();
    for key in keys().into_iter().filter(|key| key.allowed.starts_with('"')) {
        let words = &choices[key.key.as_str()];
        let listed: BTreeSet<String> =
            key.allowed.split('"').skip(1).step_by(2).map(String::from).collect();
        assert_eq!(listed, *words, "{}", key.key);
        assert!(words.len() > 1);
    }
}

#[test]
fn defaults_are_shown_where_a_file_could_say_them() {
    let without: BTreeSet<String> = keys()
        .into_iter()
        .filter(|key| key.default.is_none() && !key.required)
        .map(|key| key.key)
        .collect();
    let expected = [
        "body.antenna_m",
        "body.cpu",
        "camera.body",
        "camera.calibration",
        "camera.cpu",
        "camera.lens_position_m",
        "camera.low_pass_hz",
        "camera.serial",
        "camera.synthetic.heading_deg",
        "camera.synthetic.pitch_deg",
        "camera.synthetic.position_m",
        "camera.synthetic.roll_deg",
        "camera.synthetic.errors.accel_bias_m_s2",
        "camera.synthetic.errors.gyro_bias_rad_s",
        "lane.step_rate_hz",
        "world.keep",
        "world.year",
    ];
    assert_eq!(without, expected.map(String::from).into());
    let shown = |path: &str| keys().into_iter().find(|key| key.key == path)?.default;
    assert_eq!(shown("camera.name"), None);
    assert_eq!(shown("camera.noise.mag_sigma_ut").as_deref(), Some("0.5"));
    assert_eq!(shown("camera.synthetic.disturbance.frequency_hz").as_deref(), Some("0.0"));
    assert_eq!(shown("camera.synthetic.speed").as_deref(), Some("1.0"));
    assert_eq!(shown("shared_memory.root").as_deref(), Some("\"/dev/shm/lodestone/\""));
}

#[test]
fn every_default_may_be_written_in_a_file() {
    for key in keys() {
        let Some(default) = &key.default else { continue };
        let mut table = valid_with(&key);
        let (parent, name) = table_of(&mut table, &key.key);
        let value = toml::from_str::<Table>(&format!("v = {default}")).expect("TOML")["v"].clone();
        parent.insert(name, value);
        match check(&table) {
            Ok(_) => {}
            // The default driver cannot go with the sections of the others, nor a walk with a given tilt.
            Err(message) => {
                let by_rule = ["camera.driver", "camera.synthetic.trajectory"];
                assert!(by_rule.contains(&key.key.as_str()), "{message}");
            }
        }
    }
}

#[test]
fn the_explanation_has_every_key_and_fits_on_a_screen() {
    let text = explain();
    for key in keys() {
        let name = key.key.rsplit('.').next().expect("a name");
        let line = text.lines().find(|line| line.split_whitespace().next() == Some(name));
        let line = line.unwrap_or_else(|| panic!("{name} is not explained"));
        assert!(line.contains(key.unit), "{line}");
        assert!(!key.meaning.is_empty());
        let words: Vec<&str> = key.meaning.split_whitespace().collect();
        let flat = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(flat.contains(&words.join(" ")), "{name}");
    }
    assert!(text.lines().all(|line| line.chars().count() <= 96), "{text}");
}
