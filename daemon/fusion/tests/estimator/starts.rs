//! Stories of how a filter begins.

use glam::DVec3;
use lodestone_fusion::Parameters;

use crate::scene::{CARRIED, Scene};
use crate::simulation::Motion;

#[test]
fn at_rest_a_calibrated_camera_knows_heading_and_tilt_after_two_seconds() {
    // Given ZED 2 sensors with their biases and a calibrated compass in an undisturbed field.
    let (mut headings, mut tilts) = (Vec::new(), Vec::new());
    for seed in 0..100 {
        let mut scene = Scene::new(seed);
        scene.truth.deviation = 0.0;
        scene.pass(2.0, Motion::Still);
        let error = scene.attitude_error();
        headings.push(error.z.abs().to_degrees());
        tilts.push(error.truncate().length().to_degrees());
    }
    let quantile = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[values.len() * 9 / 10]
    };
    let (heading, tilt) = (quantile(&mut headings), quantile(&mut tilts));
    println!("nine of ten within {heading:.2} deg heading, {tilt:.2} deg tilt");
    assert!(heading < 2.0 && tilt < 0.65, "{heading} {tilt}");
    assert!(tilts[tilts.len() / 2] < 0.5, "{}", tilts[tilts.len() / 2]);
}

#[test]
fn in_motion_a_coarse_start_is_honest_and_is_refined() {
    let (mut covered, mut still_covered) = (0, 0);
    for seed in 0..50 {
        let mut scene = Scene::new(seed);
        scene.pass(2.0, CARRIED);
        let first = scene.estimate();
        let tilt_sigma = first.orientation_covariance.x_axis.x.sqrt();
        assert!(tilt_sigma > 0.02, "a start in motion is not sure: {tilt_sigma}");
        covered += u32::from(scene.attitude_sigmas() < 3.0);
        assert!(!first.at_rest);

        scene.pass(30.0, CARRIED);
        still_covered += u32::from(scene.attitude_sigmas() < 3.5);
        let after = scene.estimate().orientation_covariance;
        assert!(after.x_axis.x.sqrt() < 0.5 * tilt_sigma, "seed {seed}");
    }
    assert!(covered >= 48, "{covered} of 50 are covered after two seconds");
    assert!(still_covered >= 47, "{still_covered} of 50 are covered half a minute later");
}

#[test]
fn a_start_in_motion_ends_at_rest_as_well_as_a_start_at_rest() {
    for seed in 0..5 {
        let mut scene = Scene::new(seed);
        scene.pass(3.0, CARRIED);
        scene.pass(20.0, Motion::Still);
        let error = scene.attitude_error();
        assert!(error.truncate().length() < 0.015, "tilt {error}, seed {seed}");
        assert!(error.z.abs() < 0.12, "heading {error}, seed {seed}");
        assert!(scene.estimate().velocity.length() < 0.01, "seed {seed}");
    }
}

#[test]
fn who_does_not_want_a_coarse_start_waits_for_rest() {
    let mut p = Parameters::default();
    p.alignment.motion_s = None;
    let mut scene = Scene::with(1, p);
    assert!(scene.pass(20.0, CARRIED).waiting.is_some());
    assert!(scene.pass(2.0, Motion::Still).waiting.is_none());
    assert!(scene.attitude_error().length() < 0.2);
    assert_ne!(scene.truth.gyro_bias, DVec3::ZERO);
}
