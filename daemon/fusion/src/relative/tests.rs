use std::prelude::v1::*;

use glam::{DMat3, DQuat, DVec3};
use proptest::prelude::*;

use super::*;
use crate::testing::Normal;

fn station(seed: u64, orientation: DQuat, position: DVec3) -> Station {
    let mut random = Normal::seeded(seed);
    let covariance = |random: &mut Normal, sigma: f64| {
        let root =
            DMat3::from_cols(random.vector(sigma), random.vector(sigma), random.vector(sigma));
        root * root.transpose() + DMat3::IDENTITY * (0.1 * sigma * sigma)
    };
    Station {
        orientation: Rotation::from_unit(orientation),
        orientation_covariance: covariance(&mut random, 0.02),
        angular_rate: random.vector(1.0),
        position,
        position_covariance: covariance(&mut random, 0.1),
        velocity: random.vector(1.0),
        velocity_covariance: covariance(&mut random, 0.1),
        at_rest: false,
        field: FieldTie {
            with_orientation_rad2: DVec3::ZERO,
            variance_rad2: 1.2e-3,
            prior_variance_rad2: 1.2e-3,
            way_m: 0.4,
        },
    }
}

fn rotation() -> impl Strategy<Value = DQuat> {
    prop::array::uniform3(-3.0..3.0_f64).prop_map(|v| so3::exp(DVec3::from_array(v)))
}

fn place() -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-50.0..50.0_f64).prop_map(DVec3::from_array)
}

proptest! {
    #[test]
    fn there_and_back_is_nothing(
        qa in rotation(), qb in rotation(), pa in place(), pb in place(), seed in 0..1000_u64,
    ) {
        let (a, b) = (station(seed, qa, pa), station(seed + 1, qb, pb));
        let (ab, ba) = (relative(&a, &b), relative(&b, &a));
        let whole = ab.orientation * ba.orientation;
        prop_assert!(so3::log(whole.quaternion()).length() < 1e-12);
        // p_a = R_ab (R_ba p_a + D_ba) + D_ab for any p_a.
        let (d_ab, d_ba) = (ab.distance.unwrap().vector, ba.distance.unwrap().vector);
        prop_assert!((ab.orientation.apply(d_ba) + d_ab).length() < 1e-9);
        // The covariance of the rotation says the same in either body's axes.
        let turned = ab.orientation.matrix();
        let back = turned * ba.orientation_covariance * turned.transpose();
        prop_assert!((back - ab.orientation_covariance).to_cols_array().iter().all(|x| x.abs() < 1e-12));
        let inverse = ab.inverse();
        prop_assert!(so3::log(inverse.orientation.quaternion() * ba.orientation.quaternion().conjugate()).length() < 1e-12);
        prop_assert!((inverse.distance.unwrap().vector - d_ba).length() < 1e-9);
    }

    #[test]
    fn at_no_distance_it_is_a_pure_rotation(qa in rotation(), qb in rotation(), p in place()) {
        let ab = relative(&station(1, qa, p), &station(2, qb, p));
        prop_assert_eq!(ab.distance.unwrap().vector, DVec3::ZERO);
        let expected = qa.conjugate() * qb;
        prop_assert!(so3::log(ab.orientation.quaternion() * expected.conjugate()).length() < 1e-12);
    }

    #[test]
    fn a_point_in_the_world_is_one_point_for_both(
        qa in rotation(), qb in rotation(), pa in place(), pb in place(), point in place(),
    ) {
        let (a, b) = (station(1, qa, pa), station(2, qb, pb));
        let seen_by_b = qb.conjugate() * (point - pb);
        let ab = relative(&a, &b);
        let seen_by_a = ab.orientation.apply(seen_by_b) + ab.distance.unwrap().vector;
        prop_assert!((seen_by_a - qa.conjugate() * (point - pa)).length() < 1e-9);
    }
}

#[test]
fn covariances_are_those_of_drawn_errors() {
    // Given two poses whose errors are drawn as their covariances say, with a common deviation
    let mut random = Normal::seeded(5);
    let sigma_d = 0.05;
    let own = 0.01;
    let aligned = |q: DQuat, p: DVec3| Station {
        orientation_covariance: DMat3::from_diagonal(DVec3::new(
            own * own,
            own * own,
            own * own + sigma_d * sigma_d,
        )),
        position_covariance: DMat3::from_diagonal(DVec3::splat(1e-12)),
        field: FieldTie {
            // The heading was set by the field: its error is the deviation's opposite.
            with_orientation_rad2: DVec3::Z * -(sigma_d * sigma_d),
            variance_rad2: sigma_d * sigma_d,
            prior_variance_rad2: sigma_d * sigma_d,
            way_m: 0.4,
        },
        ..station(3, q, p)
    };
    let (qa, qb) = (so3::exp(DVec3::new(0.1, -0.2, 2.0)), so3::exp(DVec3::new(0.3, 0.1, -1.0)));
    let (a, b) = (aligned(qa, DVec3::ZERO), aligned(qb, DVec3::ZERO));
    let found = relative(&a, &b);
    // When the truth is drawn again and again
    let (mut sum, draws) = (DMat3::ZERO, 20_000);
    for _ in 0..draws {
        let common = DVec3::Z * (-sigma_d * random.number());
        let true_a = so3::exp(common + random.vector(own)) * qa;
        let true_b = so3::exp(common + random.vector(own)) * qb;
        let truth = true_a.conjugate() * true_b;
        let error = so3::log(truth * found.orientation.quaternion().conjugate());
        sum += DMat3::from_cols(error * error.x, error * error.y, error * error.z);
    }
    // Then their spread is the covariance: without the deviation, which is five times as large
    let spread = sum * (1.0 / f64::from(draws));
    let difference = (spread - found.orientation_covariance).to_cols_array();
    assert!(difference.iter().all(|d| d.abs() < 0.05 * own * own), "{difference:?}");
    assert!(found.field_correlation > 0.99);
}

