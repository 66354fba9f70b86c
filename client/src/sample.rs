//! A calibrated sensor sample, checked.

use core::time::Duration;

use glam::DVec3;
use lodestone_schema::{CalibratedSample, SampleFlags, ServiceKind};

use crate::error::MessageError;
use crate::message::Message;

/// Beyond any sensor's range.
const LIMIT: f64 = 1e9;

/// One sensor reading in the body frame, calibrated; what is unknown is `None`.
///
/// ```
/// use lodestone_client::{CalibratedSample, MessageError, Sample};
///
/// fn receive(message: CalibratedSample) -> Result<(), MessageError> {
///     let sample = Sample::try_from(message)?;
///     if let Some(field) = sample.magnetic_field_ut() {
///         println!("{} µT", field.length());
///     }
///     Ok(())
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    message: CalibratedSample,
}

impl TryFrom<CalibratedSample> for Sample {
    type Error = MessageError;

    fn try_from(message: CalibratedSample) -> Result<Self, MessageError> {
        let sample = Self { message };
        finite("angular_rate_rad_s", &message.angular_rate_rad_s)?;
        finite("specific_force_m_s2", &message.specific_force_m_s2)?;
        if sample.flags().contains(SampleFlags::MAGNETOMETER) {
            finite("magnetic_field_ut", &message.magnetic_field_ut)?;
        }
        if sample.flags().contains(SampleFlags::TEMPERATURE) {
            finite("temperature_c", &[message.temperature_c])?;
        }
        Ok(sample)
    }
}

fn finite(field: &'static str, values: &[f64]) -> Result<(), MessageError> {
    match values.iter().copied().find(|v| v.is_nan() || v.abs() > LIMIT) {
        Some(value) => Err(MessageError::OutOfRange { field, value, limit: LIMIT }),
        None => Ok(()),
    }
}

impl Message for Sample {
    type Raw = CalibratedSample;
    const KIND: ServiceKind = ServiceKind::Sample;
    const SILENCE: Duration = Duration::from_secs(1);

    fn sequence(raw: &CalibratedSample) -> u64 {
        raw.sequence
    }

    fn time_ns(raw: &CalibratedSample) -> i64 {
        raw.time_ns
    }
}

impl Sample {
    /// The message, with all times.
    pub const fn message(&self) -> &CalibratedSample {
        &self.message
    }

    /// Which fields are new.
    pub const fn flags(&self) -> SampleFlags {
        SampleFlags::from_bits_truncate(self.message.flags)
    }

    /// Time of the reading on `CLOCK_MONOTONIC`, ns.
    pub const fn time_ns(&self) -> i64 {
        self.message.time_ns
    }

    /// Angular rate in the body frame, rad/s.
    pub const fn angular_rate_rad_s(&self) -> DVec3 {
        DVec3::from_array(self.message.angular_rate_rad_s)
    }

    /// Specific force in the body frame, m/s².
    pub const fn specific_force_m_s2(&self) -> DVec3 {
        DVec3::from_array(self.message.specific_force_m_s2)
    }

    /// Magnetic flux density in the body frame, µT, if a reading came with this sample.
    pub fn magnetic_field_ut(&self) -> Option<DVec3> {
        let came = self.flags().contains(SampleFlags::MAGNETOMETER);
        came.then(|| DVec3::from_array(self.message.magnetic_field_ut))
    }

    /// Temperature of the IMU, °C.
    pub fn temperature_c(&self) -> Option<f64> {
        self.flags().contains(SampleFlags::TEMPERATURE).then_some(self.message.temperature_c)
    }
}
