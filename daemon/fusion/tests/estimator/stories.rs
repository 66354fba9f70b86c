//! Stories: given a camera in a situation, when something happens, then the estimate behaves.

use glam::{DMat3, DVec3};
use lodestone_fusion::{
    Estimate, GYRO_BIAS, HeadingMode, HeadingOrigin, Increment, ORIENTATION, Parameters,
    SensorSpan, Step, so3,
};

use crate::scene::{CARRIED, Scene};
use crate::simulation::{DT, Motion, steps};

#[test]
fn a_camera_that_lies_still_learns_its_bias_and_does_not_wander() {
    for seed in 0..5 {
        let mut scene = Scene::new(seed);
        let report = scene.pass(60.0, Motion::Still);
        assert!(report.at_rest);

        let state = scene.filter.state().unwrap();
        let error = (scene.truth.gyro_bias - state.gyro_bias).abs();
        let variances = state.covariance.variances(GYRO_BIAS);
        for axis in 0..3 {
            let sigma = variances[axis].sqrt();
            assert!(error[axis] < 3.0 * sigma, "bias off by {} for {sigma}", error[axis]);
            assert!(sigma < 1e-4, "a minute of rest is worth more than {sigma} rad/s");
        }
        let estimate = scene.estimate();
        assert!(estimate.position.length() < 0.02, "wandered to {}", estimate.position);
        // A hundredth of a metre per second for each zero-velocity update, twenty a second.
        assert!(estimate.velocity.length() < 8e-3);
        assert!(scene.attitude_sigmas() < 4.0);
    }
}

#[test]
fn a_constant_turn_is_followed_all_the_way_round() {
    for rate in [DVec3::Z * 0.5, DVec3::X * 1.0, DVec3::new(0.7, -0.4, 0.9)] {
        let mut scene = Scene::new(3);
        scene.pass(2.0, Motion::Still);
        let report = scene.pass(30.0, Motion::Turn(rate));
        assert!(!report.at_rest);
        let error = scene.attitude_error();
        assert!(error.truncate().length() < 0.06 && error.z.abs() < 0.2, "{error} at {rate}");
        assert!((scene.estimate().angular_rate - rate).length() < 1.0, "one step's noise");
    }
}

#[test]
fn a_slow_turn_is_not_taken_for_rest() {
    // Given a camera that has lain still and knows its bias, when it is turned by half a degree per
    // second for a minute, then the heading follows.
    let mut scene = Scene::new(4);
    scene.pass(20.0, Motion::Still);
    let before = scene.attitude_error().z;
    let up = scene.truth.orientation.conjugate() * DVec3::Z;
    let report = scene.pass(60.0, Motion::Turn(up * 0.0087));
    assert!(!report.at_rest);
    let error = scene.attitude_error().z - before;
    assert!(error.abs() < 0.1, "{error} rad of 0.52");
}

#[test]
fn a_carried_camera_keeps_upright_and_north() {
    for seed in 0..4 {
        let mut scene = Scene::new(seed);
        scene.pass(2.0, Motion::Still);
        for _ in 0..4 {
            scene.pass(15.0, CARRIED);
            let error = scene.attitude_error();
            assert!(error.truncate().length() < 0.06, "tilt {error}, seed {seed}");
            assert!(error.z.abs() < 0.15, "heading {error}, seed {seed}");
        }
    }
}

#[test]
fn a_gap_makes_it_less_sure_and_the_magnetometer_makes_it_sure_again() {
    // Given a carried camera, when its samples stop for a second while it turns, then the filter
    // admits that it may have turned, and finds back.
    let mut scene = Scene::new(8);
    scene.pass(2.0, Motion::Still);
    scene.pass(10.0, CARRIED);
    let before = scene.estimate();
    for _ in 0..steps(1.0) {
        scene.truth.step(CARRIED);
    }
    scene.filter.cross_gap(SensorSpan::from_secs_f64(1.0));
    let after = scene.estimate();

    let grown = |of: fn(&Estimate) -> DMat3| {
        DVec3::AXES.into_iter().all(|e| e.dot((of(&after) - of(&before)) * e) > 0.0)
    };
    assert!(grown(|e| e.orientation_covariance));
    assert!(grown(|e| e.velocity_covariance));
    assert!(grown(|e| e.position_covariance));
    assert!(!after.at_rest);
    assert!(scene.attitude_sigmas() < 3.0, "honest about the gap");

    scene.pass(20.0, CARRIED);
    assert!(scene.attitude_error().length() < 0.2, "{}", scene.attitude_error());
}

