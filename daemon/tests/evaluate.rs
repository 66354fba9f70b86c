//! `lodestoned evaluate` as a process: what it prints, what it writes, what it refuses.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod common;

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Command, Output, Stdio};

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

/// Every element closes, nothing is loaded from anywhere, and no figure is missing.
fn is_one_sound_page(html: &str) {
    for outside in ["http:", "https:", "src=", "@import", "url(", "<script", "<link"] {
        assert!(!html.contains(outside), "{outside}");
    }
    let elements = ["section", "figure", "svg", "table", "tr", "td", "dl", "p", "div", "text"];
    for element in elements.into_iter().chain(["h2", "h3", "h4", "span", "small", "ul", "nav"]) {
        let opened = html.matches(&format!("<{element}>")).count()
            + html.matches(&format!("<{element} ")).count();
        assert_eq!(opened, html.matches(&format!("</{element}>")).count(), "{element}");
    }
    for link in html.split("href=\"#").skip(1).filter_map(|rest| rest.split('"').next()) {
        assert!(html.contains(&format!("id=\"{link}\"")), "a link leads nowhere: {link}");
    }
    assert!(!html.contains("NaN"), "a figure is no number");
    assert!(!html.contains("inf "), "a figure is no number");
    assert!(html.len() < 2_000_000, "{} bytes", html.len());
}

