//! What is promised, as ratios within one round.

use lodestone_client::latency::{Histogram, Stage};
use serde::Serialize;

use super::report::{Spread, p50_us, p99_us};
use super::role::fan_out_figure;
use super::round::Outcome;
use super::subject::Subject;

/// A promise and what came of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Target {
    /// What is promised.
    pub promise: &'static str,
    /// What may be reached at most.
    pub limit: f64,
    /// What was found over the rounds.
    pub found: Spread,
    /// Whether the median is within the limit.
    pub met: bool,
}

/// A value of one round; `None` if what it needs was not measured.
type OfRound = fn(&[Outcome]) -> Option<f64>;

const TARGETS: [(&str, f64, OfRound); 11] = [
    ("arrival to consumer / filter step and plain iceoryx2, p50", 1.5, |round| {
        Some(of(round, Subject::InTurns, p50_us)? / of(round, Subject::Floor, p50_us)?)
    }),
    ("arrival to consumer / filter step and plain iceoryx2, p99", 2.0, |round| {
        Some(of(round, Subject::InTurns, p99_us)? / of(round, Subject::Floor, p99_us)?)
    }),
    ("publishing to 16 subscribers / to none", 4.0, |round| {
        let ns = |subscribers| figure(round, Subject::FanOut, &fan_out_figure(subscribers));
        Some(ns(16)? / ns(0)?)
    }),
    ("beside a second camera / alone, p50", 1.05, |round| {
        Some(of(round, Subject::SecondCamera, p50_us)? / lane(round, p50_us)?)
    }),
    ("8 cameras at 400 Hz, % of one core", 15.0, |round| {
        figure(round, Subject::EightCameras, "processor %")
    }),
    ("64 cameras at 400 Hz, samples and poses lost", 0.0, |round| {
        let count = |name| figure(round, Subject::SixtyFourCameras, name);
        Some(count("samples lost")? + count("poses lost")?)
    }),
    ("one thread / two threads with wake-up, p50", 1.0, |round| {
        Some(lane(round, p50_us)? / of(round, Subject::LaneTwo, p50_us)?)
    }),
    ("one thread / two threads, timed, p50", 1.0, |round| {
        Some(lane(round, p50_us)? / of(round, Subject::LaneTimed, p50_us)?)
    }),
    ("waiting until due / woken by an event, published to seen, p50", 0.5, |round| {
        Some(transport(round, Subject::Wait)? / transport(round, Subject::Event)?)
    }),
    ("waiting until due / plain iceoryx2 with an event, published to seen, p50", 0.5, |round| {
        Some(transport(round, Subject::Wait)? / of(round, Subject::Iceoryx2Blocking, p50_us)?)
    }),
    ("processor time of a waiting consumer, %", 3.0, |round| {
        figure(round, Subject::Wait, "consumer's processor %")
    }),
];

/// Every promise of which enough was measured.
pub fn targets(rounds: &[Vec<Outcome>]) -> Vec<Target> {
    let judged = TARGETS.iter().filter_map(|(promise, limit, of_round)| {
        let found: Vec<f64> = rounds.iter().filter_map(|round| of_round(round)).collect();
        let found = Spread::of(&found)?;
        Some(Target { promise, limit: *limit, found, met: found.median <= *limit })
    });
    judged.collect()
}

fn outcome(round: &[Outcome], subject: Subject) -> Option<&Outcome> {
    round.iter().find(|outcome| outcome.subject == subject)
}

fn figure(round: &[Outcome], subject: Subject, name: &str) -> Option<f64> {
    let figures = &outcome(round, subject)?.figures;
    figures.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
}

type Percentile = fn(&Histogram) -> Option<f64>;

/// Of a subject's whole way, without what crossed a gap, µs.
fn of(round: &[Outcome], subject: Subject, percentile: Percentile) -> Option<f64> {
    let latency = outcome(round, subject)?.latency.as_ref()?;
    percentile(latency.clean.of(Stage::ArrivalToSeen))
}

fn lane(round: &[Outcome], percentile: Percentile) -> Option<f64> {
    of(round, Subject::Lane, percentile)
}

fn transport(round: &[Outcome], subject: Subject) -> Option<f64> {
    let latency = outcome(round, subject)?.latency.as_ref()?;
    p50_us(latency.clean.of(Stage::PublishedToSeen))
}

#[cfg(test)]
mod tests {
    use lodestone_client::latency::{CameraLatency, Gaps, Sighting, Stamps};

    use super::*;

    fn way_of(us: i64) -> CameraLatency {
        let mut latency = CameraLatency::default();
        let stamps = Stamps { seen_ns: us * 1000, ..Stamps::default() };
        for _ in 0..200 {
            latency.record(&Sighting { stamps, in_one_look: 1 }, &Gaps::default());
        }
        latency
    }

    fn outcome_of(subject: Subject, us: i64) -> Outcome {
        Outcome { subject, latency: Some(way_of(us)), figures: Vec::new() }
    }

    #[test]
    fn a_promise_is_judged_by_the_median_of_ratios_within_rounds() {
        // Given a machine that is ten times as slow in one of three rounds
        let round = |factor: i64, lane: i64| {
            vec![
                outcome_of(Subject::InTurns, lane * factor),
                outcome_of(Subject::Floor, 20 * factor),
            ]
        };
        let targets = targets(&[round(1, 28), round(10, 26), round(1, 40)]);
        assert_eq!(targets.len(), 2, "what was not measured is not judged: {targets:?}");
        let p50 = &targets[0];
        assert!(p50.met && (p50.found.median - 1.4).abs() < 0.01, "{p50:?}");
        assert!((p50.found.smallest - 1.3).abs() < 0.01 && (p50.found.largest - 2.0).abs() < 0.01);
    }

    #[test]
    fn a_promise_that_is_broken_is_said_to_be() {
        let figures = vec![("processor %".to_owned(), 15.5)];
        let round = vec![Outcome { subject: Subject::EightCameras, latency: None, figures }];
        let targets = targets(&[round]);
        assert_eq!(targets.len(), 1);
        assert!(!targets[0].met);
    }
}