#[test]
fn a_gap_during_the_alignment_begins_it_anew() {
    let mut scene = Scene::new(1);
    scene.pass(0.9, Motion::Still);
    scene.filter.cross_gap(SensorSpan::from_secs_f64(2.0));
    let report = scene.pass(0.9, Motion::Still);
    assert!(report.waiting.is_some(), "rest on both sides of a gap is not one rest");
    assert_eq!(scene.filter.estimate(), None);
    assert!(scene.pass(0.3, Motion::Still).waiting.is_none());
}

#[test]
fn the_longest_gap_leaves_a_working_filter() {
    // Given a filter, when its sensor was away for a month, or a century, then it still gives
    // finite estimates with a covariance that is one, and finds back to the truth at rest.
    for seconds in [2.6e6, 3.2e9] {
        let mut scene = Scene::new(2);
        scene.pass(3.0, Motion::Still);
        scene.filter.cross_gap(SensorSpan::from_secs_f64(seconds));
        scene.pass(60.0, Motion::Still);
        let p = scene.filter.state().unwrap().covariance.block(ORIENTATION, ORIENTATION);
        assert!(p.determinant() > 0.0 && p.x_axis.x > 0.0);
        let error = scene.attitude_error();
        assert!(error.length() < 0.3, "{error} after {seconds} s");
    }
}

#[test]
fn without_a_magnetometer_the_heading_is_called_arbitrary() {
    let mut scene = Scene::new(4);
    scene.truth.has_mag = false;
    scene.pass(3.0, Motion::Still);
    scene.pass(10.0, CARRIED);
    let estimate = scene.estimate();
    assert_eq!(estimate.heading_origin, HeadingOrigin::Arbitrary);
    assert_eq!(estimate.magnetic_field_ut, None);
    let heading = estimate.orientation_covariance.z_axis.z;
    assert!(heading > 9.8, "nothing measures it, yet its variance is {heading} rad²");
    let up = scene.truth.orientation.conjugate() * DVec3::Z;
    assert!((estimate.orientation.apply(up) - DVec3::Z).length() < 0.06, "but it is level");
}

#[test]
fn without_a_magnetometer_the_heading_drifts_no_more_than_the_gyroscope() {
    let mut scene = Scene::new(4);
    scene.truth.has_mag = false;
    scene.pass(3.0, Motion::Still);
    // Heading of one body axis in both worlds; their difference is arbitrary but constant.
    let offset = |scene: &Scene| {
        let seen = scene.estimate().orientation.quaternion();
        let turned = (scene.truth.orientation * seen.conjugate()).normalize();
        2.0 * turned.z.atan2(turned.w)
    };
    let before = offset(&scene);
    scene.pass(60.0, CARRIED);
    let drift = (offset(&scene) - before + core::f64::consts::PI)
        .rem_euclid(core::f64::consts::TAU)
        - core::f64::consts::PI;
    assert!(drift.abs() < 0.2, "{drift} rad");
}

#[test]
fn a_magnetometer_that_falls_silent_leaves_the_heading_held() {
    let mut scene = Scene::new(4);
    scene.pass(5.0, Motion::Still);
    assert_eq!(scene.estimate().heading_origin, HeadingOrigin::Magnetometer);
    let sure = scene.estimate().orientation_covariance.z_axis.z;

    scene.truth.has_mag = false;
    scene.pass(0.5, CARRIED);
    assert_eq!(scene.estimate().heading_origin, HeadingOrigin::Magnetometer);
    scene.pass(20.0, CARRIED);
    assert_eq!(scene.estimate().heading_origin, HeadingOrigin::Held);
    assert!(scene.estimate().orientation_covariance.z_axis.z > sure);

    scene.truth.has_mag = true;
    scene.pass(2.0, CARRIED);
    assert_eq!(scene.estimate().heading_origin, HeadingOrigin::Magnetometer);
}

#[test]
fn a_magnet_passing_by_does_not_turn_the_heading() {
    // Given an adaptive heading, when a magnet of thrice the earth's field is held to the camera
    // for ten seconds, then it is noticed, the heading stays, and it recovers.
    let mut scene = Scene::new(6);
    scene.pass(5.0, Motion::Still);
    scene.pass(5.0, CARRIED);
    let before = scene.attitude_error().z;
    scene.truth.disturbance = DVec3::new(90.0, -60.0, 80.0);
    scene.pass(10.0, CARRIED);
    let estimate = scene.estimate();
    assert!(estimate.magnetic_disturbance);
    assert_eq!(estimate.heading_origin, HeadingOrigin::Held);
    assert!((scene.attitude_error().z - before).abs() < 0.15, "{}", scene.attitude_error());

    scene.truth.disturbance = DVec3::ZERO;
    scene.pass(3.0, CARRIED);
    assert!(!scene.estimate().magnetic_disturbance);
    assert_eq!(scene.estimate().heading_origin, HeadingOrigin::Magnetometer);
}

