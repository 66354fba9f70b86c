//! How often a time took how long.

use hdrhistogram::Histogram as Hdr;
use serde::Serialize;

/// Longest time told apart from longer ones: 100 s.
const LONGEST_NS: u64 = 100_000_000_000;
/// Decimal figures that are kept of each time.
const FIGURES: u8 = 3;

/// Times from 1 ns to 100 s with an error of at most 0.1 % (an HDR histogram).
#[derive(Clone, Debug)]
pub struct Histogram(Hdr<u64>);

/// What is read from a histogram, ns. A percentile that so few times cannot tell is `None`:
/// p99.9 takes a thousand of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Percentiles {
    /// Times recorded.
    pub count: u64,
    /// Half of all took no longer.
    pub p50_ns: Option<u64>,
    /// 99 % took no longer.
    pub p99_ns: Option<u64>,
    /// 99.9 % took no longer.
    pub p99_9_ns: Option<u64>,
    /// 99.99 % took no longer.
    pub p99_99_ns: Option<u64>,
    /// The longest.
    pub max_ns: Option<u64>,
}

impl Default for Histogram {
    fn default() -> Self {
        // Both are constants that the crate allows; without them it would grow as it goes.
        let bounded = Hdr::new_with_bounds(1, LONGEST_NS, FIGURES);
        Self(bounded.expect("the bounds are far apart and the figures few"))
    }
}

impl Histogram {
    /// Takes a time; a negative one counts as none at all, one beyond the range as the longest.
    pub fn record(&mut self, span_ns: i64) {
        self.0.saturating_record(u64::try_from(span_ns).unwrap_or(0));
    }

    /// Adds all times of another.
    pub fn add(&mut self, other: &Self) {
        // Both have the same bounds, which is all that could stand in the way.
        let added = self.0.add(&other.0);
        debug_assert!(added.is_ok(), "{added:?}");
    }

    /// Times recorded.
    pub fn count(&self) -> u64 {
        self.0.len()
    }

    /// The time that a share of all did not exceed, ns, if there are enough to tell: one time at
    /// least must be longer.
    pub fn quantile_ns(&self, share: f64) -> Option<u64> {
        let longer = self.count() as f64 * (1.0 - share);
        // 1000 times 0.001 may come out a rounding below 1.
        (longer >= 1.0 - 1e-6).then(|| self.0.value_at_quantile(share))
    }

    /// The usual percentiles.
    pub fn percentiles(&self) -> Percentiles {
        let any = self.count() > 0;
        Percentiles {
            count: self.count(),
            p50_ns: any.then(|| self.0.value_at_quantile(0.5)),
            p99_ns: self.quantile_ns(0.99),
            p99_9_ns: self.quantile_ns(0.999),
            p99_99_ns: self.quantile_ns(0.9999),
            max_ns: any.then(|| self.0.max()),
        }
    }

    /// Points of the curve of percentiles: how many times in one the value was not exceeded, as
    /// 1/(1 − share), and the value, ns.
    pub fn curve(&self) -> Vec<(f64, u64)> {
        let points = self.0.iter_quantiles(5).map(|step| {
            let rest = 1.0 - step.quantile();
            (rest.max(0.5 / self.count().max(1) as f64).recip(), step.value_iterated_to())
        });
        points.collect()
    }
}

impl Percentiles {
    /// With the names that tables use.
    pub const fn named(&self) -> [(&'static str, Option<u64>); 5] {
        [
            ("p50", self.p50_ns),
            ("p99", self.p99_ns),
            ("p99.9", self.p99_9_ns),
            ("p99.99", self.p99_99_ns),
            ("max", self.max_ns),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(times: impl Iterator<Item = i64>) -> Histogram {
        let mut histogram = Histogram::default();
        times.for_each(|ns| histogram.record(ns));
        histogram
    }

    fn close(found: Option<u64>, expected: u64) -> bool {
        found.is_some_and(|ns| ns.abs_diff(expected) * 500 <= expected)
    }

    #[test]
    fn percentiles_of_known_times() {
        // Given 1 to 10,000 µs, once each
        let p = of((1..=10_000).map(|us| us * 1000)).percentiles();
        assert_eq!(p.count, 10_000);
        assert!(close(p.p50_ns, 5_000_000) && close(p.p99_ns, 9_900_000), "{p:?}");
        assert!(close(p.p99_9_ns, 9_990_000) && close(p.p99_99_ns, 9_999_000), "{p:?}");
        assert!(close(p.max_ns, 10_000_000), "{p:?}");
    }

    #[test]
    fn what_so_few_times_cannot_tell_is_not_told() {
        let hundred = of((1..=100).map(|us| us * 1000)).percentiles();
        assert!(close(hundred.p99_ns, 99_000), "{hundred:?}");
        assert_eq!((hundred.p99_9_ns, hundred.p99_99_ns), (None, None));
        assert_eq!(of((1..=99).map(|us| us * 1000)).percentiles().p99_ns, None);
        assert!(of((1..=1000).map(|us| us * 1000)).percentiles().p99_9_ns.is_some());
        assert_eq!(Histogram::default().percentiles(), Percentiles::default());
    }

    #[test]
    fn adding_is_as_if_all_had_been_recorded_in_one() {
        let (odd, even) = (|us: &i64| us % 2 == 1, |us: &i64| us % 2 == 0);
        let mut merged = of((1..=10_000).filter(odd).map(|us| us * 1000));
        merged.add(&of((1..=10_000).filter(even).map(|us| us * 1000)));
        assert_eq!(merged.percentiles(), of((1..=10_000).map(|us| us * 1000)).percentiles());
    }

    #[test]
    fn times_out_of_range_are_kept_at_its_ends() {
        let p = of([-5, i64::MAX].into_iter()).percentiles();
        assert_eq!((p.count, p.p50_ns), (2, Some(0)));
        assert!(close(p.max_ns, LONGEST_NS), "{p:?}");
    }

    #[test]
    fn the_curve_rises_and_ends_at_the_longest() {
        let histogram = of((1..=5000).map(|us| us * 1000));
        let curve = histogram.curve();
        assert!(curve.windows(2).all(|w| w[0].0 <= w[1].0 && w[0].1 <= w[1].1));
        assert!(curve.iter().all(|(one_in, _)| one_in.is_finite()));
        assert!(close(curve.last().map(|(_, ns)| *ns), 5_000_000));
    }
}
