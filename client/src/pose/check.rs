//! What a pose message must satisfy.

use glam::DQuat;
use lodestone_schema::{HeadingSource, Pose, PositionSource, Validity};

use crate::error::MessageError;

/// Beyond any position, velocity, rate or force on earth, and far from overflow when squared.
const LIMIT: f64 = 1e9;
/// A unit quaternion that went through f64 arithmetic is much closer to one than this.
const NORM_TOLERANCE: f64 = 1e-6;

/// Checks the codes, and every field whose flag says that it is usable.
pub(super) fn pose(m: &Pose) -> Result<(), MessageError> {
    codes(m)?;
    if m.time_ns < 0 {
        return Err(MessageError::NegativeTime { field: "time_ns", value_ns: m.time_ns });
    }
    let valid = Validity::from_bits_truncate(m.validity);
    if valid.contains(Validity::TILT) {
        orientation(m, valid.contains(Validity::HEADING))?;
    }
    if valid.contains(Validity::VELOCITY) {
        finite("velocity_m_s", &m.velocity_m_s, LIMIT)?;
        covariance("velocity_covariance_m2_s2", &m.velocity_covariance_m2_s2)?;
    }
    if valid.contains(Validity::POSITION) {
        finite("position_m", &m.position_m, LIMIT)?;
        covariance("position_covariance_m2", &m.position_covariance_m2)?;
    }
    if valid.contains(Validity::ANGULAR_RATE) {
        finite("angular_rate_rad_s", &m.angular_rate_rad_s, LIMIT)?;
    }
    if valid.contains(Validity::SPECIFIC_FORCE) {
        finite("specific_force_m_s2", &m.specific_force_m_s2, LIMIT)?;
    }
    Ok(())
}

fn codes(m: &Pose) -> Result<(), MessageError> {
    let unknown = |field, code| MessageError::UnknownCode { field, code };
    HeadingSource::from_code(m.heading_source)
        .ok_or_else(|| unknown("heading_source", m.heading_source))?;
    PositionSource::from_code(m.position_source)
        .ok_or_else(|| unknown("position_source", m.position_source))?;
    Ok(())
}

/// Without a heading, the variance about up may be unbounded: only the tilt block is checked.
fn orientation(m: &Pose, with_heading: bool) -> Result<(), MessageError> {
    finite("orientation", &m.orientation, LIMIT)?;
    let norm = DQuat::from_array(m.orientation).length();
    if (norm - 1.0).abs() > NORM_TOLERANCE {
        return Err(MessageError::NotUnit { norm });
    }
    let all = &m.orientation_covariance_rad2;
    if with_heading {
        return covariance("orientation_covariance_rad2", all);
    }
    let tilt = [all[0], all[1], 0.0, all[3], 0.0, 0.0];
    covariance("orientation_covariance_rad2", &tilt)
}

fn covariance(field: &'static str, triangle: &[f64; 6]) -> Result<(), MessageError> {
    finite(field, triangle, LIMIT * LIMIT)?;
    let variances = [triangle[0], triangle[3], triangle[5]];
    match variances.into_iter().find(|v| *v < 0.0) {
        Some(value) => Err(MessageError::NegativeVariance { field, value }),
        None => Ok(()),
    }
}

fn finite(field: &'static str, values: &[f64], limit: f64) -> Result<(), MessageError> {
    match values.iter().copied().find(|v| v.is_nan() || v.abs() > limit) {
        Some(value) => Err(MessageError::OutOfRange { field, value, limit }),
        None => Ok(()),
    }
}
