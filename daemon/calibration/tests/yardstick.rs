//! The yardstick of `examples/yardstick.rs` with few draws, so that a change for the worse is seen.
#![allow(unreachable_pub, dead_code, reason = "the simulator serves several tests")]

mod simulator;

use glam::DVec3;
use lodestone_calibration::{FieldPrior, Outcome, Settings, calibrate};
use nalgebra::{DMatrix, DVector};
use simulator::{Motion, Scene, Tilt, Unit, unit};

const DRAWS: u64 = 6;

/// Errors in the order of size, degrees, and how many are within 2 σ.
fn errors(scene: &Scene) -> (Vec<f64>, usize) {
    let (mut errors, mut covered) = (Vec::new(), 0);
    for seed in 100..100 + DRAWS {
        let (samples, unit) = scene.draw(seed);
        let outcome = calibrate(&samples, &Settings::default()).expect("it can tell");
        let error = scene.heading_error_deg(&unit, &outcome, seed);
        covered += usize::from(error <= 2.0 * outcome.magnetometer.heading_sigma_deg);
        errors.push(error);
    }
    errors.sort_by(f64::total_cmp);
    (errors, covered)
}

fn assert_within(scene: &Scene, median_deg: f64, worst_deg: f64) {
    let (errors, covered) = errors(scene);
    let (median, worst) = (errors[errors.len() / 2], errors[errors.len() - 1]);
    assert!(median <= median_deg && worst <= worst_deg, "{scene:?}: {errors:?}");
    assert!(covered + 1 >= errors.len(), "{covered} of {errors:?} within 2 σ");
}

#[test]
fn five_degrees_of_tilt_are_enough() {
    for tilt in [Tilt::Cone(5.0), Tilt::Rock(5.0), Tilt::Slow(5.0)] {
        assert_within(&Scene::yardstick(tilt), 0.2, 0.4);
    }
}

#[test]
fn ten_degrees_are_better() {
    for tilt in [Tilt::Cone(10.0), Tilt::Rock(10.0), Tilt::Slow(10.0)] {
        assert_within(&Scene::yardstick(tilt), 0.12, 0.25);
    }
}

#[test]
fn a_tumble_is_best() {
    assert_within(&Scene::yardstick(Tilt::Tumble), 0.08, 0.15);
}

#[test]
fn it_does_not_matter_what_the_gyroscope_means() {
    for tilt in [Tilt::Cone(5.0), Tilt::Tumble] {
        let scene = Scene { mean_rate: true, rest_s: 4.0, ..Scene::yardstick(tilt) };
        assert_within(&scene, 0.2, 0.4);
    }
}

#[test]
fn a_noisy_gyroscope_is_noticed() {
    let noisy = Scene { noise_scale: 5.0, ..Scene::yardstick(Tilt::Slow(10.0)) };
    assert_within(&noisy, 0.3, 0.5);
}

fn warmed(scene: &Scene, seed: u64) -> (Outcome, Unit) {
    let mut warming = Unit::drawn(seed);
    warming.warming_k_min = Some(6.0);
    warming.errors.hard_slope = DVec3::new(0.3, -0.2, 0.1);
    warming.errors.gyro_slope = DVec3::new(1e-4, -5e-5, 8e-5);
    let motion = Motion::drawn(scene, seed);
    let samples = unit::record(scene, &warming, &motion, seed);
    (calibrate(&samples, &Settings::default()).expect("it can tell"), warming)
}

#[test]
fn what_warmth_does_is_found() {
    let scene = Scene { duration_s: 240.0, turns: 8.0, ..Scene::yardstick(Tilt::Tumble) };
    let (outcome, unit) = warmed(&scene, 7);
    let e = unit.errors;
    let slope = outcome.magnetometer.hard_iron_slope_ut_k.expect("24 K");
    assert!((slope - e.hard_slope).length() < 0.02, "{slope}");
    let slope = outcome.gyro.bias_slope_rad_s_k.expect("24 K");
    assert!((slope - e.gyro_slope).length() < 4e-5, "{slope}");
    let reference_c = outcome.temperature.expect("there is one").reference_c;
    let hard = e.hard_iron + e.hard_slope * (reference_c - 20.0);
    assert!((outcome.magnetometer.hard_iron_ut - hard).length() < 0.3, "{outcome:?}");
    assert_eq!(outcome.magnetometer.covariance.len(), 15);
}

