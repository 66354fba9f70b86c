//! Residuals that hang together in time: accelerations of the hand, iron that passes slowly.
//!
//! A fit that took them for white noise would count each bin as news and promise too much. Sums of
//! white residuals over a block vary as the root of the block's length; those of coloured ones
//! vary more, and by as much the weight of a reading is lowered.

use super::problem::Left;

/// Lengths of blocks, s.
const BLOCKS_S: [f64; 3] = [1.0, 3.0, 9.0];
/// Squares of sums of white residuals come this high by chance.
const CHANCE: f64 = 1.4;
/// A residual above this many variances is left out: it is no noise.
const OUTLIER: f64 = 40.0;

/// By how much σ of a reading must be raised, at least 1; `sigma` is that of one reading.
pub(crate) fn factor(left: &[Left], sigma: f64) -> f64 {
    let squares = BLOCKS_S.map(|block_s| mean_square(left, sigma, block_s));
    let most = squares.into_iter().fold(1.0, f64::max);
    if most < CHANCE { 1.0 } else { most.sqrt() }
}

/// Mean square of normalised sums over blocks; 1 for white residuals.
fn mean_square(left: &[Left], sigma: f64, block_s: f64) -> f64 {
    let (mut sum, mut blocks) = (0.0, 0.0);
    let number = |l: &Left| (l.time_s / block_s) as u64;
    for block in left.chunk_by(|a, b| number(a) == number(b)) {
        let used = || block.iter().filter(|l| l.square() < OUTLIER * sigma * sigma);
        let count = used().count() as f64;
        if count > 0.0 {
            let total = used().map(|l| l.residual * (l.count as f64).sqrt()).sum::<glam::DVec3>();
            sum += total.length_squared() / (3.0 * count * sigma * sigma);
            blocks += 1.0;
        }
    }
    if blocks > 0.0 { sum / blocks } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    fn residuals(of: impl Fn(usize, f64) -> f64) -> Vec<Left> {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut axis = |n: usize| of(n, StandardNormal.sample(&mut rng));
        let mut at = |n: usize| DVec3::new(axis(n), axis(n), axis(n));
        (0..1200).map(|n| Left { time_s: 0.1 * n as f64, count: 1, residual: at(n) }).collect()
    }

    #[test]
    fn white_residuals_keep_their_weight() {
        assert!((factor(&residuals(|_, white| white), 1.0) - 1.0).abs() < f64::EPSILON);
    }

    #[test]
    fn slow_ones_lose_it() {
        let slow = residuals(|n, white| 0.5 * white + 1.2 * (n as f64 * 0.05).sin());
        let factor = factor(&slow, 1.0);
        assert!((3.0..8.0).contains(&factor), "{factor}");
    }

    #[test]
    fn outliers_are_not_taken_for_colour() {
        let with = residuals(|n, white| if n < 40 { 50.0 } else { white });
        assert!((factor(&with, 1.0) - 1.0).abs() < f64::EPSILON);
    }
}
