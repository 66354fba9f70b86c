//! The calibrated sensor sample message.

use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::layout::assert_layout;

/// One sensor reading in the body frame with the camera's calibration applied.
///
/// Filter estimates (biases) are not subtracted: this is what the filter was given.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("lodestone.v2.CalibratedSample")]
pub struct CalibratedSample {
    /// Counts the samples of this lane from 0.
    pub sequence: u64,
    /// Index of the camera in the daemon's configuration.
    pub camera_id: u32,
    /// Bits of [`crate::SampleFlags`].
    pub flags: u32,
    /// Time of the reading in the sensor's own clock, ns.
    pub sensor_time_ns: i64,
    /// Time of the reading on `CLOCK_MONOTONIC`, ns.
    pub time_ns: i64,
    /// When the reading arrived at the host, `CLOCK_MONOTONIC`, ns.
    pub arrival_time_ns: i64,
    /// Angular rate in the body frame, rad/s.
    pub angular_rate_rad_s: [f64; 3],
    /// Specific force in the body frame, m/s².
    pub specific_force_m_s2: [f64; 3],
    /// Magnetic flux density in the body frame, µT; `NaN` without [`crate::SampleFlags::MAGNETOMETER`].
    pub magnetic_field_ut: [f64; 3],
    /// Temperature of the IMU, °C; `NaN` without [`crate::SampleFlags::TEMPERATURE`].
    pub temperature_c: f64,
}

assert_layout!(
    CalibratedSample,
    size = 120,
    sequence = 0,
    camera_id = 8,
    flags = 12,
    sensor_time_ns = 16,
    time_ns = 24,
    arrival_time_ns = 32,
    angular_rate_rad_s = 40,
    specific_force_m_s2 = 64,
    magnetic_field_ut = 88,
    temperature_c = 112,
);
