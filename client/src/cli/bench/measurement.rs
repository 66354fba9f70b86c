//! What was seen, folded into histograms as it goes, so that hours take no more memory than seconds.

use std::collections::VecDeque;

use lodestone_client::latency::{CameraLatency, Gap, Gaps, Seen, Sentinel, Sighting};

/// A gap is known once it is over, and a sample is judged once all gaps on its way are: this later.
const HOLD_NS: i64 = 500_000_000;
/// Between two looks at what the sentinel noted.
const BETWEEN_LOOKS_NS: i64 = 50_000_000;

/// How often and how long a core was missing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub(super) struct Tally {
    pub(super) count: u64,
    pub(super) total_ns: i64,
    pub(super) longest_ns: i64,
}

impl Tally {
    fn note(&mut self, gap: &Gap) {
        self.count += 1;
        self.total_ns += gap.span_ns();
        self.longest_ns = self.longest_ns.max(gap.span_ns());
    }
}

/// A measurement under way.
pub(super) struct Measurement {
    pub(super) latencies: Vec<CameraLatency>,
    /// Gaps of the consumer's own core.
    pub(super) own: Tally,
    /// Gaps of the sentinel's; `None` without one.
    pub(super) other: Option<Tally>,
    sentinel: Option<Sentinel>,
    pending: VecDeque<(usize, Sighting)>,
    recent: Gaps,
    next_look_ns: i64,
}

impl Measurement {
    pub(super) fn new(cameras: usize, sentinel: Option<Sentinel>) -> Self {
        Self {
            latencies: vec![CameraLatency::default(); cameras],
            own: Tally::default(),
            other: sentinel.as_ref().map(|_| Tally::default()),
            sentinel,
            // Half a second of some cameras.
            pending: VecDeque::with_capacity(1 << 14),
            recent: Gaps::default(),
            next_look_ns: 0,
        }
    }

    pub(super) fn take(&mut self, camera: usize, seen: &Seen) {
        self.latencies[camera].counted.add(&seen.left_out);
        self.pending.extend(seen.sighting.map(|sighting| (camera, sighting)));
    }

    pub(super) fn note_gap(&mut self, gap: Gap) {
        self.own.note(&gap);
        self.recent = Gaps::of(self.recent.iter().chain([gap]));
    }

    /// Judges at most two samples that are old enough: work for a fraction of a microsecond, while the
    /// next pose may come.
    pub(super) fn settle(&mut self, now_ns: i64) {
        if now_ns >= self.next_look_ns {
            self.next_look_ns = now_ns + BETWEEN_LOOKS_NS;
            self.look(now_ns - 4 * HOLD_NS);
        }
        for _ in 0..2 {
            let old =
                self.pending.front().is_some_and(|(_, s)| s.stamps.seen_ns < now_ns - HOLD_NS);
            let Some((camera, seen)) = self.pending.pop_front_if(|_| old) else { return };
            self.latencies[camera].record(&seen, &self.recent);
        }
    }

    /// Judges all that are left.
    pub(super) fn settle_all(&mut self) {
        self.look(i64::MIN);
        for (camera, seen) in std::mem::take(&mut self.pending) {
            self.latencies[camera].record(&seen, &self.recent);
        }
    }

    /// Samples measured so far.
    pub(super) fn measured(&self) -> u64 {
        self.latencies.iter().map(|latency| latency.counted.measured).sum()
    }

    /// Takes what the sentinel noted; forgets what ended before any sample that waits.
    fn look(&mut self, forget_before_ns: i64) {
        let noted = self.sentinel.as_ref().map(Sentinel::take).unwrap_or_default();
        if let Some(other) = &mut self.other {
            for gap in &noted {
                other.note(gap);
            }
        }
        let of_use = |gap: &Gap| gap.end_ns >= forget_before_ns;
        self.recent = Gaps::of(self.recent.iter().filter(of_use).chain(noted));
    }
}

#[cfg(test)]
mod tests {
    use lodestone_client::latency::{Stage, Stamps};

    use super::*;

    fn seen(arrival_ns: i64) -> Seen {
        let stamps = Stamps {
            arrival_ns,
            ring_ns: arrival_ns + 1,
            step_start_ns: arrival_ns + 2,
            step_end_ns: arrival_ns + 3,
            published_ns: arrival_ns + 4,
            seen_ns: arrival_ns + 5,
        };
        Seen { sighting: Some(Sighting { stamps, in_one_look: 1 }), ..Seen::default() }
    }

    #[test]
    fn a_sample_is_judged_by_gaps_that_become_known_after_it_was_seen() {
        let mut measurement = Measurement::new(1, None);
        measurement.take(0, &seen(1_000));
        measurement.settle(2_000);
        assert_eq!(measurement.measured(), 0, "it waits");
        measurement.note_gap(Gap { begin_ns: 500, end_ns: 1_001 });
        measurement.settle(2_000 + HOLD_NS);
        let latency = &measurement.latencies[0];
        assert_eq!((latency.counted.measured, latency.counted.across_gaps), (1, 1));
        assert_eq!(measurement.own, Tally { count: 1, total_ns: 501, longest_ns: 501 });
    }

    #[test]
    fn what_waits_at_the_end_counts_too() {
        let mut measurement = Measurement::new(2, None);
        let arrivals = (0..10).map(|n| n * 1_000_000);
        arrivals.enumerate().for_each(|(n, arrival_ns)| measurement.take(n % 2, &seen(arrival_ns)));
        measurement.settle_all();
        let counts = measurement.latencies.iter().map(|l| l.all.of(Stage::ArrivalToSeen).count());
        assert_eq!(counts.collect::<Vec<_>>(), [5, 5]);
    }
}