#[test]
fn far_apart_or_nobody_knows_how_far_nothing_is_shared() {
    let with_tie = |p: DVec3| Station {
        field: FieldTie {
            with_orientation_rad2: DVec3::Z * -1.2e-3,
            variance_rad2: 1.2e-3,
            prior_variance_rad2: 1.2e-3,
            way_m: 0.4,
        },
        ..station(4, DQuat::IDENTITY, p)
    };
    let here = with_tie(DVec3::ZERO);
    let sum = here.orientation_covariance * 2.0;
    let far = relative(&here, &with_tie(DVec3::X * 40.0));
    assert!((far.orientation_covariance - sum).to_cols_array().iter().all(|x| x.abs() < 1e-15));
    let unknown = Station {
        position_covariance: DMat3::IDENTITY * crate::UNKNOWN_POSITION_SIGMA_M.powi(2),
        ..with_tie(DVec3::ZERO)
    };
    let nowhere = relative(&here, &unknown);
    assert_eq!(nowhere.distance, None);
    assert!(nowhere.field_correlation.abs() < f64::MIN_POSITIVE);
    let near = relative(&here, &with_tie(DVec3::ZERO));
    assert!(near.orientation_covariance.z_axis.z < far.orientation_covariance.z_axis.z);
}

#[test]
fn a_filter_that_learnt_its_deviation_shares_less_of_it() {
    let with_variance = |variance_rad2: f64| FieldTie {
        with_orientation_rad2: DVec3::Z * -variance_rad2,
        variance_rad2,
        prior_variance_rad2: 1.2e-3,
        way_m: 0.4,
    };
    let of = |v: f64| shared(&with_variance(v), &with_variance(v), 1.0).z_axis.z;
    assert!((of(1.2e-3) - 1.2e-3).abs() < 1e-15, "all of it before anything was learnt");
    assert!((of(0.6e-3) - 0.3e-3).abs() < 1e-15);
    // Never more than Cauchy and Schwarz allow, also where a disturbance raised one of them.
    let mixed = shared(&with_variance(9e-3), &with_variance(0.3e-3), 1.0).z_axis.z;
    assert!(mixed * mixed <= 9e-3 * 0.3e-3);
}

#[test]
fn carrying_a_pose_on_turns_and_moves_it() {
    let turning = Station {
        angular_rate: DVec3::Z * 2.0,
        velocity: DVec3::X * 3.0,
        ..station(9, DQuat::IDENTITY, DVec3::ZERO)
    };
    let later = turning.carried(0.01);
    assert!((later.orientation.to_yaw_pitch_roll().0 - 0.02).abs() < 1e-12);
    assert!((later.position - DVec3::X * 0.03).length() < 1e-12);
    assert!(later.position_covariance.x_axis.x > turning.position_covariance.x_axis.x);
    let back = later.carried(-0.01);
    assert!((back.position - turning.position).length() < 1e-12);
}

#[test]
fn two_cameras_on_one_body_are_as_they_were_mounted_however_the_body_turns() {
    let mount = |yaw: f64, position: DVec3| Mount {
        orientation: Rotation::from_yaw_pitch_roll(yaw, 0.1, -0.05),
        position,
        rotation_sigma_rad: 0.01,
        position_sigma_m: 0.005,
    };
    let (a, b) = (mount(0.0, DVec3::new(1.2, 0.3, 0.9)), mount(3.0, DVec3::new(-1.5, 0.0, 1.1)));
    let surveyed = mounted(&a, &b);
    let body = station(6, so3::exp(DVec3::new(0.2, 0.1, 2.0)), DVec3::new(7.0, 8.0, 9.0));
    let seen = relative(&a.carried_by(&body), &b.carried_by(&body));
    let turned = surveyed.orientation.quaternion() * seen.orientation.quaternion().conjugate();
    assert!(so3::log(turned).length() < 1e-12);
    let (expected, found) = (surveyed.distance.unwrap(), seen.distance.unwrap());
    assert!((expected.vector - found.vector).length() < 1e-12);
    // The mounting's errors, both of them, and not the body's.
    let variance = surveyed.orientation_covariance.x_axis.x;
    assert!((variance - 2.0 * 0.01_f64.powi(2)).abs() < 1e-12);
    // A camera off the axis moves while the body turns.
    let spinning = Station { angular_rate: DVec3::Z, velocity: DVec3::ZERO, ..body };
    let ahead = 1e-6;
    let moved = a.carried_by(&spinning.carried(ahead)).position - a.carried_by(&spinning).position;
    assert!((moved / ahead - a.carried_by(&spinning).velocity).length() < 1e-5);
}
