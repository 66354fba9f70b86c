//! Standard deviations and what the paper derives from them.

use serde::Serialize;

/// A figure over several recordings: mean and standard deviation from one to the next.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Mean over the recordings.
    pub mean: f64,
    /// Standard deviation over the recordings; `None` if there is only one.
    pub deviation: Option<f64>,
}

impl Spread {
    /// The spread of values; `None` of none.
    pub fn of(values: &[f64]) -> Option<Self> {
        Some(Self { mean: mean(values)?, deviation: standard_deviation(values) })
    }
}

/// A figure over many runs, of which single ones may be far off: the median, and what nine of ten runs
/// lie above and below.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Quantiles {
    /// A tenth of the runs are below.
    pub low: f64,
    /// Half of the runs are below.
    pub median: f64,
    /// A tenth of the runs are above.
    pub high: f64,
}

impl Quantiles {
    /// The quantiles of values, interpolated between neighbours (Hyndman and Fan 1996, definition 7);
    /// `None` of none.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().checked_sub(1)?;
        let at = |part: f64| {
            let place = part * last as f64;
            let (below, share) = (place.floor() as usize, place.fract());
            let (a, b) = (sorted[below], sorted[(below + 1).min(last)]);
            a + (b - a) * share
        };
        Some(Self { low: at(0.1), median: at(0.5), high: at(0.9) })
    }
}

/// The mean; `None` of no values.
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// The standard deviation of a sample (divided by n − 1); `None` of fewer than two values.
pub fn standard_deviation(values: &[f64]) -> Option<f64> {
    let mean = mean(values).filter(|_| values.len() > 1)?;
    let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
    Some((squares / (values.len() - 1) as f64).sqrt())
}

/// The root mean square; `None` of no values.
pub fn root_mean_square(values: &[f64]) -> Option<f64> {
    let squares: f64 = values.iter().map(|x| x * x).sum();
    (!values.is_empty()).then(|| (squares / values.len() as f64).sqrt())
}

/// The paper's `ε = 1 − σ_c / σ_nc`, a ratio: the part of the deviation that calibration took away.
/// Negative where it made things worse; `None` if there was no deviation to begin with.
pub fn improvement(calibrated: f64, uncalibrated: f64) -> Option<f64> {
    (uncalibrated > 0.0).then(|| 1.0 - calibrated / uncalibrated)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn epsilon_is_the_papers() {
        // The paper's first row: 3.00 µT and 2.05 µT are 31.67 %.
        let epsilon = improvement(2.05, 3.00).unwrap();
        assert!((100.0 * epsilon - 31.67).abs() < 0.01, "{epsilon}");
        assert!(improvement(2.0, 1.0).unwrap() < 0.0);
        assert_eq!(improvement(1.0, 0.0), None);
    }

    #[test]
    fn deviations_have_their_textbook_values() {
        let values = [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0];
        assert!((standard_deviation(&values).unwrap() - (32.0_f64 / 7.0).sqrt()).abs() < 1e-12);
        assert!((root_mean_square(&[3.0, 4.0]).unwrap() - 12.5_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn quantiles_do_not_care_for_the_order_nor_for_one_wild_run() {
        let runs = (0..=10).rev().map(|k| if k == 10 { 1e9 } else { f64::from(k) });
        assert_eq!(Quantiles::of(runs), Some(Quantiles { low: 1.0, median: 5.0, high: 9.0 }));
        assert_eq!(Quantiles::of([2.0, 3.0]).unwrap().median.to_bits(), 2.5_f64.to_bits());
        assert_eq!(Quantiles::of([]), None);
    }

    #[test]
    fn too_few_values_have_no_figure() {
        assert_eq!(standard_deviation(&[1.0]), None);
        assert_eq!(root_mean_square(&[]), None);
        assert_eq!(Spread::of(&[]), None);
        assert_eq!(Spread::of(&[2.0]), Some(Spread { mean: 2.0, deviation: None }));
    }
}
