//! The file that keeps the world: what is written is read back, what is damaged is refused.

use lodestone_config::model::North;
use lodestone_config::{KEPT_WORLD_FORMAT, KeptCamera, KeptSource, KeptWorld};

fn kept() -> KeptWorld {
    KeptWorld {
        format: KEPT_WORLD_FORMAT,
        epoch: 3,
        t0_unix_ns: 1_780_000_000_123_456_789,
        north: North::Magnetic,
        first_camera: "front".into(),
        starts_hold: true,
        rotation_rad: [0.01, -0.02, 1.5],
        heading_sigma_rad: 0.04,
        tilt_sigma_rad: 0.005,
        field_ut: Some([0.0, 21.0, -43.0]),
        magnetometer_position_m: [0.0, 0.01, 0.0],
        camera: vec![KeptCamera {
            name: "front".into(),
            position_m: [1.0, 2.0, 0.1],
            sigma_m: [0.1, 0.1, 0.2],
            source: KeptSource::CommonStart,
        }],
    }
}

#[test]
fn what_is_written_is_read_back_to_the_bit() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("world.toml");
    assert_eq!(KeptWorld::load(&path, North::Magnetic).unwrap(), None, "no file, no world");
    std::fs::write(&path, kept().to_toml().unwrap()).unwrap();
    assert_eq!(KeptWorld::load(&path, North::Magnetic).unwrap(), Some(kept()));
}

#[test]
fn a_damaged_or_foreign_file_is_refused_with_its_line() {
    let good = kept().to_toml().unwrap();
    let broken = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        let errors = KeptWorld::from_toml("world.toml", &good.replace(from, to)).unwrap_err();
        errors.to_string()
    };
    assert!(broken("epoch = 3", "epoch = 0").starts_with("world.toml:3: epoch: 0 is out of range"));
    assert!(broken("format = 1", "format = 2").starts_with("world.toml:2: format: "));
    assert!(broken("1.5]", "nan]").contains("world.toml:8: rotation_rad: "));
    assert!(broken("starts_hold = true\n", "").contains("starts_hold: is missing"));
    assert!(broken("epoch", "epohc").contains("did you mean epoch?"));
    // Cut off in the middle, as by a power cut without the rename.
    for length in 0..good.len() - 1 {
        if let (Ok(cut), true) =
            (KeptWorld::from_toml("world.toml", &good[..length]), length < good.len() - 60)
        {
            assert!(cut.camera.is_empty(), "{length} bytes make {cut:?}");
        }
    }
}

#[test]
fn a_world_of_another_north_is_refused() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("world.toml");
    std::fs::write(&path, kept().to_toml().unwrap()).unwrap();
    let message = KeptWorld::load(&path, North::True).unwrap_err().to_string();
    assert!(message.contains("magnetic north") && message.contains("world.toml"), "{message}");
}
