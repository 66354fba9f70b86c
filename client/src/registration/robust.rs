//! How much a residual counts.

use super::matches::Match;

/// Tukey's biweight: residuals count less the larger they are, and not at all beyond 4.685 scales
/// (Beaton and Tukey 1974); 95 % efficient on Gaussian noise.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tukey {
    cut: f64,
}

impl Tukey {
    const CUT: f64 = 4.685;
    /// A normal distribution's standard deviation over its median absolute deviation.
    const SIGMA_PER_MAD: f64 = 1.4826;

    /// Takes the scale from the residuals themselves: as the clouds come together it shrinks, and what
    /// does not belong to the target drops out. It goes no lower than `smallest`.
    pub(super) fn of(residuals: impl Iterator<Item = f64>, smallest: f64) -> Self {
        let mut sizes: Vec<f64> = residuals.map(f64::abs).collect();
        if sizes.is_empty() {
            return Self { cut: Self::CUT };
        }
        let middle = sizes.len() / 2;
        let median = *sizes.select_nth_unstable_by(middle, f64::total_cmp).1;
        Self { cut: Self::CUT * (median * Self::SIGMA_PER_MAD).max(smallest) }
    }

    /// `ψ(r) / r`, 1 at zero.
    pub(super) fn weight(self, residual: f64) -> f64 {
        let inside = 1.0 - (residual / self.cut).powi(2);
        if inside > 0.0 { inside * inside } else { 0.0 }
    }

    /// `dψ/dr`.
    fn slope(self, residual: f64) -> f64 {
        let square = (residual / self.cut).powi(2);
        if square < 1.0 { (1.0 - square) * (1.0 - 5.0 * square) } else { 0.0 }
    }

    /// Factor by which the covariance of the estimate is larger than the inverse of the weighted normal
    /// matrix: `Σψ² Σw / (Σψ')²`, which is the residuals' variance for plain least squares (Huber 1981,
    /// "Robust Statistics", 7.6).
    pub(super) fn dispersion(self, residuals: impl Iterator<Item = f64>) -> f64 {
        let (mut weights, mut squares, mut slopes) = (0.0, 0.0, 0.0);
        for residual in residuals {
            let weight = self.weight(residual);
            weights += weight;
            squares += (weight * residual).powi(2);
            slopes += self.slope(residual);
        }
        squares * weights / slopes.max(1e-3 * weights).powi(2)
    }
}

/// Residuals as they will be after a step.
pub(super) fn after(matches: &[Match], step: &nalgebra::Vector6<f64>) -> Vec<f64> {
    matches.iter().map(|m| m.residual + m.jacobian.dot(step)).collect()
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    fn normal(count: usize) -> Vec<f64> {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        (0..count).map(|_| StandardNormal.sample(&mut rng)).collect()
    }

    #[test]
    fn scale_and_dispersion_are_those_of_the_noise() {
        let residuals: Vec<f64> = normal(20_000).iter().map(|r| 3.0 * r).collect();
        let tukey = Tukey::of(residuals.iter().copied(), 0.1);
        assert!((tukey.cut / (3.0 * 4.685) - 1.0).abs() < 0.03);
        // The mean of Tukey's estimate has variance σ² / 0.95 n; Σw is 0.91 n.
        let weights: f64 = residuals.iter().map(|&r| tukey.weight(r)).sum();
        let variance = tukey.dispersion(residuals.iter().copied()) / weights;
        let expected = 9.0 / 0.95 / residuals.len() as f64;
        assert!((variance / expected - 1.0).abs() < 0.05, "{variance} {expected}");
    }

    #[test]
    fn what_is_far_out_does_not_count() {
        let mut residuals = normal(700);
        residuals.extend([50.0; 300]);
        let tukey = Tukey::of(residuals.iter().copied(), 0.1);
        assert_eq!(tukey.weight(50.0), 0.0);
        assert_eq!(tukey.weight(0.0), 1.0);
        assert!(Tukey::of(std::iter::empty(), 0.1).cut > 0.0);
    }
}
