use glam::{DQuat, DVec3};
use lodestone_schema::{Pose, Validity};
use proptest::prelude::*;

use super::predict;
use crate::covariance::trace;
use crate::limits::PredictionNoise;
use crate::pose::samples::{checked, moving, still};
use crate::pose::{CameraPose, Origin};

const NOW_NS: i64 = 1_000_000_000;

fn ahead(pose: &CameraPose, ns: i64) -> CameraPose {
    predict(pose, pose.time_ns() + ns, &PredictionNoise::default())
}

#[test]
fn a_camera_at_rest_stays_where_it_is() {
    let pose = ahead(&checked(still(0, NOW_NS)), 50_000_000);
    assert!(pose.position_m().unwrap().abs_diff_eq(DVec3::ZERO, 1e-9));
    assert_eq!(pose.origin(), Origin::Predicted { ahead_ns: 50_000_000 });
}

#[test]
fn a_thrown_camera_falls() {
    let thrown =
        Pose { specific_force_m_s2: [0.0; 3], velocity_m_s: [2.0, 0.0, 1.0], ..still(0, NOW_NS) };
    let pose = ahead(&checked(thrown), 40_000_000);
    let expected = DVec3::new(0.08, 0.0, 0.04 - 9.806_65 * 0.0008);
    assert!(pose.position_m().unwrap().abs_diff_eq(expected, 1e-12));
    assert!((pose.velocity_m_s().unwrap().z - (1.0 - 9.806_65 * 0.04)).abs() < 1e-12);
}

#[test]
fn a_turning_camera_turns_on_in_its_own_frame() {
    let start = DQuat::from_rotation_x(0.3);
    let turning = Pose {
        orientation: start.to_array(),
        angular_rate_rad_s: [0.0, 0.0, 2.0],
        ..still(0, NOW_NS)
    };
    let found = ahead(&checked(turning), 50_000_000).orientation().unwrap().quaternion();
    assert!(found.abs_diff_eq(start * DQuat::from_rotation_z(0.1), 1e-12));
}

#[test]
fn what_cannot_be_predicted_is_not_valid() {
    let without = |flag: Validity| {
        let validity = Validity::all().difference(flag).bits();
        ahead(&checked(Pose { validity, ..still(0, NOW_NS) }), 1_000_000).validity()
    };
    let moved = Validity::POSITION | Validity::VELOCITY;
    assert!(!without(Validity::ANGULAR_RATE).intersects(Validity::TILT | Validity::HEADING));
    assert!(without(Validity::ANGULAR_RATE).contains(moved));
    assert!(!without(Validity::SPECIFIC_FORCE).intersects(moved));
    assert!(!without(Validity::VELOCITY).contains(Validity::POSITION));
    assert!(without(Validity::POSITION).contains(Validity::VELOCITY | Validity::TILT));
}

proptest! {
    #[test]
    fn sigma_never_shrinks(pose in moving(0, NOW_NS), near in 1..50_000_000_i64) {
        let further = near + 1_000_000;
        let (a, b) = (ahead(&pose, near), ahead(&pose, further));
        for of in [CameraPose::position_covariance_m2, CameraPose::velocity_covariance_m2_s2,
                   CameraPose::orientation_covariance_rad2] {
            let traces = [&pose, &a, &b].map(|p| trace(&of(p).unwrap()));
            prop_assert!(traces[0] < traces[1] && traces[1] < traces[2], "{traces:?}");
        }
    }

    #[test]
    fn sigma_covers_a_velocity_that_is_wrong_by_its_sigma(ns in 1..50_000_000_i64) {
        // Given position and velocity errors that are fully correlated, the worst case.
        let pose = checked(still(0, NOW_NS));
        let t = ns as f64 * 1e-9;
        let worst = 0.01 + t * 0.01;
        prop_assert!(ahead(&pose, ns).position_sigma_m().unwrap() >= worst * (1.0 - 1e-12));
    }

    #[test]
    fn prediction_begins_at_the_pose(pose in moving(0, NOW_NS)) {
        let soon = ahead(&pose, 1);
        prop_assert!(soon.position_m().unwrap().abs_diff_eq(pose.position_m().unwrap(), 1e-6));
        let turned = soon.orientation().unwrap().quaternion();
        prop_assert!(turned.dot(pose.orientation().unwrap().quaternion()).abs() > 1.0 - 1e-12);
        prop_assert_eq!(ahead(&pose, 0), pose);
    }
}
