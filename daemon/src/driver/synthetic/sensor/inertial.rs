//! The errors gyroscope and accelerometer have in common.

use glam::DVec3;
use rand_chacha::ChaCha8Rng;

use super::REFERENCE_C;
use crate::driver::synthetic::random::{Stream, normal3};

/// How large the errors are, in the sensor's unit u.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InertialNoise {
    /// White noise density, u/√Hz.
    pub(crate) density: f64,
    /// Bias random walk, u/s/√Hz.
    pub(crate) walk: f64,
    /// Bias at switch-on, 1σ, u.
    pub(crate) bias_sigma: f64,
    /// The bias at 25 °C, u, where it is not drawn.
    pub(crate) bias: Option<[f64; 3]>,
    /// Bias per kelvin away from 25 °C, u/K.
    pub(crate) temperature: DVec3,
}

/// The streams of one sensor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InertialStreams {
    pub(crate) bias: Stream,
    pub(crate) white: Stream,
    pub(crate) walk: Stream,
}

/// Bias, its walk, its temperature slope, and white noise.
#[derive(Clone, Debug)]
pub(crate) struct InertialErrors {
    bias: DVec3,
    temperature: DVec3,
    white_sigma: f64,
    walk_sigma: f64,
    white: ChaCha8Rng,
    walk: ChaCha8Rng,
}

impl InertialErrors {
    /// Draws the errors of one sensor that is sampled at `rate_hz`.
    ///
    /// A sample of a sensor with noise density d that is band-limited to half its rate has the
    /// standard deviation d √rate; the bias walks by w/√rate a sample.
    pub(crate) fn new(
        noise: &InertialNoise,
        scale: f64,
        streams: InertialStreams,
        seed: u64,
        rate_hz: f64,
    ) -> Self {
        let drawn = normal3(&mut streams.bias.of(seed)) * (noise.bias_sigma * scale);
        Self {
            bias: noise.bias.map_or(drawn, DVec3::from_array),
            temperature: noise.temperature,
            white_sigma: noise.density * scale * rate_hz.sqrt(),
            walk_sigma: noise.walk * scale / rate_hz.sqrt(),
            white: streams.white.of(seed),
            walk: streams.walk.of(seed),
        }
    }

    /// Adds the errors of the next sample to a true value.
    pub(crate) fn add(&mut self, truth: DVec3, temperature_c: f64) -> DVec3 {
        let warm = self.temperature * (temperature_c - REFERENCE_C);
        let reading = truth + self.bias + warm + normal3(&mut self.white) * self.white_sigma;
        self.bias += normal3(&mut self.walk) * self.walk_sigma;
        reading
    }
}
