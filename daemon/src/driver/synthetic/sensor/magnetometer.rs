//! The magnetometer: it reads `S B + h + k (T − 25 °C)` with white and 1/f noise, every n-th sample.

use glam::{DMat3, DVec3};
use lodestone_config::model::{Noise, Synthetic};
use rand_chacha::ChaCha8Rng;

use super::flicker::Flicker;
use super::quantiser::Quantiser;
use super::{Digital, REFERENCE_C};
use crate::driver::synthetic::random::{Stream, normal3};

/// One count, µT (zed2-protocol.md, report 0x01, offset 31).
pub(super) const STEP_UT: f64 = 1.0 / 16.0;

/// A three-axis magnetometer in sensor axes.
#[derive(Clone, Debug)]
pub(crate) struct Magnetometer {
    soft_iron: DMat3,
    hard_iron: DVec3,
    temperature: DVec3,
    sigma: f64,
    noise: ChaCha8Rng,
    flicker: Flicker,
    quantiser: Quantiser,
    every: u32,
    /// Samples until the next reading.
    countdown: u32,
}

impl Magnetometer {
    /// The magnetometer of these noise figures and distortion, in a unit sampled at `rate_hz`.
    pub(crate) fn new(noise: &Noise, synthetic: &Synthetic, rate_hz: f64) -> Self {
        let (distortion, scale) = (&synthetic.distortion, synthetic.errors.noise_scale);
        let every = synthetic.transport.mag_every.max(1);
        let flicker = synthetic.errors.mag_flicker_ut_rthz * scale;
        Self {
            // Row by row in the configuration, column by column in glam.
            soft_iron: DMat3::from_cols_array_2d(&distortion.soft_iron).transpose(),
            hard_iron: DVec3::from_array(distortion.hard_iron_ut),
            temperature: DVec3::from_array(distortion.temperature_ut_k),
            sigma: noise.mag_sigma_ut * scale,
            noise: Stream::MagWhite.of(synthetic.seed),
            flicker: Flicker::new(flicker, f64::from(every) / rate_hz, synthetic.seed),
            quantiser: Quantiser::new(STEP_UT, synthetic.errors.quantise),
            every,
            countdown: 0,
        }
    }

    /// Reads a true field, µT, if this sample brings a reading.
    pub(crate) fn read(&mut self, field: DVec3, temperature_c: f64) -> Option<Digital> {
        if self.countdown > 0 {
            self.countdown -= 1;
            return None;
        }
        self.countdown = self.every - 1;
        let warm = self.temperature * (temperature_c - REFERENCE_C);
        let noise = normal3(&mut self.noise) * self.sigma + self.flicker.next();
        Some(self.quantiser.read(self.soft_iron * field + self.hard_iron + warm + noise))
    }
}
