//! The gyroscope.

use glam::DVec3;
use lodestone_config::model::{Noise, SensorErrors};

use super::Digital;
use super::inertial::{InertialErrors, InertialNoise, InertialStreams};
use super::quantiser::Quantiser;
use crate::driver::synthetic::random::Stream;

/// One count, rad/s: ±1000 °/s over 16 bits (zed2-protocol.md, report 0x01, offset 10).
pub(super) const STEP_RAD_S: f64 = 1000.0 / 32768.0 * std::f64::consts::PI / 180.0;

/// A three-axis gyroscope in sensor axes.
#[derive(Clone, Debug)]
pub(crate) struct Gyroscope {
    errors: InertialErrors,
    quantiser: Quantiser,
}

impl Gyroscope {
    /// The gyroscope of these noise figures.
    pub(crate) fn new(noise: &Noise, errors: &SensorErrors, seed: u64, rate_hz: f64) -> Self {
        let inertial = InertialNoise {
            density: noise.gyro_density_rad_s_rthz,
            walk: noise.gyro_bias_walk_rad_s2_rthz,
            bias_sigma: noise.gyro_bias_sigma_rad_s,
            bias: errors.gyro_bias_rad_s,
            temperature: DVec3::from_array(errors.gyro_temperature_rad_s_k),
        };
        let streams = InertialStreams {
            bias: Stream::GyroBias,
            white: Stream::GyroWhite,
            walk: Stream::GyroWalk,
        };
        Self {
            errors: InertialErrors::new(&inertial, errors.noise_scale, streams, seed, rate_hz),
            quantiser: Quantiser::new(STEP_RAD_S, errors.quantise),
        }
    }

    /// Reads a true angular rate against inertial space, rad/s.
    pub(crate) fn read(&mut self, rate: DVec3, temperature_c: f64) -> Digital {
        self.quantiser.read(self.errors.add(rate, temperature_c))
    }
}
