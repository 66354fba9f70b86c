//! The world message: what all cameras share.

use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::flags::code;
use crate::layout::assert_layout;
use crate::name::NAME_BYTES;

code! {
    /// How far the world is.
    WorldState {
        /// No camera is aligned yet: there is no world.
        Waiting = 0,
        /// A camera of this run of the daemon has fixed it.
        Fixed = 1,
        /// It was fixed in an earlier run of the daemon and kept.
        Restored = 2,
    }
}

code! {
    /// Which north the world's y axis points to.
    NorthKind {
        /// That of the field at t0.
        Magnetic = 0,
        /// The pole's, by the declination.
        True = 1,
    }
}

/// The world frame `W`: x east, y north, z up, its origin at the magnetometer of the first camera
/// at t0. Published about once a second.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("lodestone.v2.World")]
pub struct World {
    /// Counts the world messages from 0.
    pub sequence: u64,
    /// When this message was made, `CLOCK_MONOTONIC`, ns.
    pub time_ns: i64,
    /// Add to any `CLOCK_MONOTONIC` time to get nanoseconds since the UNIX epoch.
    pub unix_offset_ns: i64,
    /// When the world was fixed, ns since the UNIX epoch; `i64::MIN` while it waits.
    pub t0_unix_ns: i64,
    /// Raised each time the world is defined anew, from 1; 0 while it waits.
    pub epoch: u32,
    /// Index of the camera that fixed it in the configuration; `u32::MAX` while it waits or when that
    /// camera is not in this configuration.
    pub first_camera_id: u32,
    /// Code of [`WorldState`].
    pub state: u8,
    /// Code of [`NorthKind`].
    pub north: u8,
    /// 1 if the world is kept for the next run of the daemon.
    pub kept: u8,
    /// Zero.
    pub reserved: [u8; 5],
    /// Name of the camera that fixed it; empty while it waits. See [`crate::name_of`].
    pub first_camera: [u8; NAME_BYTES],
    /// True north to magnetic north, clockwise positive, at the place and date, rad; `NaN` without a
    /// configured place.
    pub declination_rad: f64,
    /// Configured place, degrees north; `NaN` when unknown.
    pub latitude_deg: f64,
    /// Configured place, degrees east; `NaN` when unknown.
    pub longitude_deg: f64,
    /// Configured place, m above the ellipsoid; `NaN` when unknown.
    pub altitude_m: f64,
    /// Strength of the field at t0, µT; `NaN` when unknown.
    pub field_norm_ut: f64,
    /// Dip of the field at t0 below the horizon, rad; `NaN` when unknown.
    pub field_dip_rad: f64,
    /// Standard deviation of the first camera's heading at t0, rad; `NaN` while it waits.
    pub heading_sigma_rad: f64,
    /// Standard deviation of the first camera's tilt at t0 about the worse horizontal axis, rad; `NaN`
    /// while it waits.
    pub tilt_sigma_rad: f64,
    /// The first camera's rotation body to world at t0, `x y z w`; `NaN` while it waits.
    pub first_orientation: [f64; 4],
    /// The first camera's magnetometer in its body frame, m; `NaN` while it waits.
    pub magnetometer_position_m: [f64; 3],
}

assert_layout!(
    World,
    size = 232,
    sequence = 0,
    time_ns = 8,
    unix_offset_ns = 16,
    t0_unix_ns = 24,
    epoch = 32,
    first_camera_id = 36,
    state = 40,
    north = 41,
    kept = 42,
    reserved = 43,
    first_camera = 48,
    declination_rad = 112,
    latitude_deg = 120,
    longitude_deg = 128,
    altitude_m = 136,
    field_norm_ut = 144,
    field_dip_rad = 152,
    heading_sigma_rad = 160,
    tilt_sigma_rad = 168,
    first_orientation = 176,
    magnetometer_position_m = 208,
);
