//! Calibration files.

use lodestone_config::{Calibration, calibration_keys, explain_calibration};

const WHOLE: &str = r#"
serial = 23456789
date = 2026-05-04
mounting = "front mast, engine running"

[temperature]
min_c = 22.0
max_c = 41.5

[magnetometer]
hard_iron_ut = [12.5, -3.0, 40.25]
hard_iron_slope_ut_k = [0.05, 0.0, -0.02]
reference_temperature_c = 30.0
soft_iron = [[1.02, 0.01, 0.0], [0.01, 0.97, 0.02], [0.0, 0.02, 1.01]]
heading_sigma_deg = 0.8
level_heading_sigma_deg = 0.9
residual_ut = 0.4
field_ut = 48.5
field_sigma_ut = 0.7
dip_deg = 66.5
dip_sigma_deg = 0.1
covariance = [
  [0.0004, 0.0001, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
  [0.0001, 0.0004, 0.0001, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
  [0.0, 0.0001, 0.0004, 0.0001, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
  [0.0, 0.0, 0.0001, 0.0004, 0.0001, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
  [0.0, 0.0, 0.0, 0.0001, 0.0004, 0.0001, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
  [0.0, 0.0, 0.0, 0.0, 0.0001, 0.0004, 0.0001, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
  [0.0, 0.0, 0.0, 0.0, 0.0, 0.0001, 0.0004, 0.0001, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
  [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0001, 0.0004, 0.0001, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
  [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0001, 0.0004, 0.0001, 0.0, 0.0, 0.0, 0.0, 0.0],
  [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0001, 0.0004, 0.0001, 0.0, 0.0, 0.0, 0.0],
  [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0001, 0.0004, 0.0001, 0.0, 0.0, 0.0],
  [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0001, 0.0004, 0.0001, 0.0, 0.0],
  [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0001, 0.0004, 0.0001, 0.0],
  [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0001, 0.0004, 0.0001],
  [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0001, 0.0004],
]

[gyro]
bias_rad_s = [0.001, -0.002, 0.0005]
bias_sigma_rad_s = [1e-4, 1e-4, 2e-4]
bias_slope_rad_s_k = [1e-5, 0.0, -2e-5]
reference_temperature_c = 30.0

[accelerometer]
bias_m_s2 = [0.02, -0.01, 0.05]
bias_sigma_m_s2 = [0.01, 0.01, 0.3]
"#;

fn messages(text: &str) -> Vec<String> {
    match Calibration::from_toml("front.toml", text) {
        Ok(calibration) => panic!("accepted: {calibration:?}"),
        Err(errors) => errors.iter().map(ToString::to_string).collect(),
    }
}

#[test]
fn a_whole_file_is_read_as_written() {
    let calibration = Calibration::from_toml("front.toml", WHOLE).expect("valid");
    assert_eq!(calibration, toml::from_str(WHOLE).expect("serde agrees"));
    let magnetometer = calibration.magnetometer.expect("present");
    assert!((magnetometer.soft_iron[1][2] - 0.02).abs() < f64::EPSILON, "row by row");
    assert_eq!(magnetometer.heading_sigma_deg, Some(0.8));
    assert_eq!((calibration.date.year, calibration.date.month, calibration.date.day), (2026, 5, 4));
}

#[test]
fn what_is_written_is_read_back() {
    let calibration = Calibration::from_toml("front.toml", WHOLE).expect("valid");
    let text = calibration.to_toml().expect("written");
    assert_eq!(Calibration::from_toml("front.toml", &text), Ok(calibration));
}

#[test]
fn a_part_that_was_not_calibrated_is_absent() {
    let text = "serial = 1\ndate = 2026-05-04\n[accelerometer]\nbias_m_s2 = [0, 0, 0.1]\n";
    let calibration = Calibration::from_toml("front.toml", text).expect("valid");
    assert_eq!(calibration.magnetometer, None);
    assert_eq!(calibration.gyro, None);
}

#[test]
fn everything_wrong_is_said_at_once_with_its_line() {
    let text = "serial = 0\ndate = 2026-05-04T10:00:00Z\n[temperature]\nmin_c = 40\nmax_c = 20\n\
                [magnetometer]\nhard_iron_ut = [1, 2]\nsoft_iron = [[1, 0, 0], [0, 1, 0], [0, 0, 0]]\n\
                [gyro]\nbias = [0, 0, 0]\n";
    let expected = [
        "front.toml:1: serial: 0 is out of range; allowed: ",
        "front.toml:2: date: 2026-05-04T10:00:00Z is not a day; allowed: ",
        "front.toml:4: temperature.min_c: 40 is above max_c, 20; allowed: ",
        "front.toml:7: magnetometer.hard_iron_ut: has 2 elements, not 3; allowed: ",
        "front.toml:8: magnetometer.soft_iron: does not turn every field",
        "front.toml:9: gyro.bias_rad_s: is missing; allowed: ",
        "front.toml:10: gyro.bias: unknown key; did you mean gyro.bias_rad_s?; allowed: bias_rad_s",
    ];
    let messages = messages(text);
    assert_eq!(messages.len(), expected.len(), "{messages:#?}");
    for (message, expected) in messages.iter().zip(expected) {
        assert!(message.starts_with(expected), "{message}\n{expected}");
    }
}

#[test]
fn a_file_that_calibrates_nothing_is_refused() {
    let messages = messages("serial = 1\ndate = 2026-05-04\n");
    assert_eq!(messages.len(), 1, "{messages:?}");
    assert!(messages[0].contains("nothing is calibrated"), "{messages:?}");
}

#[test]
fn a_covariance_that_is_none_is_refused() {
    let rows = |size: usize, element: fn(usize, usize) -> f64| -> String {
        let row = |i| (0..size).map(|j| element(i, j).to_string()).collect::<Vec<_>>().join(", ");
        format!("[{}]", (0..size).map(|i| format!("[{}]", row(i))).collect::<Vec<_>>().join(", "))
    };
    let one: fn(usize, usize) -> f64 = |i, j| if i == j { 1.0 } else { 0.0 };
    let head = "serial = 1\ndate = 2026-05-04\n[magnetometer]\nhard_iron_ut = [1, 2, 3]\n\
                soft_iron = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n";
    let with = |covariance: &str| format!("{head}covariance = {covariance}\n");
    let good = Calibration::from_toml("front.toml", &with(&rows(12, one)));
    assert_eq!(
        good.expect("valid").magnetometer.expect("there").covariance.map(|c| c.len()),
        Some(12)
    );
    for (covariance, problem) in [
        (rows(11, one), "has 11 rows, not 12 or 15"),
        (rows(12, |i, j| if i == j { -1.0 } else { 0.0 }), "is no covariance"),
        (rows(12, |i, j| if i > j { 0.5 } else { f64::from(i == j) }), "is no covariance"),
        (rows(12, |i, j| f64::from(i == j) + 3.0), "row 1: has"),
        ("7".into(), "is a whole number"),
    ] {
        let covariance =
            if problem.starts_with("row") { covariance.replacen("4, ", "", 1) } else { covariance };
        let messages = messages(&with(&covariance));
        assert!(messages[0].contains(problem), "{messages:?}");
    }
    let slope = format!("{head}hard_iron_slope_ut_k = [1, 0, 0]\ncovariance = {}\n", rows(12, one));
    assert!(messages(&slope)[0].contains("15 rows"));
}

#[test]
fn every_key_is_explained() {
    let text = explain_calibration();
    let keys = calibration_keys();
    for key in &keys {
        let name = key.key.rsplit('.').next().expect("a name");
        assert!(text.contains(&format!("\n  {name} ")), "{name}\n{text}");
        let (last, parents) = (name, key.key.split('.').rev().skip(1).collect::<Vec<_>>());
        let mut value = &toml::from_str::<toml::Value>(WHOLE).expect("valid");
        for part in parents.into_iter().rev().chain([last]) {
            value = value.get(part).unwrap_or_else(|| panic!("{} is not in the example", key.key));
        }
    }
    let reference =
        keys.iter().find(|key| key.key.ends_with("magnetometer.reference_temperature_c"));
    assert_eq!(reference.and_then(|key| key.default.as_deref()), Some("25.0"));
}
