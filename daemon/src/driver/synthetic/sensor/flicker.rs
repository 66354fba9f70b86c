//! 1/f noise (flicker).

use glam::DVec3;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::LN_2;

use crate::driver::synthetic::random::{Stream, normal3};

/// Octaves of time constants: from one interval to some three hours of a 50 Hz sensor.
const OCTAVES: usize = 20;

/// 1/f noise on three axes, as a sum of Gauss-Markov processes of equal variance whose time
/// constants are an octave apart (van der Ziel, Physica 16, 1950; Milotti, arXiv:physics/0204033).
///
/// One with variance s² and time constant τ has the one-sided density 4 s² τ / (1 + (2πfτ)²). The
/// sum over τ = τ₀ 2ᵏ is s² / (f ln 2), within 2 % between the ends of the range.
#[derive(Clone, Debug)]
pub(crate) struct Flicker {
    processes: [GaussMarkov; OCTAVES],
    sigma: f64,
    rng: ChaCha8Rng,
    started: bool,
}

/// One process, of unit variance.
#[derive(Clone, Copy, Debug, Default)]
struct GaussMarkov {
    /// Correlation from one sample to the next.
    keep: f64,
    /// √(1 − keep²).
    renew: f64,
    value: DVec3,
}

impl Flicker {
    /// Noise of the density `density_1hz` at 1 Hz, in u/√Hz, sampled every `interval_s`.
    pub(crate) fn new(density_1hz: f64, interval_s: f64, seed: u64) -> Self {
        let mut time_constant_s = 0.5 * interval_s;
        let processes = [(); OCTAVES].map(|()| {
            time_constant_s *= 2.0;
            let keep = (-interval_s / time_constant_s).exp();
            GaussMarkov { keep, renew: (1.0 - keep * keep).sqrt(), value: DVec3::ZERO }
        });
        let sigma = density_1hz * LN_2.sqrt();
        Self { processes, sigma, rng: Stream::MagFlicker.of(seed), started: false }
    }

    /// The noise of the next sample, in u.
    pub(crate) fn next(&mut self) -> DVec3 {
        if self.sigma == 0.0 {
            return DVec3::ZERO;
        }
        let begins = !std::mem::replace(&mut self.started, true);
        let mut sum = DVec3::ZERO;
        for process in &mut self.processes {
            let drawn = normal3(&mut self.rng);
            // Stationary from the first sample on.
            process.value =
                if begins { drawn } else { process.value * process.keep + drawn * process.renew };
            sum += process.value;
        }
        sum * self.sigma
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const INTERVAL_S: f64 = 0.02;
    const DENSITY: f64 = 0.3;

    /// One-sided density about `hz`, averaged over blocks: each the square of one Fourier component
    /// under a Hann window.
    fn density_squared(noise: &[f64], hz: f64) -> f64 {
        let length = (16.0 / (hz * INTERVAL_S)).round() as usize;
        let power = |block: &[f64]| {
            let (mut re, mut im, mut window_power) = (0.0, 0.0, 0.0);
            for (k, x) in block.iter().enumerate() {
                let part = k as f64 / length as f64;
                let window = 0.5 - 0.5 * (TAU * part).cos();
                let (sin, cos) = (TAU * 16.0 * part).sin_cos();
                re += window * x * cos;
                im += window * x * sin;
                window_power += window * window;
            }
            2.0 * INTERVAL_S * (re * re + im * im) / window_power
        };
        let blocks = noise.chunks_exact(length);
        let count = blocks.len() as f64;
        blocks.map(power).sum::<f64>() / count
    }

    #[test]
    fn the_density_falls_as_one_over_f_from_its_value_at_1_hz() {
        let mut flicker = Flicker::new(DENSITY, INTERVAL_S, 3);
        let noise: Vec<DVec3> = (0..400_000).map(|_| flicker.next()).collect();
        for hz in [0.02, 0.1, 0.5, 1.0, 3.0] {
            let axes = [0, 1, 2].map(|axis| {
                let one: Vec<f64> = noise.iter().map(|b| b[axis]).collect();
                density_squared(&one, hz)
            });
            let ratio = axes.iter().sum::<f64>() / 3.0 * hz / (DENSITY * DENSITY);
            // The fewest blocks, at 0.02 Hz, are 10 of 3 axes: 1σ of 18 %.
            assert!((0.55..1.55).contains(&ratio), "{ratio} at {hz} Hz");
        }
        let slope = |a: f64, b: f64| {
            let axis: Vec<f64> = noise.iter().map(|n| n.x).collect();
            (density_squared(&axis, b) / density_squared(&axis, a)).ln() / (b / a).ln()
        };
        let slope = slope(0.1, 3.0);
        assert!((slope + 1.0).abs() < 0.12, "the density's slope is {slope}, not -1");
    }

    #[test]
    fn it_is_stationary_from_the_start() {
        let rms = |at: usize| {
            let squares = (0..600).map(|seed| {
                let mut flicker = Flicker::new(DENSITY, INTERVAL_S, seed);
                for _ in 0..at {
                    flicker.next();
                }
                flicker.next().length_squared() / 3.0
            });
            (squares.sum::<f64>() / 600.0).sqrt()
        };
        let expected = DENSITY * (LN_2 * OCTAVES as f64).sqrt();
        for at in [0, 200] {
            assert!((rms(at) / expected - 1.0).abs() < 0.07, "{} at {at}", rms(at));
        }
    }

    #[test]
    fn without_density_there_is_none() {
        assert_eq!(Flicker::new(0.0, INTERVAL_S, 1).next(), DVec3::ZERO);
    }
}
