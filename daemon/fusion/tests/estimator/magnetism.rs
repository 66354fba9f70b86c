//! Stories of magnets: passing by, standing about, mounted on the camera.

use glam::DVec3;
use lodestone_fusion::{HeadingOrigin, Parameters};

use crate::scene::{CARRIED, Scene};
use crate::simulation::Motion;

/// Five microtesla from every side.
fn five_microtesla() -> impl Iterator<Item = DVec3> {
    DVec3::AXES.into_iter().flat_map(|axis| [axis * 5.0, axis * -5.0])
}

#[test]
fn five_microtesla_on_a_calm_scene_are_noticed_within_a_second_and_so_is_their_end() {
    for (seed, magnet) in five_microtesla().enumerate() {
        for motion in [Motion::Still, Motion::Carried { rate_sigma: 0.1, speed_sigma: 0.05 }] {
            // A deviation of its own could hide the magnet: this scene has none.
            let mut scene = Scene::perfect(seed as u64);
            scene.pass(3.0, Motion::Still);
            scene.pass(3.0, motion);
            assert!(!scene.estimate().magnetic_disturbance);
            scene.truth.disturbance = magnet;
            scene.pass(1.0, motion);
            assert!(scene.estimate().magnetic_disturbance, "{magnet}, {motion:?}");
            scene.truth.disturbance = DVec3::ZERO;
            scene.pass(1.5, motion);
            assert!(!scene.estimate().magnetic_disturbance, "{magnet}, {motion:?}");
        }
    }
}

#[test]
fn after_a_minute_of_disturbance_the_heading_is_back_within_half_a_minute() {
    for (seed, magnet) in
        [DVec3::new(30.0, 10.0, 5.0), DVec3::new(-12.0, 0.0, 0.0), DVec3::new(0.0, -60.0, 20.0)]
            .into_iter()
            .enumerate()
    {
        for motion in [Motion::Still, CARRIED] {
            let mut scene = Scene::perfect(seed as u64);
            scene.pass(3.0, Motion::Still);
            scene.pass(10.0, motion);
            scene.truth.disturbance = magnet;
            scene.pass(60.0, motion);
            scene.truth.disturbance = DVec3::ZERO;
            scene.pass(30.0, motion);
            let estimate = scene.estimate();
            let error = scene.attitude_error().z.to_degrees();
            assert!(error.abs() < 5.0, "{error}° off after {magnet}, {motion:?}");
            assert_eq!(
                estimate.heading_origin,
                HeadingOrigin::Magnetometer,
                "{magnet}, {motion:?}"
            );
        }
    }
}

#[test]
fn another_field_that_is_the_same_everywhere_becomes_the_expected_one() {
    // Given a camera aligned beside steel, when it is carried into the open, then the field there
    // is a disturbance at first, and the expected field after two minutes of turning in it.
    let mut scene = Scene::perfect(3);
    scene.truth.disturbance = DVec3::new(0.0, 6.0, -9.0);
    scene.pass(3.0, Motion::Still);
    scene.truth.disturbance = DVec3::ZERO;
    scene.pass(2.0, CARRIED);
    assert!(scene.estimate().magnetic_disturbance);
    scene.pass(140.0, CARRIED);
    assert!(!scene.estimate().magnetic_disturbance);
    assert!(scene.attitude_error().z.abs() < 0.1, "{}", scene.attitude_error());
}

#[test]
fn a_magnet_mounted_while_running_is_learnt_once_the_camera_has_turned() {
    for (seed, magnet) in
        [DVec3::new(12.0, 0.0, 0.0), DVec3::new(-5.0, 9.0, 6.0)].into_iter().enumerate()
    {
        let heading_error_deg = |enabled: bool| {
            let mut p = Parameters::default();
            p.hard_iron.enabled = enabled;
            let mut scene = Scene::perfect_with(seed as u64, p);
            scene.pass(3.0, Motion::Still);
            scene.truth.hard_iron = magnet;
            scene.pass(120.0, CARRIED);
            let mut squares = 0.0;
            for _ in 0..60 {
                scene.pass(1.0, CARRIED);
                squares += scene.attitude_error().z.to_degrees().powi(2) / 60.0;
            }
            (squares.sqrt(), scene.estimate().magnetic_disturbance)
        };
        let (learnt, disturbed) = heading_error_deg(true);
        let (ignored, still_disturbed) = heading_error_deg(false);
        assert!(learnt < 0.5 * ignored, "{learnt}° with {magnet} learnt, {ignored}° without");
        assert!(!disturbed && still_disturbed, "{magnet}");
    }
}
