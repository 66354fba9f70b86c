//! The accelerometer.

use glam::DVec3;
use lodestone_config::model::{Noise, SensorErrors};

use super::Digital;
use super::inertial::{InertialErrors, InertialNoise, InertialStreams};
use super::quantiser::Quantiser;
use crate::driver::synthetic::random::Stream;

/// One count, m/s²: ±8 times 9.8189 m/s² over 16 bits (zed2-protocol.md, report 0x01, offset 16).
pub(super) const STEP_M_S2: f64 = 8.0 * 9.8189 / 32768.0;

/// A three-axis accelerometer in sensor axes.
#[derive(Clone, Debug)]
pub(crate) struct Accelerometer {
    errors: InertialErrors,
    quantiser: Quantiser,
}

impl Accelerometer {
    /// The accelerometer of these noise figures.
    pub(crate) fn new(noise: &Noise, errors: &SensorErrors, seed: u64, rate_hz: f64) -> Self {
        let inertial = InertialNoise {
            density: noise.accel_density_m_s2_rthz,
            walk: noise.accel_bias_walk_m_s3_rthz,
            bias_sigma: noise.accel_bias_sigma_m_s2,
            bias: errors.accel_bias_m_s2,
            temperature: DVec3::ZERO,
        };
        let streams = InertialStreams {
            bias: Stream::AccelBias,
            white: Stream::AccelWhite,
            walk: Stream::AccelWalk,
        };
        Self {
            errors: InertialErrors::new(&inertial, errors.noise_scale, streams, seed, rate_hz),
            quantiser: Quantiser::new(STEP_M_S2, errors.quantise),
        }
    }

    /// Reads a true specific force, m/s².
    pub(crate) fn read(&mut self, force: DVec3, temperature_c: f64) -> Digital {
        self.quantiser.read(self.errors.add(force, temperature_c))
    }
}
