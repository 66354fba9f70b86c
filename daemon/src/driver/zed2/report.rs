//! One report in physical units.
//!
//! Scales: zed-open-capture, `include/sensorcapture_def.hpp:24-35`.

use std::fmt;

use glam::DVec3;
use lodestone_fusion::{Accel, Gyro, Mag, Sensor, SensorTime};

use super::raw::{RawReport, USED_LEN};

/// Structure id of a ZED 2 and 2i.
pub const STRUCT_ID: u8 = 1;

const GYRO_RAD_S: f64 = 1000.0 / 32768.0 * std::f64::consts::PI / 180.0;
const ACCEL_M_S2: f64 = 8.0 * 9.8189 / 32768.0;
const MAG_UT: f64 = 1.0 / 16.0;

/// Absolute zero in the device's unit: how it says that a temperature is not known.
const NO_TEMPERATURE: i16 = -27315;

/// Version of the camera's sensor firmware, `bcdDevice`: 0x0309 is 3.9.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Firmware(pub u16);

impl Firmware {
    /// The first version with fine pressure and humidity units.
    pub const FINE_ENVIRONMENT: Self = Self(0x0309);
}

impl fmt::Display for Firmware {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{:x}.{:x}", self.0 >> 8, self.0 & 0xff)
    }
}

/// Why bytes are no report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReportError {
    /// Fewer bytes than the fields need.
    #[error("report of {found} bytes; at least {USED_LEN} are needed")]
    TooShort {
        /// Bytes there were.
        found: usize,
    },
    /// Another structure than the ZED 2's.
    #[error("report structure {found}; a ZED 2 or 2i sends {STRUCT_ID} (a ZED Mini 0)")]
    StructId {
        /// The id there was.
        found: u8,
    },
    /// A time stamp that nanoseconds in 63 bits cannot hold (292 years).
    #[error("time stamp of {ticks} ticks is out of range")]
    TimeOutOfRange {
        /// The ticks there were.
        ticks: u64,
    },
}

/// A value with what the device says of its age.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aged<T> {
    /// There is none, or its age is given by a code this driver does not know.
    Absent,
    /// Repeated from an earlier report.
    Old(T),
    /// Measured since the last report.
    New(T),
}

impl<T> Aged<T> {
    fn from_code(code: u8, value: T) -> Self {
        match code {
            1 => Self::Old(value),
            2 => Self::New(value),
            _ => Self::Absent,
        }
    }

    /// The value if it was measured since the last report.
    pub fn fresh(self) -> Option<T> {
        match self {
            Self::New(value) => Some(value),
            Self::Absent | Self::Old(_) => None,
        }
    }
}

/// Something the firmware notices and counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Event {
    /// Whether it is so in this sample.
    pub now: bool,
    /// Times it was so since the camera was switched on.
    pub count: u32,
}

impl Event {
    const fn from_raw(now: u8, count: u32) -> Self {
        Self { now: now != 0, count }
    }
}

/// Air around the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Environment {
    /// Temperature, °C; `None` where the device knows none.
    pub temperature_c: Option<f32>,
    /// Air pressure, Pa; `None` where the firmware, which fixes the unit, is not known.
    pub pressure_pa: Option<f64>,
    /// Relative humidity, %; `None` where the firmware is not known.
    pub humidity_percent: Option<f64>,
}

/// One report with everything it says, in sensor axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// When the sample was taken: ticks·78125/2 ns.
    pub sensor_time: SensorTime,
    /// Whether gyroscope and accelerometer are valid.
    pub imu_valid: bool,
    /// Angular rate.
    pub gyro: Gyro<Sensor>,
    /// Specific force.
    pub accel: Accel<Sensor>,
    /// At least one axis of gyroscope, accelerometer or a new magnetometer reading is at the end
    /// of its range.
    pub saturated: bool,
    /// Images: whether this sample coincides with one, and how many there were.
    pub frame_sync: Event,
    /// What the firmware can synchronise, as sent.
    pub sync_capabilities: u8,
    /// Temperature of the IMU, °C.
    pub imu_temperature_c: Option<f32>,
    /// Magnetic field.
    pub mag: Aged<Mag<Sensor>>,
    /// The firmware sees the camera move.
    pub moving: Event,
    /// The firmware sees the camera fall.
    pub falling: Event,
    /// Air around the camera.
    pub environment: Aged<Environment>,
    /// Temperature of the left and the right image sensor, °C.
    pub image_temperature_c: [Option<f32>; 2],
}

