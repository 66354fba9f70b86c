//! What a part tells the harness: one line of JSON on its standard output.

use std::error::Error;

use lodestone_client::latency::{CameraLatency, Counted, Gap, Gaps, Sighting, Stamps};
use serde::{Deserialize, Serialize};

/// What a consumer saw.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Told {
    /// For each camera, or the one stream of a peer: every sighting.
    streams: Vec<Vec<Line>>,
    /// What each left out.
    left_out: Vec<Counted>,
    /// When the consumer was kept from looking.
    gaps: Vec<(i64, i64)>,
    /// Processor time that it took while it measured, ns.
    pub cpu_ns: u64,
    /// The time that it measured, ns.
    pub measured_ns: u64,
    /// Other figures by name.
    pub figures: Vec<(String, f64)>,
}

/// Six stamps, and how many came in one look.
type Line = (i64, i64, i64, i64, i64, i64, u64);

impl Told {
    /// Nothing yet of so many streams.
    pub fn of(streams: usize) -> Self {
        Self {
            streams: vec![Vec::with_capacity(1 << 12); streams],
            left_out: vec![Counted::default(); streams],
            ..Self::default()
        }
    }

    /// Adds a sighting.
    pub fn see(&mut self, stream: usize, seen: &Sighting) {
        let s = &seen.stamps;
        self.streams[stream].push((
            s.arrival_ns,
            s.ring_ns,
            s.step_start_ns,
            s.step_end_ns,
            s.published_ns,
            s.seen_ns,
            seen.in_one_look,
        ));
    }

    /// Counts what was left out.
    pub fn leave_out(&mut self, stream: usize, counted: &Counted) {
        self.left_out[stream].add(counted);
    }

    /// Adds a gap.
    pub fn note_gap(&mut self, gap: Gap) {
        self.gaps.push((gap.begin_ns, gap.end_ns));
    }

    /// Says it to whoever started this process.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn tell(&self) -> Result<(), Box<dyn Error>> {
        println!("{}", serde_json::to_string(self)?);
        Ok(())
    }

    /// The latency of each stream, judged by all gaps: the consumer's own and the sentinel's.
    pub fn latencies(&self, of_sentinel: &[Gap]) -> Vec<CameraLatency> {
        let own = self.gaps.iter().map(|&(begin_ns, end_ns)| Gap { begin_ns, end_ns });
        let gaps = Gaps::of(own.chain(of_sentinel.iter().copied()));
        let each = self.streams.iter().zip(&self.left_out);
        let judged = each.map(|(lines, left_out)| {
            let mut latency = CameraLatency { counted: *left_out, ..CameraLatency::default() };
            for line in lines {
                latency.record(&sighting(line), &gaps);
            }
            latency
        });
        judged.collect()
    }
}

const fn sighting(line: &Line) -> Sighting {
    let (arrival_ns, ring_ns, step_start_ns, step_end_ns, published_ns, seen_ns, in_one_look) =
        *line;
    let stamps = Stamps { arrival_ns, ring_ns, step_start_ns, step_end_ns, published_ns, seen_ns };
    Sighting { stamps, in_one_look }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_told_arrives_and_is_judged_by_the_gaps_of_both() {
        // Given three samples, one across a gap of the consumer, one across one of the sentinel
        let mut told = Told::of(1);
        for at_ns in [1_000, 2_000, 3_000] {
            let at = |ns: i64| at_ns + ns;
            let stamps = Stamps {
                arrival_ns: at(0),
                ring_ns: at(1),
                step_start_ns: at(2),
                step_end_ns: at(3),
                published_ns: at(4),
                seen_ns: at(5),
            };
            told.see(0, &Sighting { stamps, in_one_look: 1 });
        }
        told.note_gap(Gap { begin_ns: 2_005, end_ns: 2_100 });
        told.leave_out(0, &Counted { lost: 4, ..Counted::default() });
        let line = serde_json::to_string(&told).expect("writes");
        let heard: Told = serde_json::from_str(&line).expect("reads");
        assert_eq!(heard, told);
        let latency = &heard.latencies(&[Gap { begin_ns: 900, end_ns: 1_000 }])[0];
        let expected = Counted { measured: 3, across_gaps: 2, lost: 4, ..Counted::default() };
        assert_eq!(latency.counted, expected);
    }
}