#[test]
fn without_warmth_there_are_no_slopes() {
    let (samples, _) = Scene::yardstick(Tilt::Tumble).draw(8);
    let outcome = calibrate(&samples, &Settings::default()).expect("it can tell");
    assert_eq!(outcome.magnetometer.hard_iron_slope_ut_k, None);
    assert_eq!(outcome.gyro.bias_slope_rad_s_k, None);
    assert_eq!(outcome.magnetometer.covariance.len(), 12);
}

#[test]
fn biases_are_found_as_well_as_they_say() {
    let (samples, unit) = Scene::yardstick(Tilt::Tumble).draw(9);
    let outcome = calibrate(&samples, &Settings::default()).expect("it can tell");
    let gyro = (outcome.gyro.bias_rad_s - unit.errors.gyro_bias).abs();
    assert!(gyro.cmple(outcome.gyro.bias_sigma_rad_s * 4.0).all(), "{gyro} {outcome:?}");
    assert!(gyro.max_element() < 2e-4, "{gyro}");
    let accel = outcome.accelerometer.expect("a tumble shows it");
    let error = (accel.bias_m_s2 - unit.errors.accel_bias).abs();
    assert!(error.cmple(accel.bias_sigma_m_s2 * 4.0).all(), "{error} {accel:?}");
    assert!(error.max_element() < 0.02, "{error}");
}

/// Squared error of what the file will say, in units of its covariance.
fn normalised_square(outcome: &Outcome, unit: &Unit) -> f64 {
    let m = &outcome.magnetometer;
    let off = m.soft_iron - unit.errors.soft_iron.inverse();
    let rows = off.transpose().to_cols_array();
    let hard = (m.hard_iron_ut - unit.errors.hard_iron).to_array();
    let error = DVector::from_iterator(12, rows.into_iter().chain(hard));
    let covariance = DMatrix::from_fn(12, 12, |i, j| m.covariance[i][j]);
    error.dot(&covariance.cholesky().expect("positive definite").solve(&error))
}

#[test]
fn the_covariance_is_that_of_the_errors() {
    for tilt in [Tilt::Rock(5.0), Tilt::Tumble] {
        let scene = Scene::yardstick(tilt);
        let squares = (20..20 + DRAWS).map(|seed| {
            let (samples, unit) = scene.draw(seed);
            let outcome = calibrate(&samples, &Settings::default()).expect("it can tell");
            normalised_square(&outcome, &unit)
        });
        let mean = squares.sum::<f64>() / DRAWS as f64;
        // χ² with 12 degrees of freedom, the mean of six: 12 ± 2; scale and field share a weak prior.
        assert!((5.0..19.0).contains(&mean), "{tilt:?}: {mean}");
    }
}

#[test]
fn a_known_field_fixes_the_scale() {
    let scene = Scene::yardstick(Tilt::Tumble);
    let (samples, unit) = scene.draw(10);
    let strength_ut = unit.field.length();
    let field =
        FieldPrior { strength_ut, strength_sigma_ut: 0.1, dip_deg: 67.0, dip_sigma_deg: 0.5 };
    let settings = Settings { field: Some(field), ..Settings::default() };
    let m = calibrate(&samples, &settings).expect("it can tell").magnetometer;
    assert!((m.field.strength_ut - strength_ut).abs() < 0.3, "{:?}", m.field);
    let residual = m.soft_iron * unit.errors.soft_iron - glam::DMat3::IDENTITY;
    let largest = residual.to_cols_array().into_iter().fold(0.0, |l: f64, e| l.max(e.abs()));
    assert!(largest < 0.01, "{residual}");
}

#[test]
fn the_same_samples_give_the_same_bits() {
    let (samples, _) = Scene::yardstick(Tilt::Slow(10.0)).draw(11);
    let once = calibrate(&samples, &Settings::default());
    assert_eq!(once, calibrate(&samples, &Settings::default()));
}
