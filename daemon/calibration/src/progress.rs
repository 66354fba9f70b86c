//! How far a calibration has come, for whoever moves the camera.

use crate::refusal::Missing;
use crate::settings::Limits;
use crate::{Coverage, Outcome, Refusal, Sample};

/// How far it has come.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// What was seen.
    pub coverage: Coverage,
    /// Expected heading σ by now, degrees; `None` while nothing could be fitted.
    pub heading_sigma_deg: Option<f64>,
    /// What is missing; empty once the recording would be accepted.
    pub missing: Vec<Missing>,
    /// How much of what is asked for is there, 0 to 1: that of the part which is furthest behind.
    pub ratio: f64,
}

impl Progress {
    /// Reads the progress off an attempt to calibrate. `goal_deg` is the heading σ that is aimed
    /// at, degrees.
    pub fn of(attempt: &Result<Outcome, Refusal>, limits: &Limits, goal_deg: f64) -> Self {
        let (coverage, heading_sigma_deg, missing) = match attempt {
            Ok(o) => (o.coverage, Some(o.magnetometer.heading_sigma_deg), Vec::new()),
            Err(r) => (r.coverage, r.heading_sigma_deg, r.missing.clone()),
        };
        let parts = [
            coverage.duration_s / limits.duration_s,
            coverage.circle_deg / limits.circle_deg,
            coverage.tilt_deg / limits.tilt_deg,
            heading_sigma_deg.map_or(0.0, |sigma| goal_deg / sigma.max(1e-6)),
        ];
        let ratio = parts.into_iter().fold(1.0, f64::min);
        Self { coverage, heading_sigma_deg, missing, ratio }
    }

    /// Whether the calibration is as good as it was meant to become.
    pub fn is_complete(&self) -> bool {
        self.missing.is_empty() && self.ratio >= 1.0
    }
}

/// Fewer samples for a quick look: means over groups, each of at most `group` samples and ending
/// with a reading of the magnetometer where one comes.
///
/// For guidance alone: within a group the sensors' times differ by up to its length.
pub fn thinned(samples: &[Sample], group: usize) -> Vec<Sample> {
    let mut thin = Vec::with_capacity(samples.len() / group.max(1) + 1);
    let mut start = 0;
    for (i, sample) in samples.iter().enumerate() {
        if i + 1 - start >= group || sample.mag_ut.is_some() {
            thin.push(mean(&samples[start..=i]));
            start = i + 1;
        }
    }
    thin
}

/// The last sample with the means of rate and force.
fn mean(group: &[Sample]) -> Sample {
    let part = (group.len() as f64).recip();
    Sample {
        gyro_rad_s: group.iter().map(|s| s.gyro_rad_s).sum::<glam::DVec3>() * part,
        accel_m_s2: group.iter().map(|s| s.accel_m_s2).sum::<glam::DVec3>() * part,
        ..group[group.len() - 1]
    }
}
