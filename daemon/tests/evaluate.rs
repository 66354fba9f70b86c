//! `lodestoned evaluate` as a process: what it prints, what it writes, what it refuses.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod common;

use std::path::Path;
use std::process::{Command, Output};

use common::said;
use serde_json::Value;
use tempfile::TempDir;

/// A camera that is turned in the hand for half a minute, beside a little iron.
const CELLAR: &str = r#"
[world]
year = 2026.5

[[camera]]
name = "cellar"
driver = "synthetic"

[camera.synthetic]
trajectory = "tumble"
rest_s = 1.0
duration_s = 40.0

[camera.synthetic.distortion]
hard_iron_ut = [5.0, -4.0, 3.0]
"#;

fn lodestoned(directory: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lodestoned"));
    command.args(arguments).current_dir(directory).env_remove("RUST_LOG").output().unwrap()
}

/// Evaluates one scenario, with what else is asked for.
fn evaluated(scenario: &str, more: &[&str]) -> (TempDir, Output) {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("scenario.toml"), scenario).unwrap();
    let mut arguments =
        vec!["evaluate", "static", "--scenario", "scenario.toml", "--rest", "20", "--out", "out"];
    arguments.extend(more);
    let output = lodestoned(place.path(), &arguments);
    (place, output)
}

fn file(place: &TempDir, name: &str) -> String {
    std::fs::read_to_string(place.path().join("out").join(name)).unwrap()
}

fn mean(value: &Value) -> f64 {
    value["mean"].as_f64().unwrap()
}

#[test]
fn the_numbers_say_what_calibration_did() {
    let (place, output) = evaluated(CELLAR, &["--json"]);
    assert!(output.status.success(), "{}", said(&output));
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    let written: Value = serde_json::from_str(&file(&place, "report.json")).unwrap();
    assert_eq!(printed, written);
    let cellar = &written["places"][0];
    assert_eq!(cellar["name"], "cellar");
    assert_eq!(cellar["paper"], Value::Null);
    let (before, after) = (&cellar["uncalibrated"], &cellar["calibrated"]);
    let (nc, c) = (mean(&before["sigma_ut"]), mean(&after["sigma_ut"]));
    // Hard iron of 7 µT over the whole sphere is 7/√3; what is left is the noise of a reading.
    assert!((3.0..5.5).contains(&nc), "{nc}");
    assert!((0.4..0.65).contains(&c), "{c}");
    let epsilon = mean(&cellar["epsilon_percent"]);
    assert!((epsilon - 100.0 * (1.0 - c / nc)).abs() < 1.0, "{epsilon}");
    assert!(mean(&after["lasting_heading_rms_deg"]) < 0.5);
    assert!(mean(&before["lasting_heading_rms_deg"]) > 5.0);
    let curve = written["rest"]["gyroscope"]["allan"][2].as_array().unwrap();
    assert!(curve.len() > 20 && curve.iter().all(|p| p["deviation"].as_f64().unwrap() > 0.0));
}

#[test]
fn the_report_is_one_page_that_needs_nothing_else() {
    let (place, output) = evaluated(CELLAR, &[]);
    assert!(output.status.success(), "{}", said(&output));
    let table = String::from_utf8(output.stdout.clone()).unwrap();
    assert!(table.lines().any(|line| line.starts_with("cellar")), "{table}");
    let html = file(&place, "report.html");
    assert!(html.contains("id=\"place-cellar\"") && html.contains("prefers-color-scheme: dark"));
    for outside in ["http:", "https:", "src=", "@import", "url(", "<script", "<link"] {
        assert!(!html.contains(outside), "{outside}");
    }
    for element in ["section", "figure", "svg", "table", "tr", "td", "dl", "p", "div", "text"] {
        let opened = html.matches(&format!("<{element}>")).count()
            + html.matches(&format!("<{element} ")).count();
        assert_eq!(opened, html.matches(&format!("</{element}>")).count(), "{element}");
    }
    assert!(!html.contains("NaN"), "a figure is no number");
    assert!(html.len() < 2_000_000, "{} bytes", html.len());
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_does_not() {
    let report = |seed: &str| file(&evaluated(CELLAR, &["--seed", seed]).0, "report.html");
    let first = report("7");
    assert!(first == report("7"), "not repeatable");
    assert!(first != report("8"), "the seed changes nothing");
}

/// A camera that stands shows nothing to calibrate from: that is a result, not a failure.
#[test]
fn a_refused_calibration_is_a_row_that_says_so() {
    let standing = CELLAR.replace("\"tumble\"", "\"standing\"");
    let (place, output) = evaluated(&standing, &[]);
    assert!(output.status.success(), "{}", said(&output));
    assert!(said(&output).contains("refused"), "{}", said(&output));
    let report: Value = serde_json::from_str(&file(&place, "report.json")).unwrap();
    let cellar = &report["places"][0];
    assert_eq!((&cellar["calibrated"], &cellar["epsilon_percent"]), (&Value::Null, &Value::Null));
    let why = cellar["calibration"]["refused"].as_str().unwrap();
    assert!(why.contains("turn"), "{why}");
    assert!(file(&place, "report.html").contains("Calibration refused"));
}

#[test]
fn a_scenario_that_cannot_be_used_is_a_wrong_configuration() {
    let endless = CELLAR.replace("duration_s = 40.0", "duration_s = 0.0");
    let short = CELLAR.replace("duration_s = 40.0", "duration_s = 0.01");
    let unknown = CELLAR.replace("rest_s", "rests_s");
    let before_the_model = CELLAR.replace("2026.5", "1980.0");
    let real = "[[camera]]\nname = \"cellar\"\nserial = 7\n".to_owned();
    let expected = [
        (endless, "duration_s"),
        (short, "duration_s"),
        (unknown, "rests_s"),
        (before_the_model, "year"),
        (real, "synthetic"),
    ];
    for (scenario, named) in expected {
        let (place, output) = evaluated(&scenario, &[]);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(said(&output).contains(named), "{named}: {}", said(&output));
        assert!(said(&output).contains("scenario.toml"), "{}", said(&output));
        assert!(!place.path().join("out/report.html").exists());
    }
}

#[test]
fn what_the_command_line_gets_wrong_is_wrong_usage() {
    let place = tempfile::tempdir().unwrap();
    let lines = [
        &["evaluate", "static", "--scenario", "none.toml"][..],
        &["evaluate", "static", "--config", "none.toml"],
        &["evaluate", "static", "--rest", "0"],
        &["evaluate"],
    ];
    for line in lines {
        let output = lodestoned(place.path(), line);
        assert_eq!(output.status.code(), Some(2), "{line:?}: {}", said(&output));
    }
}

#[test]
fn a_directory_that_cannot_be_made_is_named() {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("taken"), "").unwrap();
    let output = lodestoned(place.path(), &["evaluate", "static", "--out", "taken/out"]);
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(said(&output).contains("taken/out"), "{}", said(&output));
}
