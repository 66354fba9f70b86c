//! How late clouds are merged.

use core::time::Duration;

/// Buckets for each doubling of the time.
const PER_OCTAVE: u64 = 8;
/// The first octave ends at 2^10 ns.
const FIRST_OCTAVE: u64 = 10;
/// The last one ends at 2^37 ns, 137 s.
const OCTAVES: u64 = 28;
const BUCKETS: usize = (PER_OCTAVE * OCTAVES) as usize;

/// Times from a cloud's publication to the end of its merging, counted in steps of an eighth of an octave: a
/// quantile is right within 13 %, from 1 µs to 137 s, in fixed memory.
#[derive(Clone, Debug)]
pub struct Lateness {
    counts: [u64; BUCKETS],
}

impl Default for Lateness {
    fn default() -> Self {
        Self { counts: [0; BUCKETS] }
    }
}

impl Lateness {
    /// Counts one.
    pub fn add(&mut self, late: Duration) {
        let ns = u64::try_from(late.as_nanos()).unwrap_or(u64::MAX).max(1 << (FIRST_OCTAVE - 1));
        let octave = u64::from(ns.ilog2());
        // The bits after the leading one, as far as they count.
        let eighth = (ns >> (octave - 3)) & (PER_OCTAVE - 1);
        let bucket = (octave + 1 - FIRST_OCTAVE) * PER_OCTAVE + eighth;
        self.counts[(bucket as usize).min(BUCKETS - 1)] += 1;
    }

    /// How many were counted.
    pub fn count(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// The time that a share of all, 0 to 1, does not exceed; `None` if nothing was counted.
    pub fn quantile(&self, share: f64) -> Option<Duration> {
        let wanted = (share.clamp(0.0, 1.0) * self.count() as f64).ceil().max(1.0) as u64;
        let mut seen = 0;
        let bucket = self.counts.iter().position(|count| {
            seen += count;
            seen >= wanted
        })?;
        Some(Duration::from_nanos(upper_end_ns(bucket as u64)))
    }
}

fn upper_end_ns(bucket: u64) -> u64 {
    let octave = bucket / PER_OCTAVE + FIRST_OCTAVE - 1;
    (PER_OCTAVE + bucket % PER_OCTAVE + 1) << (octave - 3)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_quantile_is_right_within_an_eighth(mut times in prop::collection::vec(1_000..60_000_000_000_u64, 1..200), share in 0.01..1.0_f64) {
            let mut lateness = Lateness::default();
            for &ns in &times {
                lateness.add(Duration::from_nanos(ns));
            }
            times.sort_unstable();
            let rank = (share * times.len() as f64).ceil() as usize;
            let truth = times[rank.max(1) - 1] as f64;
            let found = lateness.quantile(share).unwrap().as_nanos() as f64;
            prop_assert!(found >= truth && found <= truth * 1.13, "{found} {truth}");
        }

        #[test]
        fn no_time_panics(ns in any::<u64>()) {
            let mut lateness = Lateness::default();
            lateness.add(Duration::from_nanos(ns));
            prop_assert_eq!(lateness.count(), 1);
        }
    }

    #[test]
    fn of_nothing_there_is_no_quantile() {
        assert_eq!(Lateness::default().quantile(0.5), None);
    }
}
