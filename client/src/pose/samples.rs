//! Poses for the tests of this crate.

use glam::{DQuat, DVec3};
use lodestone_schema::{Pose, Status, Validity};
use proptest::prelude::*;

use super::CameraPose;

/// Identity covariance.
pub(crate) const UNIT: [f64; 6] = [1.0, 0.0, 0.0, 1.0, 0.0, 1.0];

/// A pose at rest at the origin with everything known; UNIX time is a million seconds ahead.
pub(crate) fn still(sequence: u64, time_ns: i64) -> Pose {
    Pose {
        sequence,
        camera_id: 0,
        reset_counter: 0,
        status: Status::INITIALISED.bits(),
        validity: Validity::all().bits(),
        heading_source: 1,
        position_source: 1,
        aids_used: 0,
        aids_refused: 0,
        world_epoch: 1,
        sensor_time_ns: time_ns,
        time_ns,
        arrival_time_ns: time_ns,
        ring_time_ns: time_ns,
        step_start_time_ns: time_ns,
        step_end_time_ns: time_ns,
        published_time_ns: time_ns,
        unix_offset_ns: 1_000_000_000_000_000,
        position_m: [0.0; 3],
        velocity_m_s: [0.0; 3],
        orientation: [0.0, 0.0, 0.0, 1.0],
        angular_rate_rad_s: [0.0; 3],
        specific_force_m_s2: [0.0, 0.0, 9.806_65],
        position_covariance_m2: [1e-4, 0.0, 0.0, 1e-4, 0.0, 1e-4],
        velocity_covariance_m2_s2: [1e-4, 0.0, 0.0, 1e-4, 0.0, 1e-4],
        orientation_covariance_rad2: [1e-6, 0.0, 0.0, 1e-6, 0.0, 1e-4],
    }
}

pub(crate) fn checked(message: Pose) -> CameraPose {
    CameraPose::try_from(message).expect("a good pose")
}

pub(crate) fn quaternions() -> impl Strategy<Value = DQuat> {
    prop::array::uniform4(-1.0..1.0_f64)
        .prop_map(DQuat::from_array)
        .prop_filter("has a direction", |q| q.length() > 1e-3)
        .prop_map(DQuat::normalize)
}

pub(crate) fn vectors(limit: f64) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-limit..limit).prop_map(DVec3::from_array)
}

prop_compose! {
    /// A moving, turning camera at a time.
    pub(crate) fn moving(sequence: u64, time_ns: i64)(
        q in quaternions(), p in vectors(100.0), v in vectors(20.0), w in vectors(5.0),
        f in vectors(20.0), s in 0.0..2.0_f64,
    ) -> CameraPose {
        checked(Pose {
            orientation: q.to_array(),
            position_m: p.to_array(),
            velocity_m_s: v.to_array(),
            angular_rate_rad_s: w.to_array(),
            specific_force_m_s2: f.to_array(),
            position_covariance_m2: UNIT.map(|u| u * s),
            ..still(sequence, time_ns)
        })
    }
}

prop_compose! {
    /// Any numbers at all in every field.
    pub(crate) fn arbitrary()(
        head in any::<(u64, u32, u32, u32, u32, u8, u8)>(),
        times in any::<[i64; 8]>(),
        vectors in any::<[[u64; 3]; 4]>(),
        quaternion in any::<[u64; 4]>(),
        triangles in any::<[[u64; 6]; 3]>(),
    ) -> Pose {
        let (sequence, camera_id, reset_counter, status, validity, heading, position) = head;
        Pose {
            sequence, camera_id, reset_counter, status, validity,
            heading_source: heading, position_source: position, aids_used: 0, aids_refused: 0,
            world_epoch: 1,
            sensor_time_ns: times[0], time_ns: times[1], arrival_time_ns: times[2],
            ring_time_ns: times[7], step_start_time_ns: times[3], step_end_time_ns: times[4],
            published_time_ns: times[5], unix_offset_ns: times[6],
            position_m: vectors[0].map(f64::from_bits),
            velocity_m_s: vectors[1].map(f64::from_bits),
            orientation: quaternion.map(f64::from_bits),
            angular_rate_rad_s: vectors[2].map(f64::from_bits),
            specific_force_m_s2: vectors[3].map(f64::from_bits),
            position_covariance_m2: triangles[0].map(f64::from_bits),
            velocity_covariance_m2_s2: triangles[1].map(f64::from_bits),
            orientation_covariance_rad2: triangles[2].map(f64::from_bits),
        }
    }
}
