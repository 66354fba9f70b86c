//! The pose message.

use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::layout::assert_layout;

/// Where a camera is and which way it looks, at one instant of the fixed step.
///
/// The body frame is the camera's IMU frame (x forward, y left, z up); the world frame is east,
/// north, up, one for all cameras ([`crate::World`]). A rigid body of several cameras publishes
/// its pose as a camera does, under its own name.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("lodestone.v2.Pose")]
pub struct Pose {
    /// Counts the poses of this lane from 0; a difference above 1 is what a consumer lost.
    pub sequence: u64,
    /// Index of the camera in the daemon's configuration; bodies count on after the cameras.
    pub camera_id: u32,
    /// Counts re-initialisations; poses on either side of a change do not share a history.
    pub reset_counter: u32,
    /// Bits of [`crate::Status`].
    pub status: u32,
    /// Bits of [`crate::Validity`].
    pub validity: u32,
    /// Code of [`crate::HeadingSource`].
    pub heading_source: u8,
    /// Code of [`crate::PositionSource`].
    pub position_source: u8,
    /// Bits of [`crate::AidFlags`]: what corrected the pose within the last second.
    pub aids_used: u8,
    /// Bits of [`crate::AidFlags`]: what was refused by its gate within the last second.
    pub aids_refused: u8,
    /// Epoch of the world, from 1, raised each time the world is defined anew: poses of different
    /// epochs do not compare. 0 while there is no world yet.
    pub world_epoch: u32,
    /// Time of validity in the sensor's own clock, ns.
    pub sensor_time_ns: i64,
    /// Time of validity on `CLOCK_MONOTONIC`, ns; never decreases within a lane.
    pub time_ns: i64,
    /// When the sample that completed this step arrived at the host, `CLOCK_MONOTONIC`, ns.
    pub arrival_time_ns: i64,
    /// When the driver put that sample into the ring, `CLOCK_MONOTONIC`, ns.
    pub ring_time_ns: i64,
    /// When the filter began this step, `CLOCK_MONOTONIC`, ns.
    pub step_start_time_ns: i64,
    /// When the filter ended this step, `CLOCK_MONOTONIC`, ns.
    pub step_end_time_ns: i64,
    /// When the message was handed to the transport, `CLOCK_MONOTONIC`, ns.
    pub published_time_ns: i64,
    /// Add to any `CLOCK_MONOTONIC` time here to get nanoseconds since the UNIX epoch.
    pub unix_offset_ns: i64,
    /// Body origin in the world, m; an infinite covariance declares that it is not known.
    pub position_m: [f64; 3],
    /// Velocity of the body origin in the world, m/s.
    pub velocity_m_s: [f64; 3],
    /// Rotation body to world, unit quaternion `x y z w`.
    pub orientation: [f64; 4],
    /// Angular rate of the body against the world, in the body frame, bias removed, rad/s.
    pub angular_rate_rad_s: [f64; 3],
    /// Specific force in the body frame, bias removed, m/s²; reads +9.81 upward at rest.
    pub specific_force_m_s2: [f64; 3],
    /// Covariance of the position in the world, m².
    pub position_covariance_m2: [f64; 6],
    /// Covariance of the velocity in the world, (m/s)².
    pub velocity_covariance_m2_s2: [f64; 6],
    /// Covariance of the orientation as a small rotation vector about the world axes, rad².
    pub orientation_covariance_rad2: [f64; 6],
}

assert_layout!(
    Pose,
    size = 368,
    sequence = 0,
    camera_id = 8,
    reset_counter = 12,
    status = 16,
    validity = 20,
    heading_source = 24,
    position_source = 25,
    aids_used = 26,
    aids_refused = 27,
    world_epoch = 28,
    sensor_time_ns = 32,
    time_ns = 40,
    arrival_time_ns = 48,
    ring_time_ns = 56,
    step_start_time_ns = 64,
    step_end_time_ns = 72,
    published_time_ns = 80,
    unix_offset_ns = 88,
    position_m = 96,
    velocity_m_s = 120,
    orientation = 144,
    angular_rate_rad_s = 176,
    specific_force_m_s2 = 200,
    position_covariance_m2 = 224,
    velocity_covariance_m2_s2 = 272,
    orientation_covariance_rad2 = 320,
);