#[test]
fn a_magnetometer_that_speaks_late_is_heard() {
    // Given an alignment without a magnetometer and a camera that was carried about, when the
    // magnetometer begins to speak, then north is found at once and the consumer is told.
    let mut scene = Scene::new(9);
    scene.truth.has_mag = false;
    scene.pass(2.0, Motion::Still);
    scene.pass(10.0, CARRIED);
    assert_eq!(scene.estimate().heading_origin, HeadingOrigin::Arbitrary);
    scene.truth.has_mag = true;
    let mut turned = 0;
    for _ in 0..steps(5.0) {
        turned += u32::from(scene.pass(0.0025, CARRIED).world_turned);
    }
    assert_eq!(turned, 1);
    assert_eq!(scene.estimate().heading_origin, HeadingOrigin::Magnetometer);
    assert!(scene.attitude_error().z.abs() < 0.15, "{}", scene.attitude_error());
}

#[test]
fn north_is_true_where_the_declination_is_known() {
    // Given a field that points 12 degrees east of the north that is asked for, when the camera is
    // aligned and carried about, then its heading counts from that north.
    let declination = 12.0_f64.to_radians();
    let p = Parameters { field_bearing_rad: declination, ..Parameters::default() };
    let mut scene = Scene::with(11, p);
    for (pause, motion) in [(2.0, Motion::Still), (10.0, CARRIED)] {
        scene.pass(pause, motion);
        // The simulation has its north where the field is: its truth lies further west.
        let error = scene.attitude_error().z - declination;
        assert!(error.abs() < 0.15, "{error}");
    }
}

#[test]
fn initial_only_never_listens_again() {
    let p = Parameters { heading: HeadingMode::InitialOnly, ..Parameters::default() };
    let mut scene = Scene::with(6, p);
    scene.pass(2.0, Motion::Still);
    let mut other = scene.clone();
    other.truth.has_mag = false;
    scene.truth.has_mag = true;
    // The magnet speaks to one of the two only. Noise is drawn after the motion, so both cameras
    // would differ from the first reading on; standing still, only the sensors' noise differs.
    scene.truth.disturbance = DVec3::X * 200.0;
    scene.pass(10.0, Motion::Still);
    other.pass(10.0, Motion::Still);
    let turned = so3::log(
        scene.estimate().orientation.quaternion()
            * other.estimate().orientation.quaternion().conjugate(),
    );
    assert!(turned.length() < 2e-3, "{turned}");
    assert_eq!(scene.estimate().heading_origin, HeadingOrigin::InitialOnly);
}

#[test]
fn a_copy_in_mid_stream_continues_bit_by_bit() {
    let mut scene = Scene::new(12);
    for (seconds, motion) in [(0.4, Motion::Still), (3.0, Motion::Still), (5.0, CARRIED)] {
        scene.pass(seconds, motion);
        let (mut copy, mut original) = (scene.filter, scene.clone());
        for _ in 0..2_000 {
            let step = original.truth.step(CARRIED);
            let (a, b) = (original.filter.step(&step), copy.step(&step));
            // The debug form prints every digit and the sign of zero.
            assert_eq!(format!("{a:?}"), format!("{b:?}"));
        }
        assert_eq!(format!("{:?}", original.filter), format!("{copy:?}"));
    }
}

#[test]
fn looking_ahead_is_where_the_next_step_arrives() {
    let mut scene = Scene::new(13);
    scene.pass(2.0, Motion::Still);
    for _ in 0..200 {
        let step = Step { mag: None, ..scene.truth.step(CARRIED) };
        let ahead = scene.filter.estimate_ahead(&step.increment).unwrap();
        // A copy without its updates would be exact; they move it by far less than the step does.
        scene.filter.step(&step);
        let then = scene.estimate();
        assert_eq!(ahead.time, then.time);
        let turned = ahead.orientation.inverse() * then.orientation;
        assert!(so3::log(turned.quaternion()).length() < 5e-3);
        assert!((ahead.position - then.position).length() < 1e-2);
    }
    let now = scene.estimate();
    assert_eq!(scene.filter.estimate_ahead(&Increment::ZERO), Some(now));
}

#[test]
fn the_attitude_keeps_its_unit_length() {
    let mut scene = Scene::new(14);
    scene.pass(2.0, Motion::Still);
    for _ in 0..20 {
        scene.pass(10.0, Motion::Carried { rate_sigma: 3.0, speed_sigma: 1.0 });
        let norm = scene.estimate().orientation.quaternion().length();
        assert!((norm - 1.0).abs() < 1e-12, "{norm}");
    }
    assert!(scene.estimate().time.as_nanos() as f64 * 1e-9 > 200.0 - DT);
}
