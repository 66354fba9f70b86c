//! How many independent points the points of a patch are worth.

use super::matches::Match;

/// How much residuals of the same patch have in common.
///
/// Neighbouring points share planes, the map's errors and the depth source's: a thousand points on a
/// square of wall do not tell its place a thousand times. So the residuals' variance is parted into one
/// between patches and one within them (one-way analysis of variance with random effects), and the
/// points of a patch count `1 / (1 + (n - 1) ρ)` each, with `ρ` the intraclass correlation (Kish 1965,
/// "Survey Sampling", 5.4). Plain ICP covariances are notoriously too small for want of this (Brossard,
/// Bonnabel, Barrau 2020, "A new approach to 3D ICP covariance estimation").
#[derive(Clone, Debug)]
pub(super) struct Independence {
    counts: Vec<f64>,
    correlation: f64,
}

/// Parameters that were fitted to the residuals.
const FITTED: f64 = 6.0;

impl Independence {
    /// `scores` are residuals times their weights, one for each match; those of weight zero are zero.
    pub(super) fn of(matches: &[Match], scores: &[f64], weights: &[f64], patches: usize) -> Self {
        let mut counts = vec![0.0; patches];
        let mut sums = vec![0.0; patches];
        let mut squares = 0.0;
        for ((of, score), weight) in matches.iter().zip(scores).zip(weights) {
            if *weight > 0.0 {
                counts[of.patch as usize] += 1.0;
                sums[of.patch as usize] += score;
                squares += score * score;
            }
        }
        let correlation = correlation(&counts, &sums, squares);
        Self { counts, correlation }
    }

    /// Intraclass correlation, 0 to 1.
    #[cfg(test)]
    pub(super) const fn correlation(&self) -> f64 {
        self.correlation
    }

    /// What a match of this patch counts, up to 1.
    pub(super) fn share(&self, patch: u32) -> f64 {
        1.0 / (1.0 + (self.counts[patch as usize] - 1.0).max(0.0) * self.correlation)
    }

    /// Patches that hold matches.
    pub(super) fn patches(&self) -> usize {
        self.counts.iter().filter(|count| **count > 0.0).count()
    }

    /// How many independent points all of them are worth.
    pub(super) fn points(&self) -> f64 {
        (0..self.counts.len()).map(|p| self.counts[p] * self.share(p as u32)).sum()
    }
}

fn correlation(counts: &[f64], sums: &[f64], squares: f64) -> f64 {
    let total: f64 = counts.iter().sum();
    let patches = counts.iter().filter(|count| **count > 0.0).count() as f64;
    if patches <= FITTED + 1.0 || total <= patches + 1.0 {
        return 1.0; // too little to tell
    }
    let occupied = || counts.iter().zip(sums).filter(|(count, _)| **count > 0.0);
    // The mean over all is fitted as well, so the patches' means are taken about zero.
    let between: f64 = occupied().map(|(count, sum)| sum * sum / count).sum();
    let within = (squares - between).max(0.0) / (total - patches);
    let between = between / (patches - FITTED);
    let size = (total - counts.iter().map(|n| n * n).sum::<f64>() / total) / (patches - 1.0);
    let shared = ((between - within) / size.max(1.0)).max(0.0);
    if shared + within > 0.0 { shared / (shared + within) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use nalgebra::Vector6;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// Patches of `size` points with a common error of `shared` and one of 1 for each point.
    fn patches(count: u32, size: u32, shared: f64) -> Independence {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
        let (mut matches, mut scores) = (Vec::new(), Vec::new());
        for patch in 0..count {
            let common: f64 = StandardNormal.sample(&mut rng);
            for point in 0..size {
                let own: f64 = StandardNormal.sample(&mut rng);
                let residual = common * shared + own;
                let (jacobian, arm) = (Vector6::zeros(), DVec3::ZERO);
                let sigma_m = 1.0;
                matches.push(Match { plane: 0, point, patch, sigma_m, arm, residual, jacobian });
                scores.push(residual);
            }
        }
        Independence::of(&matches, &scores, &vec![1.0; scores.len()], count as usize)
    }

    #[test]
    fn the_variance_of_a_patch_mean_is_what_its_share_says() {
        for shared in [0.0, 0.5, 2.0] {
            let found = patches(400, 20, shared);
            let expected = shared * shared / (1.0 + shared * shared);
            assert!((found.correlation() - expected).abs() < 0.05, "{shared}");
            // Var(mean) = s² + 1/n, and (1 + s²) / (n share) must be the same.
            let variance = (1.0 + shared * shared) / (20.0 * found.share(0));
            assert!(
                (variance / (shared * shared + 0.05) - 1.0).abs() < 0.3,
                "{shared}: {variance}"
            );
        }
        assert!(patches(400, 20, 0.0).points() > 6_000.0);
        assert!(patches(400, 20, 20.0).points() < 420.0);
    }

    #[test]
    fn a_handful_of_patches_count_once_each() {
        let found = patches(6, 50, 0.0);
        assert!((found.points() - 6.0).abs() < 1e-9);
        assert_eq!(found.patches(), 6);
    }
}