#[test]
fn the_numbers_say_what_calibration_did() {
    let (place, output) = evaluated(CELLAR, &["--json"]);
    assert!(output.status.success(), "{}", said(&output));
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    let written: Value = serde_json::from_str(&file(&place, "report.json")).unwrap();
    assert_eq!(printed, written);
    assert_eq!(written["dynamic"], Value::Null, "only the static part was asked for");
    let cellar = &written["static"]["places"][0];
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
    let curve = written["static"]["rest"]["gyroscope"]["allan"][2].as_array().unwrap();
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
    is_one_sound_page(&html);
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
    let cellar = &report["static"]["places"][0];
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
        &["evaluate", "static", "--runs", "3"],
        &["evaluate", "dynamic", "--runs", "0"],
        &["evaluate", "dynamic", "--rest", "20"],
        &["evaluate", "dynamic", "--scenario", "none.toml"],
        &["evaluate", "dynamic", "--config", "none.toml"],
        &["evaluate", "--seed", "1", "dynamic"],
        &["evaluate", "kinematic"],
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

/// Evaluates the dynamic part.
fn dynamic(more: &[&str]) -> (TempDir, Output) {
    let place = tempfile::tempdir().unwrap();
    let mut arguments = vec!["evaluate", "dynamic", "--out", "out"];
    arguments.extend(more);
    let output = lodestoned(place.path(), &arguments);
    assert!(output.status.success(), "{}", said(&output));
    (place, output)
}

#[test]
fn a_recording_is_scored_against_its_truth_and_one_without_is_refused() {
    let place = tempfile::tempdir().unwrap();
    let rows = |truth: &str| -> String {
        let row = |k: u32| format!("{},0,0,0,0,0,9.81,0,21,-43{truth}\n", f64::from(k) * 0.0025);
        (0..4000).map(row).collect()
    };
    let header = "t,gx,gy,gz,ax,ay,az,mx,my,mz";
    let write = |name: &str, text: String| std::fs::write(place.path().join(name), text).unwrap();
    // It looks east all the time, and the truth says that it looks five degrees further left.
    let (half_sine, half_cosine) = 2.5_f64.to_radians().sin_cos();
    let truth = format!(",{half_cosine},0,0,{half_sine}");
    write("told.csv", format!("{header},qw,qx,qy,qz\n{}", rows(&truth)));
    write("untold.csv", format!("{header}\n{}", rows("")));
    let evaluate = |recording: &str| {
        let line = ["evaluate", "dynamic", "--runs", "1", "--json", "--recording", recording];
        lodestoned(place.path(), &line)
    };
    let output = evaluate("told.csv");
    assert!(output.status.success(), "{}", said(&output));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let score = &report["dynamic"]["recordings"][0]["orientation"];
    assert!((score["heading_deg"].as_f64().unwrap() - 5.0).abs() < 0.1, "{score}");
    assert!(score["inclination_deg"].as_f64().unwrap() < 0.1, "{score}");
    let output = evaluate("untold.csv");
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(
        said(&output).contains("untold.csv") && said(&output).contains("qw"),
        "{}",
        said(&output)
    );
}

/// The median position error of a method in a scene at one time of the table, m.
fn drift_m(report: &Value, scene: &str, method: &str, time_s: f64) -> f64 {
    let methods = report["dynamic"][scene]["methods"].as_array().unwrap();
    let found = methods.iter().find(|m| m["method"] == method).unwrap();
    let table = found["table"].as_array().unwrap();
    let point = table.iter().find(|p| p["time_s"] == time_s).unwrap();
    point["error_m"]["median"].as_f64().unwrap()
}

/// The paper: "the double integrated acceleration leads to major position deviations. Adjusting the offset
/// reduces the deviation error but does not eliminate it. By implementing a Kalman and low-pass filter, we
/// are able to improve …".
#[test]
fn given_any_seed_the_papers_sentence_holds_in_numbers() {
    for seed in ["3", "4"] {
        let (place, output) = dynamic(&["--seed", seed, "--runs", "3", "--json"]);
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(report, serde_json::from_str::<Value>(&file(&place, "report.json")).unwrap());
        for scene in ["at_rest", "in_motion"] {
            let after_a_minute = |method| drift_m(&report, scene, method, 60.0);
            let (raw, corrected) = (after_a_minute("raw"), after_a_minute("offset_corrected"));
            let (alone, ours) = (after_a_minute("lodestone_unaided"), after_a_minute("lodestone"));
            assert!(raw > 50.0, "{scene}, seed {seed}: major deviations, not {raw} m");
            assert!(corrected < 0.7 * raw, "{scene}, seed {seed}: {corrected} m of {raw} m");
            assert!(corrected > 1.0, "{scene}, seed {seed}: not eliminated, {corrected} m");
            assert!(alone < corrected, "{scene}, seed {seed}: {alone} m of {corrected} m");
            assert!(ours < 0.3 * corrected, "{scene}, seed {seed}: {ours} m of {corrected} m");
            // What a low-pass takes away, two integrations would have taken away as well.
            let low_passed = after_a_minute("low_passed");
            assert!((low_passed / corrected - 1.0).abs() < 0.2, "{low_passed} m, {corrected} m");
            assert!(drift_m(&report, scene, "raw", 10.0) < raw, "drift grows");
        }
        stands_on_the_stairs(&report["dynamic"]);
    }
}

/// The walk on stairs: positions get better from step to step, and the swing of the stride is there.
fn stands_on_the_stairs(dynamic: &Value) {
    let score = |scene: &str, method: &str| {
        let methods = dynamic[scene]["methods"].as_array().unwrap();
        methods.iter().find(|m| m["method"] == method).unwrap().clone()
    };
    let rms = |scene, method| score(scene, method)["rms_m"]["median"].as_f64().unwrap();
    let corrected = rms("stairs", "offset_corrected");
    assert!(corrected < rms("stairs", "raw"));
    assert!(rms("stairs", "lodestone") < 0.5 * corrected);
    assert!(rms("stairs_halting", "lodestone") < 0.5 * corrected);
    for (axis, most_deg) in [(0, 1.0), (1, 1.0), (2, 3.0)] {
        let error = score("stairs", "lodestone")["orientation_rms_deg"][axis]["median"].clone();
        assert!(error.as_f64().unwrap() < most_deg, "axis {axis}: {error}°");
    }
    let explained = |of: &Value| of[0]["median"].as_f64().unwrap();
    let truth = explained(&dynamic["stairs"]["true_explained"]);
    let ours = explained(&score("stairs", "lodestone")["explained"]);
    assert!(truth > 0.98 && (ours - truth).abs() < 0.02, "{ours} of {truth}");
}

#[test]
fn the_dynamic_report_is_one_page_with_the_papers_figures_and_repeats_to_the_byte() {
    let page = |seed: &str| file(&dynamic(&["--seed", seed, "--runs", "1"]).0, "report.html");
    let html = page("7");
    is_one_sound_page(&html);
    for part in ["Sensory Ground Truth", "Trajectory Representation of Climb Stairs"] {
        assert!(html.contains(part), "{part}");
    }
    for id in ["noise", "drift", "stairs", "harmonic", "method"] {
        assert!(html.contains(&format!("<section id=\"{id}\">")), "{id}");
    }
    assert!(!html.contains("id=\"stability\""), "the static part was not asked for");
    assert!(html == page("7"), "not repeatable");
    assert!(html != page("8"), "the seed changes nothing");
}

#[test]
fn without_a_part_both_are_evaluated_on_one_page() {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("scenario.toml"), CELLAR).unwrap();
    let line = ["evaluate", "--scenario", "scenario.toml", "--rest", "20", "--runs", "1"];
    let output = lodestoned(place.path(), &line);
    assert!(output.status.success(), "{}", said(&output));
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    assert!(text.contains("cellar") && text.contains("offset-corrected"), "{text}");
    let written =
        |name: &str| std::fs::read_to_string(place.path().join("evaluation").join(name)).unwrap();
    let html = written("report.html");
    is_one_sound_page(&html);
    let order: Vec<usize> = ["calibration", "stability", "noise", "drift", "stairs", "method"]
        .map(|id| html.find(&format!("<section id=\"{id}\">")).unwrap())
        .to_vec();
    assert!(order.is_sorted(), "not in the paper's order: {order:?}");
    let report: Value = serde_json::from_str(&written("report.json")).unwrap();
    assert_eq!(report["static"]["places"][0]["name"], "cellar");
    assert_eq!(report["dynamic"]["runs"], 1);
}

#[test]
fn an_interrupted_evaluation_stops_and_writes_nothing() {
    let place = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_lodestoned"));
    command.args(["evaluate", "dynamic", "--runs", "1000", "--out", "out"]);
    command.current_dir(place.path()).stderr(Stdio::piped()).stdout(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let mut errors = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    errors.read_line(&mut line).unwrap();
    assert!(line.contains("of 1000"), "progress is told: {line}");
    let pid = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(1));
    errors.read_to_string(&mut line).unwrap();
    assert!(line.contains("interrupted"), "{line}");
    assert!(!place.path().join("out/report.html").exists());
}
