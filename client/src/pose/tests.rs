use glam::DVec3;
use lodestone_schema::{Pose, Status, Validity};
use proptest::prelude::*;

use super::CameraPose;
use super::samples::{arbitrary, checked, quaternions, still};
use crate::error::MessageError;

/// Every number that the pose shows.
fn shown(pose: &CameraPose) -> Vec<f64> {
    let vectors = [
        pose.position_m(),
        pose.velocity_m_s(),
        pose.angular_rate_rad_s(),
        pose.specific_force_m_s2(),
    ];
    let matrices = [
        pose.position_covariance_m2(),
        pose.velocity_covariance_m2_s2(),
        pose.orientation_covariance_rad2(),
    ];
    let mut numbers: Vec<f64> = vectors.into_iter().flatten().flat_map(|v| v.to_array()).collect();
    numbers.extend(matrices.into_iter().flatten().flat_map(|m| m.to_cols_array()));
    numbers.extend(pose.orientation().iter().flat_map(|r| r.quaternion().to_array()));
    numbers.extend(pose.heading().iter().flat_map(|h| [h.yaw_rad, h.sigma_rad, h.compass_deg()]));
    numbers.extend(pose.position_sigma_m());
    numbers
}

/// Bytes as a hostile or broken publisher may leave them, over a good pose so that the checks
/// behind the first one are reached.
fn damaged() -> impl Strategy<Value = Pose> {
    (arbitrary(), any::<u16>(), any::<u32>()).prop_map(|(noise, which, validity)| {
        let mut pose = Pose { validity, ..still(3, 1_000) };
        let take = |bit: u16| which & (1 << bit) != 0;
        if take(0) {
            pose.position_m = noise.position_m;
        }
        if take(1) {
            pose.velocity_m_s = noise.velocity_m_s;
        }
        if take(2) {
            pose.orientation = noise.orientation;
        }
        if take(3) {
            pose.angular_rate_rad_s = noise.angular_rate_rad_s;
        }
        if take(4) {
            pose.specific_force_m_s2 = noise.specific_force_m_s2;
        }
        if take(5) {
            pose.position_covariance_m2 = noise.position_covariance_m2;
        }
        if take(6) {
            pose.velocity_covariance_m2_s2 = noise.velocity_covariance_m2_s2;
        }
        if take(7) {
            pose.orientation_covariance_rad2 = noise.orientation_covariance_rad2;
        }
        if take(8) {
            pose.status = noise.status;
        }
        if take(9) {
            pose.time_ns = noise.time_ns;
        }
        if take(10) {
            pose.unix_offset_ns = noise.unix_offset_ns;
        }
        pose
    })
}

proptest! {
    #[test]
    fn any_bytes_give_a_pose_or_an_error(message in prop_oneof![arbitrary(), damaged()]) {
        if let Ok(pose) = CameraPose::try_from(message) {
            for number in shown(&pose) {
                prop_assert!(number.is_finite(), "{number} in {pose:?}");
            }
            let _ = (pose.world_from_body(), pose.unix_time_ns(), pose.heading_source());
        }
    }

    #[test]
    fn whatever_passes_can_be_interpolated_and_predicted(
        a in damaged(), b in damaged(), time_ns in any::<i64>()
    ) {
        use crate::{interpolate::between, limits::PredictionNoise, predict::predict};
        if let (Ok(a), Ok(b)) = (CameraPose::try_from(a), CameraPose::try_from(b)) {
            let (a, b) = if a.time_ns() <= b.time_ns() { (a, b) } else { (b, a) };
            let soon = predict(&b, b.time_ns().saturating_add(50_000_000), &PredictionNoise::default());
            for pose in [between(&a, &b, time_ns), soon] {
                for number in shown(&pose) {
                    prop_assert!(number.is_finite(), "{number} in {pose:?}");
                }
            }
        }
    }

    #[test]
    fn orientation_is_the_rotation_body_to_world(q in quaternions()) {
        let pose = checked(Pose { orientation: q.to_array(), ..still(0, 0) });
        let forward = pose.orientation().unwrap().apply(DVec3::X);
        prop_assert!(forward.abs_diff_eq(q * DVec3::X, 1e-12));
        if let Some(heading) = pose.heading() {
            prop_assert!((heading.yaw_rad - forward.y.atan2(forward.x)).abs() < 1e-6);
        }
    }
}

#[test]
fn each_fault_is_named_by_its_field() {
    let refused = |message: Pose| CameraPose::try_from(message).unwrap_err().to_string();
    let good = still(0, 0);
    let nan = [f64::NAN, 0.0, 0.0];
    let faults = [
        (Pose { heading_source: 9, ..good }, "heading_source"),
        (Pose { position_source: 200, ..good }, "position_source"),
        (Pose { time_ns: -1, ..good }, "time_ns"),
        (Pose { position_m: nan, ..good }, "position_m"),
        (Pose { velocity_m_s: [f64::INFINITY; 3], ..good }, "velocity_m_s"),
        (Pose { angular_rate_rad_s: [1e300; 3], ..good }, "angular_rate_rad_s"),
        (Pose { specific_force_m_s2: nan, ..good }, "specific_force_m_s2"),
        (Pose { orientation: [0.0; 4], ..good }, "orientation"),
        (Pose { position_covariance_m2: [-1.0; 6], ..good }, "position_covariance_m2"),
    ];
    for (message, field) in faults {
        assert!(refused(message).contains(field), "{field}: {}", refused(message));
    }
    let long = Pose { orientation: [0.0, 0.0, 0.0, 1.001], ..good };
    assert_eq!(CameraPose::try_from(long), Err(MessageError::NotUnit { norm: 1.001 }));
}

#[test]
fn what_is_not_flagged_is_neither_checked_nor_shown() {
    let valid = Validity::TILT | Validity::TIME;
    let pose = checked(Pose {
        validity: valid.bits(),
        position_m: [f64::NAN; 3],
        position_covariance_m2: [f64::INFINITY; 6],
        orientation_covariance_rad2: [1e-6, 0.0, f64::NAN, 1e-6, f64::NAN, f64::INFINITY],
        ..still(0, 0)
    });
    assert!(pose.orientation().is_some());
    assert_eq!(pose.heading(), None);
    assert_eq!(pose.position_m(), None);
    assert_eq!(pose.orientation_covariance_rad2(), None);
    let missing = pose.world_from_body().unwrap_err();
    assert_eq!(missing.to_string(), "not valid: heading, position");
}

#[test]
fn there_is_no_heading_while_the_camera_looks_straight_up() {
    let status = (Status::INITIALISED | Status::GIMBAL_LOCK).bits();
    assert_eq!(checked(Pose { status, ..still(0, 0) }).heading(), None);
}
