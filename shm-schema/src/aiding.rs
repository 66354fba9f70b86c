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
        /// Position in the world, m, of the point at `lever_arm_m`.
        Position = 2,
        /// Position in the world, m, of the point at `lever_arm_m`, and orientation body to world.
        Pose = 3,
        /// Velocity in the world, m/s, of the point at `lever_arm_m`.
        Velocity = 4,
    }
}

code! {
    /// What an aiding measurement was made with.
    AidingOrigin {
        /// Something else.
        Other = 0,
        /// Wheels.
        Odometry = 1,
        /// Satellites.
        Gnss = 2,
        /// Images.
        VisualOdometry = 3,
        /// Two clouds laid over each other.
        CloudRegistration = 4,
    }
}

/// A measurement that another process offers to a lane.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("lodestone.v2.Aiding")]
pub struct Aiding {
    /// Counts the measurements of this source from 0.
    pub sequence: u64,
    /// Index of the camera in the daemon's configuration.
    pub camera_id: u32,
    /// Epoch of the world in which position and orientation are given; 0 for any.
    pub world_epoch: u32,
    /// Code of [`AidingKind`].
    pub kind: u8,
    /// Code of [`AidingOrigin`].
    pub origin: u8,
    /// Index of the camera against which a pose was measured, plus one; 0 for none.
    ///
    /// Position and orientation are then in the world by that camera's pose as it was published for
    /// `time_ns`, and both covariances are those of the measurement against it alone. The daemon takes the
    /// pose over, and puts the other camera's own covariance on top.
    pub anchor: u16,
    /// Zero.
    pub reserved: [u8; 4],
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
    /// The point that was measured (antenna, axle), from the body origin in the body frame, m.
    pub lever_arm_m: [f64; 3],
}

assert_layout!(
    Aiding,
    size = 208,
    sequence = 0,
    camera_id = 8,
    world_epoch = 12,
    kind = 16,
    origin = 17,
    anchor = 18,
    reserved = 20,
    time_ns = 24,
    value = 32,
    orientation = 56,
    value_covariance = 88,
    orientation_covariance_rad2 = 136,
    lever_arm_m = 184,
);
