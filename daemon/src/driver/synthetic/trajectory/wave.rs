//! Sums of sinusoids of a travelled distance (or another smooth quantity).

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

use crate::driver::synthetic::jet::Jet;

/// One sinusoid.
#[derive(Clone, Copy, Debug)]
struct Wave {
    amplitude: f64,
    /// rad per unit of the argument.
    number: f64,
    /// rad.
    phase: f64,
}

/// `Σ aᵢ sin(kᵢ x + φᵢ)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Waves<const N: usize>([Wave; N]);

impl<const N: usize> Waves<N> {
    /// Takes (amplitude, wavelength) pairs and draws the phases.
    pub(crate) fn drawn(parts: [(f64, f64); N], rng: &mut ChaCha8Rng) -> Self {
        Self(parts.map(|(amplitude, length)| Wave {
            amplitude,
            number: TAU / length,
            phase: rng.random_range(0.0..TAU),
        }))
    }

    /// Takes (amplitude, wavelength) pairs; all waves begin at zero, upward.
    pub(crate) fn in_phase(parts: [(f64, f64); N]) -> Self {
        Self(parts.map(|(amplitude, length)| Wave { amplitude, number: TAU / length, phase: 0.0 }))
    }

    /// The sum at `x`.
    pub(crate) fn at(&self, x: Jet) -> Jet {
        self.0
            .iter()
            .fold(Jet::default(), |sum, w| sum + (x * w.number + w.phase).sin() * w.amplitude)
    }

    /// The sum and its derivative by `x` at `x`.
    pub(crate) fn with_slope(&self, x: Jet) -> (Jet, Jet) {
        self.0.iter().fold((Jet::default(), Jet::default()), |(sum, slope), w| {
            let (sin, cos) = (x * w.number + w.phase).sin_cos();
            (sum + sin * w.amplitude, slope + cos * (w.amplitude * w.number))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand::SeedableRng;

    proptest! {
        #[test]
        fn the_slope_is_the_derivative(x in -50.0..50.0f64, seed: u64) {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let waves = Waves::drawn([(1.0, 3.0), (0.2, 0.7)], &mut rng);
            let (sum, slope) = waves.with_slope(Jet::new(x, 1.0, 0.0));
            prop_assert!((sum.first - slope.value).abs() < 1e-12);
            prop_assert!((sum.second - slope.first).abs() < 1e-9);
            prop_assert_eq!(sum, waves.at(Jet::new(x, 1.0, 0.0)));
        }
    }
}
