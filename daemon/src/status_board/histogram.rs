//! Latencies in logarithmic buckets, recorded wait-free.
//!
//! As in `HdrHistogram` (Tene), each octave has the same number of linear buckets, so the relative
//! error is bounded everywhere: a reported percentile is within 0.4 % of the exact one, or within
//! half a nanosecond. Its Rust port needs `&mut` to record, or a lock.

use std::sync::atomic::{AtomicU32, Ordering};

/// Buckets in one octave, as a power of two: 128, each at most 1/128 of its value wide.
const OCTAVE_BITS: u32 = 7;
/// Values below this have a bucket each, ns.
const LINEAR: u64 = 2 << OCTAVE_BITS;
/// Longest latency told apart, as a power of two ns: 2^36 ns are 69 s; longer ones count there.
const LONGEST_BITS: u32 = 36;
const BUCKETS: usize = LINEAR as usize + ((LONGEST_BITS - OCTAVE_BITS - 1) << OCTAVE_BITS) as usize;

/// Counts durations by size; one thread or several record, one thread takes.
pub struct Histogram {
    buckets: Box<[AtomicU32]>,
}

/// What was recorded in one interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatencySummary {
    /// Durations recorded.
    pub count: u64,
    /// Median, s; `NaN` if nothing was recorded.
    pub p50_s: f64,
    /// 99th percentile, s; `NaN` if nothing was recorded.
    pub p99_s: f64,
}

impl Default for Histogram {
    fn default() -> Self {
        Self { buckets: (0..BUCKETS).map(|_| AtomicU32::new(0)).collect() }
    }
}

impl core::fmt::Debug for Histogram {
    fn fmt(&self, out: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        out.debug_struct("Histogram").field("buckets", &BUCKETS).finish_non_exhaustive()
    }
}

impl Histogram {
    /// Records a duration, ns; a negative one counts as 0. One atomic addition.
    pub fn record(&self, nanos: i64) {
        let bucket = bucket_of(u64::try_from(nanos).unwrap_or(0));
        self.buckets[bucket].fetch_add(1, Ordering::Relaxed);
    }

    /// Takes out what was recorded since the last time.
    pub fn take(&self) -> LatencySummary {
        let counts: Vec<u32> = self.buckets.iter().map(take_one).collect();
        let count = counts.iter().map(|&n| u64::from(n)).sum();
        let percentile = |fraction| percentile_s(&counts, count, fraction);
        LatencySummary { count, p50_s: percentile(0.50), p99_s: percentile(0.99) }
    }
}

/// Empty buckets, nearly all of them, are only read: the recording core keeps its cache lines.
fn take_one(bucket: &AtomicU32) -> u32 {
    if bucket.load(Ordering::Relaxed) == 0 { 0 } else { bucket.swap(0, Ordering::Relaxed) }
}

/// The smallest value with at least this fraction of all values at or below it (nearest rank).
fn percentile_s(counts: &[u32], count: u64, fraction: f64) -> f64 {
    if count == 0 {
        return f64::NAN;
    }
    let rank = ((fraction * count as f64).ceil() as u64).clamp(1, count);
    let mut seen = 0;
    let found = counts.iter().position(|&n| {
        seen += u64::from(n);
        seen >= rank
    });
    found.map_or(f64::NAN, |bucket| middle_of(bucket) * 1e-9)
}

fn bucket_of(nanos: u64) -> usize {
    let nanos = nanos.min((1 << LONGEST_BITS) - 1);
    if nanos < LINEAR {
        return nanos as usize;
    }
    // The octave above the linear part, and the bits after the leading one.
    let octave = nanos.ilog2() - OCTAVE_BITS;
    let within = (nanos >> octave) - (1 << OCTAVE_BITS);
    LINEAR as usize + (((octave - 1) as usize) << OCTAVE_BITS) + within as usize
}

/// The middle of a bucket, ns.
fn middle_of(bucket: usize) -> f64 {
    let bucket = bucket as u64;
    if bucket < LINEAR {
        return bucket as f64;
    }
    let octave = ((bucket - LINEAR) >> OCTAVE_BITS) + 1;
    let within = (bucket - LINEAR) & ((1 << OCTAVE_BITS) - 1);
    let low = ((1 << OCTAVE_BITS) + within) << octave;
    low as f64 + ((1_u64 << octave) - 1) as f64 / 2.0
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn buckets_have_no_gap_and_no_overlap() {
        let mut last = 0;
        for nanos in (0..1 << 16).chain((1 << 36) - 1000..1 << 36) {
            let bucket = bucket_of(nanos);
            assert!(bucket == last || bucket == last + 1 || nanos > 1 << 16, "{nanos}");
            last = bucket;
        }
        assert_eq!(bucket_of(u64::MAX), BUCKETS - 1);
    }

    #[test]
    fn nothing_recorded_has_no_percentile() {
        let summary = Histogram::default().take();
        assert_eq!(summary.count, 0);
        assert!(summary.p50_s.is_nan() && summary.p99_s.is_nan());
    }

    #[test]
    fn taking_empties_it() {
        let histogram = Histogram::default();
        histogram.record(5_000);
        histogram.record(-3);
        assert_eq!(histogram.take().count, 2);
        assert_eq!(histogram.take().count, 0);
    }

    #[test]
    fn recording_while_taking_loses_nothing() {
        let histogram = Histogram::default();
        let taken = std::thread::scope(|threads| {
            let recorders: Vec<_> = (0..2)
                .map(|_| threads.spawn(|| (0..20_000).for_each(|n| histogram.record(n % 900))))
                .collect();
            let mut taken = 0;
            while !recorders.iter().all(std::thread::ScopedJoinHandle::is_finished) {
                taken += histogram.take().count;
            }
            taken
        });
        assert_eq!(taken + histogram.take().count, 40_000);
    }

    proptest! {
        #[test]
        fn percentiles_are_within_half_a_percent_of_exact(
            mut nanos in proptest::collection::vec((0_u32..36, 0.0..1.0_f64), 1..600)
                .prop_map(|v| v.into_iter()
                    .map(|(bits, f)| ((1_u64 << bits) as f64 * (1.0 + f)) as i64 & ((1 << 36) - 1))
                    .collect::<Vec<_>>()),
        ) {
            let histogram = Histogram::default();
            for &n in &nanos {
                histogram.record(n);
            }
            nanos.sort_unstable();
            let exact = |fraction: f64| {
                let rank = (fraction * nanos.len() as f64).ceil() as usize;
                nanos[rank.max(1) - 1] as f64 * 1e-9
            };
            let summary = histogram.take();
            prop_assert_eq!(summary.count, nanos.len() as u64);
            for (found, wanted) in [(summary.p50_s, exact(0.50)), (summary.p99_s, exact(0.99))] {
                prop_assert!((found - wanted).abs() <= 0.004 * wanted + 0.5e-9, "{found} {wanted}");
            }
        }
    }
}
