//! The aiding message: what others know about a camera's motion.

use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::flags::code;
use crate::layout::assert_layout;

code! {
    /// What an aiding measurement says.
    AidingKind {
        /// Speed along the body's forward axis, m/s, in `value[0]`.
        ForwardSpeed = 1,
        /// Position of the body origin in the world, m.
        Position = 2,
        /// Position in the world, m, and orientation body to world.
        Pose = 3,
    }
}

/// A measurement that another process offers to a lane.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("lodestone.v1.Aiding")]
pub struct Aiding {
    /// Counts the measurements of this source from 0.
    pub sequence: u64,
    /// Index of the camera in the daemon's configuration.
    pub camera_id: u32,
    /// Code of [`AidingKind`].
    pub kind: u8,
    /// Zero.
    pub reserved: [u8; 3],
    /// Time of validity on `CLOCK_MONOTONIC`, ns.
    pub time_ns: i64,
    /// The measured value; which entries count and their unit follow from `kind`, others are `NaN`.
    pub value: [f64; 3],
    /// Rotation body to world, unit quaternion `x y z w`; `NaN` unless `kind` is a pose.
    pub orientation: [f64; 4],
    /// Covariance of `value` in its unit squared.
    pub value_covariance: [f64; 6],
    /// Covariance of `orientation` as a small rotation vector about the world axes, rad².
    pub orientation_covariance_rad2: [f64; 6],
}

assert_layout!(
    Aiding,
    size = 176,
    sequence = 0,
    camera_id = 8,
    kind = 12,
    reserved = 13,
    time_ns = 16,
    value = 24,
    orientation = 48,
    value_covariance = 80,
    orientation_covariance_rad2 = 128,
);
