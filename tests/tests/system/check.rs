//! `lodestoned check`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use lodestone_config::model::TrajectoryKind;
use lodestone_tests::system::{Recorded, TestDomain, compressed, lodestoned, said};

fn config_directory(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../config").join(name)
}

fn check(configuration: &Path) -> Output {
    let output = lodestoned().args(["check", "--config"]).arg(configuration).output().unwrap();
    assert!(!said(&output).contains("panicked"), "{}", said(&output));
    output
}

#[test]
fn the_shipped_configurations_are_good() {
    for name in ["default.toml", "zed2-vehicle.toml"] {
        let output = check(&config_directory("shipped").join(name));
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        assert!(said(&output).contains("good") && said(&output).contains("2 cameras"));
    }
    let embedded = lodestoned().arg("check").output().unwrap();
    assert_eq!(embedded.status.code(), Some(0), "{}", said(&embedded));
    assert!(said(&embedded).contains("embedded configuration: good"), "{}", said(&embedded));
}

#[test]
fn the_shipped_replay_is_good_once_its_recording_is_there() {
    let domain = TestDomain::new();
    let configuration = domain.directory().join("replay.toml");
    fs::copy(config_directory("shipped/replay.toml"), &configuration).unwrap();
    let missing = check(&configuration);
    assert_eq!(missing.status.code(), Some(2), "{}", said(&missing));
    assert!(said(&missing).contains("recording.csv.zst"), "{}", said(&missing));

    let recording = Recorded::of(TrajectoryKind::Standing, 1, 1.0).csv();
    // Compression is told from the first bytes, but this name promises it.
    let compressed = compressed(recording.as_bytes());
    fs::write(domain.directory().join("recording.csv.zst"), compressed).unwrap();
    let good = check(&configuration);
    assert_eq!(good.status.code(), Some(0), "{}", said(&good));
}

#[test]
fn each_broken_configuration_is_refused_with_file_line_and_key() {
    let entries = fs::read_dir(config_directory("tests/broken")).unwrap();
    let files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    assert!(files.len() >= 20, "only {} broken files were found", files.len());
    for path in files {
        let output = check(&path);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        let message = String::from_utf8_lossy(&output.stderr);
        let text = fs::read_to_string(&path).unwrap();
        let expected = text.lines().filter_map(|line| line.strip_prefix("# expect: "));
        for expected in expected {
            let start = format!("{}:{expected}", path.display());
            assert!(message.contains(&start), "expected {start}\ngot {message}");
        }
    }
}

#[test]
fn explain_names_every_key() {
    let output = lodestoned().args(["check", "--explain"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let text = String::from_utf8_lossy(&output.stdout);
    let json = lodestoned().args(["check", "--explain", "--json"]).output().unwrap();
    let keys: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    let keys = keys.as_array().unwrap();
    assert_eq!(keys.len(), lodestone_config::keys().len());
    for key in keys {
        let path = key["key"].as_str().unwrap();
        let last = path.rsplit('.').next().unwrap().trim_end_matches("[]");
        assert!(text.contains(last), "{path} is not explained");
    }
}

#[test]
fn wrong_usage_ends_with_2() {
    let wrong: [&[&str]; 9] = [
        &["fly"],
        &["--unknown"],
        &["check", "--json"],
        &["check", "--config", "/nowhere/lodestone.toml"],
        &["check", "--config", "/"],
        &["run", "--duration", "0"],
        &["run", "--config", "/nowhere/lodestone.toml"],
        &["replay"],
        &["replay", "a.csv", "--out", "b", "--speed", "-1"],
    ];
    for arguments in wrong {
        let output = lodestoned().args(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", said(&output));
        assert!(!output.stderr.is_empty() && !said(&output).contains("panicked"));
    }
}