impl Report {
    /// Reads a report. Any bytes give a report or an error.
    ///
    /// `firmware` decides the units of pressure and humidity; without it both are absent.
    ///
    /// # Errors
    ///
    /// Too few bytes, another structure, or a time stamp beyond what can be held.
    pub fn parse(bytes: &[u8], firmware: Option<Firmware>) -> Result<Self, ReportError> {
        Self::from_raw(&RawReport::parse(bytes)?, firmware)
    }

    /// Gives a raw report its meaning.
    ///
    /// # Errors
    ///
    /// Another structure, or a time stamp beyond what can be held.
    pub fn from_raw(raw: &RawReport, firmware: Option<Firmware>) -> Result<Self, ReportError> {
        if raw.struct_id != STRUCT_ID {
            return Err(ReportError::StructId { found: raw.struct_id });
        }
        let mag = Aged::from_code(raw.mag_valid, Mag::new(scaled(raw.mag, MAG_UT)));
        let mag_saturated = mag.fresh().is_some() && saturated(raw.mag);
        Ok(Self {
            sensor_time: sensor_time(raw.ticks)?,
            // zed-open-capture takes any other value for valid, too.
            imu_valid: raw.imu_not_valid != 1,
            gyro: Gyro::new(scaled(raw.gyro, GYRO_RAD_S)),
            accel: Accel::new(scaled(raw.accel, ACCEL_M_S2)),
            saturated: saturated(raw.gyro) || saturated(raw.accel) || mag_saturated,
            frame_sync: Event::from_raw(raw.frame_sync, raw.frame_sync_count),
            sync_capabilities: raw.sync_capabilities,
            imu_temperature_c: temperature_c(raw.imu_temperature),
            mag,
            moving: Event::from_raw(raw.moving, raw.moving_count),
            falling: Event::from_raw(raw.falling, raw.falling_count),
            environment: Aged::from_code(raw.env_valid, environment(raw, firmware)),
            image_temperature_c: raw.image_temperature.map(temperature_c),
        })
    }
}

/// ticks·78125/2 ns; 39.0625 µs is no whole number of ns, so an odd count is rounded down.
fn sensor_time(ticks: u64) -> Result<SensorTime, ReportError> {
    let nanos = u128::from(ticks) * 78_125 / 2;
    let nanos = i64::try_from(nanos).map_err(|_| ReportError::TimeOutOfRange { ticks })?;
    Ok(SensorTime::from_nanos(nanos))
}

fn scaled(raw: [i16; 3], unit: f64) -> DVec3 {
    DVec3::from_array(raw.map(|axis| f64::from(axis) * unit))
}

/// Whether any axis is at an end of the converter's range.
fn saturated(raw: [i16; 3]) -> bool {
    raw.iter().any(|axis| axis.unsigned_abs() >= 32767)
}

fn temperature_c(raw: i16) -> Option<f32> {
    (raw > NO_TEMPERATURE).then(|| f32::from(raw) * 0.01)
}

fn environment(raw: &RawReport, firmware: Option<Firmware>) -> Environment {
    let units = firmware.map(|version| {
        if version >= Firmware::FINE_ENVIRONMENT { (0.01, 0.01) } else { (1.0, 1.0 / 1024.0) }
    });
    Environment {
        temperature_c: temperature_c(raw.temperature),
        pressure_pa: units.map(|(pascal, _)| f64::from(raw.pressure) * pascal),
        humidity_percent: units.map(|(_, percent)| f64::from(raw.humidity) * percent),
    }
}

#[cfg(test)]
#[path = "report_tests.rs"]
mod tests;
