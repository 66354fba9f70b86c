//! Allan deviation: how a sensor's noise averages out, and where it stops to.
//!
//! On log-log axes white noise falls with slope −½, 1/f noise is flat, and a random walk of the bias
//! rises with slope +½. The overlapping estimator (Riley, Handbook of Frequency Stability Analysis,
//! NIST SP 1065, §5.2.4; for inertial sensors IEEE Std 952, annex C) uses every pair of neighbouring
//! means of length τ, wherever they begin.

use serde::Serialize;

/// One point of the curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AllanPoint {
    /// Averaging time τ, s.
    pub tau_s: f64,
    /// Allan deviation at τ, in the unit of the values.
    pub deviation: f64,
}

/// Least number of averaging times that must fit into the recording: with fewer the estimate itself
/// is uncertain by more than a third.
const LEAST_AVERAGES: usize = 9;

/// The overlapping Allan deviation of values sampled every `interval_s`, at about `per_decade`
/// averaging times in each decade, up to a ninth of the recording. Empty if it is shorter than that.
pub fn overlapping(values: &[f64], interval_s: f64, per_decade: usize) -> Vec<AllanPoint> {
    let sums = cumulative(values);
    let lengths = averaging_lengths(values.len() / LEAST_AVERAGES, per_decade);
    let point = |length: usize| AllanPoint {
        tau_s: length as f64 * interval_s,
        deviation: deviation(&sums, length),
    };
    lengths.into_iter().map(point).collect()
}

/// The point of a curve whose averaging time is nearest to `tau_s`, in ratio.
pub fn at(curve: &[AllanPoint], tau_s: f64) -> Option<AllanPoint> {
    let away = |point: &AllanPoint| (point.tau_s / tau_s).ln().abs();
    curve.iter().copied().min_by(|a, b| away(a).total_cmp(&away(b)))
}

/// Sums of the first 0, 1, 2, … values. The mean is taken off first, which changes no second
/// difference and keeps the sums small.
fn cumulative(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let mut sums = Vec::with_capacity(values.len() + 1);
    let mut sum = 0.0;
    sums.push(sum);
    for value in values {
        sum += value - mean;
        sums.push(sum);
    }
    sums
}

/// σ²(m) = Σ (S₍ₖ₊₂ₘ₎ − 2 S₍ₖ₊ₘ₎ + S₍ₖ₎)² / (2 m² (N − 2m)) for N sums; SP 1065, equation 11.
fn deviation(sums: &[f64], length: usize) -> f64 {
    let count = sums.len() - 2 * length;
    let second = |k: usize| sums[k + 2 * length] - 2.0 * sums[k + length] + sums[k];
    let squares: f64 = (0..count).map(|k| second(k) * second(k)).sum();
    (squares / (2.0 * count as f64)).sqrt() / length as f64
}

/// Whole numbers from 1 to `longest`, evenly in ratio, without repetition.
fn averaging_lengths(longest: usize, per_decade: usize) -> Vec<usize> {
    // No recording has as many as 10²⁰ values.
    const MOST_DECADES: usize = 20;
    let per_decade = per_decade.max(1);
    let mut lengths: Vec<usize> = (0..MOST_DECADES * per_decade)
        .map(|k| 10.0_f64.powf(k as f64 / per_decade as f64).round() as usize)
        .take_while(|length| *length <= longest)
        .collect();
    lengths.dedup();
    lengths
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const INTERVAL_S: f64 = 0.01;
    const COUNT: usize = 200_000;

    fn white(sigma: f64) -> Vec<f64> {
        let rng = ChaCha8Rng::seed_from_u64(9);
        let normal = StandardNormal.sample_iter(rng);
        normal.map(|x: f64| x * sigma).take(COUNT).collect()
    }

    fn ratios(curve: &[AllanPoint], theory: impl Fn(f64) -> f64) -> Vec<f64> {
        curve.iter().map(|p| p.deviation / theory(p.tau_s)).collect()
    }

    #[test]
    fn white_noise_falls_as_its_density_over_the_root_of_tau() {
        let density = 0.4;
        let curve = overlapping(&white(density / INTERVAL_S.sqrt()), INTERVAL_S, 5);
        assert!(curve.len() > 18);
        for (ratio, point) in ratios(&curve, |tau| density / tau.sqrt()).iter().zip(&curve) {
            // A curve of n averages is uncertain by about 1/√n.
            let averages = COUNT as f64 * INTERVAL_S / point.tau_s;
            assert!((ratio - 1.0).abs() < 4.0 / averages.sqrt(), "{ratio} at {} s", point.tau_s);
        }
    }

    #[test]
    fn a_random_walk_rises_as_the_root_of_a_third_of_tau() {
        let walk = 0.2;
        let mut sum = 0.0;
        let values: Vec<f64> = white(walk * INTERVAL_S.sqrt())
            .iter()
            .map(|step| {
                sum += step;
                sum
            })
            .collect();
        let curve = overlapping(&values, INTERVAL_S, 5);
        for (ratio, point) in ratios(&curve, |tau| walk * (tau / 3.0).sqrt()).iter().zip(&curve) {
            // In steps of one sample the walk is discrete: the law holds from some samples on.
            let averages = COUNT as f64 * INTERVAL_S / point.tau_s;
            let bound = 4.0 / averages.sqrt() + 0.3 * INTERVAL_S / point.tau_s;
            assert!((ratio - 1.0).abs() < bound, "{ratio} at {} s", point.tau_s);
        }
    }

    #[test]
    fn an_offset_changes_nothing_and_a_ramp_is_its_slope() {
        let ramp: Vec<f64> = (0..1000).map(|k| 9.81 + f64::from(k) * INTERVAL_S * 0.5).collect();
        for point in overlapping(&ramp, INTERVAL_S, 3) {
            // σ(τ) of a drift D is D τ / √2 (IEEE 952).
            let expected = 0.5 * point.tau_s / std::f64::consts::SQRT_2;
            assert!((point.deviation / expected - 1.0).abs() < 1e-9, "{point:?}");
        }
    }

    #[test]
    fn averaging_times_do_not_repeat_and_end_at_a_ninth() {
        let curve = overlapping(&white(1.0)[..900], INTERVAL_S, 10);
        assert!(curve.windows(2).all(|w| w[0].tau_s < w[1].tau_s));
        assert!((curve[curve.len() - 1].tau_s - 1.0).abs() < 1e-12);
        assert!((at(&curve, 0.49).unwrap().tau_s - 0.5).abs() < 0.011);
        assert!(overlapping(&[1.0; 8], INTERVAL_S, 10).is_empty());
        assert_eq!(at(&[], 1.0), None);
    }
}
