//! Files as they are found on disk.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use lodestone_config::{Calibration, Config, LoadError, MAX_FILE_BYTES};
use tempfile::TempDir;

const CALIBRATION: &str = "serial = 23456789\ndate = 2026-05-04\n\
                           [gyro]\nbias_rad_s = [0.001, -0.002, 0.0005]\n";

fn file_with(directory: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = directory.path().join(name);
    fs::write(&path, bytes).expect("written");
    path
}

fn scratch() -> TempDir {
    TempDir::new().expect("a directory")
}

#[test]
fn a_missing_file_is_named() {
    let path = scratch().path().join("none.toml");
    let error = Config::load(&path).expect_err("missing");
    assert!(matches!(&error, LoadError::NotFound { path: named } if *named == path));
    assert!(error.to_string().starts_with(&format!("{}: no such file", path.display())));
}

#[test]
fn a_directory_is_no_configuration() {
    let directory = scratch();
    let error = Config::load(directory.path()).expect_err("a directory");
    assert!(matches!(error, LoadError::Unreadable { .. }), "{error}");
}

#[test]
fn a_file_that_may_not_be_read_says_why() {
    let directory = scratch();
    let path = file_with(&directory, "secret.toml", b"");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o000)).expect("changed");
    match fs::read(&path) {
        Ok(_) => eprintln!("skipped: this user may read everything"),
        Err(_) => assert!(matches!(Config::load(&path), Err(LoadError::Unreadable { .. }))),
    }
}

#[test]
fn an_endless_file_is_too_large_and_not_waited_for() {
    let error = Config::load("/dev/zero").expect_err("endless");
    assert!(matches!(error, LoadError::TooLarge { limit: MAX_FILE_BYTES, .. }), "{error}");
}

#[test]
fn the_largest_file_is_read_and_one_byte_more_is_not() {
    let directory = scratch();
    let mut text = Vec::from("[[camera]]\nname = \"front\"\ndriver = \"synthetic\"\n#");
    text.resize(usize::try_from(MAX_FILE_BYTES).expect("fits"), b'x');
    assert!(Config::load(file_with(&directory, "large.toml", &text)).is_ok());
    text.push(b'x');
    let error = Config::load(file_with(&directory, "larger.toml", &text)).expect_err("too large");
    assert!(matches!(error, LoadError::TooLarge { .. }), "{error}");
}

#[test]
fn bytes_that_are_not_text_are_named_with_their_line() {
    let directory = scratch();
    let path = file_with(&directory, "binary.toml", b"[world]\n# M\xfcnchen\n");
    let error = Config::load(&path).expect_err("not UTF-8");
    assert!(matches!(error, LoadError::NotUtf8 { line: 2, offset: 11, .. }), "{error}");
}

#[test]
fn files_are_found_beside_the_configuration_that_names_them() {
    let directory = scratch();
    let text = "[[camera]]\nname = \"front\"\nserial = 23456789\ncalibration = \"front.toml\"\n";
    let path = file_with(&directory, "rig.toml", text.as_bytes());
    file_with(&directory, "front.toml", CALIBRATION.as_bytes());
    let loaded = Config::load(&path).expect("valid");
    let camera = &loaded.config.camera[0];
    let calibration = loaded.calibration(camera).expect("valid").expect("named");
    assert_eq!(calibration.serial, camera.serial);
    assert_eq!(loaded.resolve("/data/a.csv"), Path::new("/data/a.csv"));
    assert_eq!(loaded.recording(camera), None);
}

#[test]
fn what_is_wrong_with_any_calibration_is_said_at_once() {
    let directory = scratch();
    let camera = |name: &str, serial: u32| {
        format!("[[camera]]\nname = \"{name}\"\nserial = {serial}\ncalibration = \"{name}.toml\"\n")
    };
    let text = camera("front", 23_456_789) + &camera("left", 1) + &camera("right", 2);
    let path = file_with(&directory, "rig.toml", text.as_bytes());
    file_with(&directory, "front.toml", CALIBRATION.as_bytes());
    file_with(&directory, "left.toml", CALIBRATION.as_bytes());
    let errors = Config::load(&path).expect("valid").calibrations().expect_err("two are wrong");
    assert!(
        matches!(
            errors[..],
            [LoadError::OtherCamera { expected: 1, .. }, LoadError::NotFound { .. }]
        ),
        "{errors:?}"
    );
}

#[test]
fn the_calibration_of_another_camera_is_refused_by_both_serials() {
    let directory = scratch();
    let path = file_with(&directory, "front.toml", CALIBRATION.as_bytes());
    let error = Calibration::load(&path, 11_111_111).expect_err("another camera's");
    let (found, expected) = (23_456_789, 11_111_111);
    assert!(
        matches!(error, LoadError::OtherCamera { found: f, expected: e, .. } if (f, e) == (found, expected))
    );
    let message = error.to_string();
    assert!(message.contains("23456789") && message.contains("11111111"), "{message}");
    assert!(message.starts_with(&path.display().to_string()), "{message}");
}
