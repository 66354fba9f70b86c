//! Histograms of every stage, with and without what crossed a gap.

use super::counts::Counted;
use super::gaps::Gaps;
use super::histogram::Histogram;
use super::stamps::{Stage, Stamps};

/// One histogram for each stage.
#[derive(Clone, Debug, Default)]
pub struct StageHistograms([Histogram; Stage::ALL.len()]);

impl StageHistograms {
    /// Takes one sample's way.
    pub fn record(&mut self, stamps: &Stamps) {
        for (histogram, stage) in self.0.iter_mut().zip(Stage::ALL) {
            histogram.record(stamps.span_ns(stage));
        }
    }

    /// The histogram of one stage.
    pub const fn of(&self, stage: Stage) -> &Histogram {
        &self.0[stage as usize]
    }

    /// Adds all times of another.
    pub fn add(&mut self, other: &Self) {
        self.0.iter_mut().zip(&other.0).for_each(|(mine, theirs)| mine.add(theirs));
    }
}

/// A pose that a consumer saw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sighting {
    /// Its way.
    pub stamps: Stamps,
    /// How many poses came in the same look, at least this one.
    pub in_one_look: u64,
}

/// The latency of one camera's poses.
#[derive(Clone, Debug, Default)]
pub struct CameraLatency {
    /// Every sample that was measured.
    pub all: StageHistograms,
    /// Those whose way crossed no gap.
    pub clean: StageHistograms,
    /// What was measured and what was not.
    pub counted: Counted,
}

impl CameraLatency {
    /// Takes a sighting once it is known which gaps there were.
    pub fn record(&mut self, seen: &Sighting, gaps: &Gaps) {
        let stamps = &seen.stamps;
        self.counted.caught_up += seen.in_one_look.saturating_sub(1);
        if !stamps.are_in_order() {
            self.counted.out_of_order += 1;
            return;
        }
        self.counted.measured += 1;
        self.all.record(stamps);
        if gaps.cross(stamps.arrival_ns, stamps.seen_ns) {
            self.counted.across_gaps += 1;
        } else {
            self.clean.record(stamps);
        }
    }

    /// Adds what another run saw of the same.
    pub fn add(&mut self, other: &Self) {
        self.all.add(&other.all);
        self.clean.add(&other.clean);
        self.counted.add(&other.counted);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::latency::Gap;

    fn seen(arrival_ns: i64, seen_ns: i64) -> Sighting {
        let at = |part: i64| arrival_ns + (seen_ns - arrival_ns) * part / 5;
        let stamps = Stamps {
            arrival_ns,
            ring_ns: at(1),
            step_start_ns: at(2),
            step_end_ns: at(3),
            published_ns: at(4),
            seen_ns,
        };
        Sighting { stamps, in_one_look: 1 }
    }

    #[test]
    fn what_crossed_a_gap_is_counted_and_kept_apart() {
        // Given a host that stood still from 1.0 to 1.5 ms, when one of three samples was on its way
        let gaps = Gaps::of([Gap { begin_ns: 1_000_000, end_ns: 1_500_000 }]);
        let mut latency = CameraLatency::default();
        for seen in [seen(100_000, 105_000), seen(999_000, 1_502_000), seen(2_000_000, 2_005_000)] {
            latency.record(&seen, &gaps);
        }
        assert_eq!(latency.counted, Counted { measured: 3, across_gaps: 1, ..Counted::default() });
        let longest = |h: &StageHistograms| h.of(Stage::ArrivalToSeen).percentiles().max_ns;
        assert!(longest(&latency.all) > Some(500_000) && longest(&latency.clean) < Some(6_000));
    }

    #[test]
    fn what_is_not_measured_is_counted() {
        let mut latency = CameraLatency::default();
        latency.record(&Sighting { in_one_look: 4, ..seen(0, 5) }, &Gaps::default());
        latency.record(&seen(10, 5), &Gaps::default());
        let expected = Counted { measured: 1, caught_up: 3, out_of_order: 1, ..Counted::default() };
        assert_eq!(latency.counted, expected);
        let mut twice = latency.clone();
        twice.add(&latency);
        assert_eq!(twice.counted.caught_up, 6);
        assert_eq!(twice.all.of(Stage::Step).count(), 2);
    }
}
