use std::prelude::v1::*;

use glam::DQuat;

use super::*;
use crate::frame::Rotation;
use crate::time::SensorTime;

const ARM_M: DVec3 = DVec3::new(2.0, 1.0, 0.3);

/// A follower that has taken its anchor's error over, and whose own is small.
fn tied() -> Tied {
    Tied {
        anchor: 0,
        shares: [[DMat3::IDENTITY, DMat3::ZERO], [so3::skew(-ARM_M), DMat3::IDENTITY]],
        own: [DMat3::IDENTITY * 1e-6, DMat3::IDENTITY * 1e-5],
        anchor_covariance: [DMat3::IDENTITY * 4e-4, DMat3::IDENTITY * 0.01],
        mark: Drift::new(SensorTime::from_nanos(0)),
    }
}

fn assert_close(got: DMat3, expected: DMat3) {
    assert!(got.abs_diff_eq(expected, 1e-15), "{got} {expected}");
}

#[test]
fn what_both_err_by_does_not_part_them() {
    let apart = tied().apart(&Drifted::NOTHING, ARM_M);
    assert_close(apart.orientation, DMat3::IDENTITY * 1e-6);
    assert_close(apart.position, DMat3::IDENTITY * 1e-5);
}

#[test]
fn what_the_follower_has_unlearnt_and_the_anchor_has_drifted_parts_them() {
    // Given a follower whose heading is its own again by a half
    let mut tied = tied();
    tied.shares[0][0].z_axis.z = 0.5;
    let drifted = Drifted { orientation_rad2: DVec3::Z * 1e-5, position_m2: DVec3::X * 1e-4 };
    let apart = tied.apart(&drifted, ARM_M);
    let heading = 1e-6 + 0.25 * 4e-4 + 1e-5;
    assert!((apart.orientation.z_axis.z - heading).abs() < 1e-15);
    // The anchor's turn swings the follower that does not follow, about up: by x² + y² of the arm.
    let along =
        DVec3::new(apart.position.x_axis.x, apart.position.y_axis.y, apart.position.z_axis.z);
    let swung = DVec3::new(1.0, 4.0, 0.0) * 1e-5;
    assert!((along - DVec3::splat(1e-5) - DVec3::X * 1e-4 - swung).length() < 1e-15, "{along}");
}

#[test]
fn a_follower_that_went_on_errs_with_its_heading_as_one_body() {
    // Given a follower that has gone on by a metre with the anchor's heading error: M has followed
    let (mut tied, further) = (tied(), ARM_M + DVec3::Y);
    tied.shares[1][0] = so3::skew(-further);
    let apart = tied.apart(&Drifted::NOTHING, further);
    assert_close(apart.position, DMat3::IDENTITY * 1e-5);
}

#[test]
fn a_chain_adds_up_and_swings() {
    let link = Apart { orientation: DMat3::IDENTITY * 1e-6, position: DMat3::IDENTITY * 1e-5 };
    let both = link.then(&link, DVec3::X * 3.0);
    assert_close(both.orientation, DMat3::IDENTITY * 2e-6);
    let expected = DMat3::from_diagonal(DVec3::new(2e-5, 2e-5 + 9e-6, 2e-5 + 9e-6));
    assert_close(both.position, expected);
    assert_eq!(Apart::NOTHING.then(&link, DVec3::ZERO), link);
}

#[test]
fn either_may_be_the_anchor_and_nothing_gets_worse() {
    let station = |position: DVec3, sigma_rad: f64| Station {
        orientation: Rotation::from_unit(DQuat::IDENTITY),
        orientation_covariance: DMat3::IDENTITY * (sigma_rad * sigma_rad),
        angular_rate: DVec3::ZERO,
        position,
        position_covariance: DMat3::IDENTITY * 0.01,
        velocity: DVec3::ZERO,
        velocity_covariance: DMat3::ZERO,
        at_rest: true,
        field: super::super::FieldTie {
            with_orientation_rad2: DVec3::ZERO,
            variance_rad2: 0.0,
            prior_variance_rad2: 0.0,
            way_m: 1.0,
        },
    };
    let (a, b) = (station(DVec3::ZERO, 0.02), station(ARM_M, 0.02));
    let apart = tied().apart(&Drifted::NOTHING, ARM_M);
    let forth = relative_by(&a, &b, [&Apart::NOTHING, &apart]);
    assert_close(forth.orientation_covariance, apart.orientation);
    let distance = forth.distance.expect("both are known");
    assert_close(distance.covariance, apart.position);
    // Seen by the follower, its own rotation's error swings the anchor.
    let back = relative_by(&b, &a, [&apart, &Apart::NOTHING]);
    let turned = mapped(so3::skew(ARM_M), apart.orientation);
    let expected = apart.position + turned;
    assert_close(back.distance.expect("both are known").covariance, expected);
    // A tie that says less than both places in the world do is left aside.
    let vague = Apart { orientation: DMat3::IDENTITY, position: DMat3::IDENTITY * 100.0 };
    assert_eq!(relative_by(&a, &b, [&Apart::NOTHING, &vague]), relative(&a, &b));
}
