//! Rounds put together.

use lodestone_client::latency::{CameraLatency, Counted, Histogram, Machine, Percentiles, Stage};
use serde::Serialize;

use super::super::plan::Plan;
use super::super::round::Outcome;
use super::super::subject::{Kind, Subject};
use super::super::target::{Target, targets};
use crate::ledger::median;

/// A figure over the rounds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// The middle one.
    pub median: f64,
    /// The smallest.
    pub smallest: f64,
    /// The largest.
    pub largest: f64,
}

impl Spread {
    /// Of one figure for each round; `None` of none.
    pub fn of(rounds: &[f64]) -> Option<Self> {
        let smallest = rounds.iter().copied().reduce(f64::min)?;
        let largest = rounds.iter().copied().reduce(f64::max)?;
        Some(Self { median: median(rounds), smallest, largest })
    }
}

/// One stage of one subject.
#[derive(Clone, Debug, Serialize)]
pub struct Line {
    /// The subject's key.
    pub subject: String,
    /// What a table calls it.
    pub name: String,
    /// The stage's key.
    pub stage: &'static str,
    /// Median over the rounds of the median, without what crossed gaps, µs.
    pub p50_us: Option<Spread>,
    /// The same of the 99th percentile.
    pub p99_us: Option<Spread>,
    /// The same of the 99th percentile with what crossed gaps.
    pub p99_with_gaps_us: Option<Spread>,
    /// All rounds together, without what crossed gaps.
    pub together: Percentiles,
    /// All rounds together, everything.
    pub together_with_gaps: Percentiles,
}

/// Another figure of a subject.
#[derive(Clone, Debug, Serialize)]
pub struct Figure {
    /// The subject's key.
    pub subject: String,
    /// What a table calls it.
    pub name: String,
    /// What it is, with its unit.
    pub what: String,
    /// Over the rounds.
    pub found: Spread,
}

/// What one subject's consumers counted in all rounds.
#[derive(Clone, Debug, Serialize)]
pub struct Tally {
    /// The subject's key.
    pub subject: String,
    /// The counts.
    pub counted: Counted,
}

/// Everything that is reported.
#[derive(Debug, Serialize)]
pub struct Summary {
    /// Where it was measured.
    pub machine: Machine,
    /// Rounds.
    pub rounds: usize,
    /// Seconds of each subject in each round.
    pub seconds: f64,
    /// Of the order of subjects.
    pub seed: u64,
    /// The lanes had real-time priority in every round; `None` if no lane was measured.
    pub real_time: Option<bool>,
    /// Latencies.
    pub lines: Vec<Line>,
    /// Other figures.
    pub figures: Vec<Figure>,
    /// What was left out.
    pub counted: Vec<Tally>,
    /// Promises.
    pub targets: Vec<Target>,
    /// Of all rounds together, by subject; for curves.
    #[serde(skip)]
    pub together: Vec<(Subject, CameraLatency)>,
}

impl Summary {
    /// Puts the outcomes of a plan together.
    pub fn of(plan: &Plan, outcomes: &[Outcome]) -> Self {
        let count = plan.subjects().len().max(1);
        let rounds: Vec<Vec<Outcome>> = outcomes.chunks(count).map(<[Outcome]>::to_vec).collect();
        let mut summary = Self {
            machine: Machine::observed(),
            rounds: plan.rounds,
            seconds: plan.seconds,
            seed: plan.seed,
            real_time: real_time(outcomes),
            lines: Vec::new(),
            figures: Vec::new(),
            counted: Vec::new(),
            targets: targets(&rounds),
            together: Vec::new(),
        };
        for subject in plan.subjects() {
            let of_subject: Vec<&Outcome> =
                outcomes.iter().filter(|outcome| outcome.subject == subject).collect();
            summary.add_latencies(subject, &of_subject);
            summary.add_figures(subject, &of_subject);
        }
        summary
    }

    fn add_latencies(&mut self, subject: Subject, outcomes: &[&Outcome]) {
        let rounds: Vec<&CameraLatency> =
            outcomes.iter().filter_map(|outcome| outcome.latency.as_ref()).collect();
        if rounds.is_empty() {
            return;
        }
        let mut together = CameraLatency::default();
        for latency in &rounds {
            together.add(latency);
        }
        self.lines.extend(
            stages_of(subject).iter().map(|stage| Line::new(subject, *stage, &rounds, &together)),
        );
        self.counted.push(Tally { subject: subject.key(), counted: together.counted });
        self.together.push((subject, together));
    }

    fn add_figures(&mut self, subject: Subject, outcomes: &[&Outcome]) {
        let Some(first) = outcomes.first() else { return };
        for (what, _) in first.figures.iter().filter(|(what, _)| what != REAL_TIME) {
            let of_round = |outcome: &&Outcome| {
                outcome.figures.iter().find(|(name, _)| name == what).map(|(_, value)| *value)
            };
            let rounds: Vec<f64> = outcomes.iter().filter_map(of_round).collect();
            let Some(found) = Spread::of(&rounds) else { continue };
            let (subject, name) = (subject.key(), subject.name());
            self.figures.push(Figure { subject, name, what: what.clone(), found });
        }
    }
}

impl Line {
    fn new(
        subject: Subject,
        stage: Stage,
        rounds: &[&CameraLatency],
        together: &CameraLatency,
    ) -> Self {
        let clean = |percentile: fn(&Histogram) -> Option<f64>| {
            let of = rounds.iter().filter_map(|latency| percentile(latency.clean.of(stage)));
            Spread::of(&of.collect::<Vec<f64>>())
        };
        let all = rounds.iter().filter_map(|latency| p99_us(latency.all.of(stage)));
        Self {
            subject: subject.key(),
            name: subject.name(),
            stage: stage.key(),
            p50_us: clean(p50_us),
            p99_us: clean(p99_us),
            p99_with_gaps_us: Spread::of(&all.collect::<Vec<f64>>()),
            together: together.clean.of(stage).percentiles(),
            together_with_gaps: together.all.of(stage).percentiles(),
        }
    }
}

/// Name of the figure that says whether lanes had real-time priority.
pub(in crate::latency) const REAL_TIME: &str = "lanes with real-time priority";

fn real_time(outcomes: &[Outcome]) -> Option<bool> {
    let figures = outcomes.iter().flat_map(|outcome| &outcome.figures);
    let said: Vec<bool> =
        figures.filter(|(what, _)| what == REAL_TIME).map(|(_, value)| *value > 0.5).collect();
    (!said.is_empty()).then(|| said.iter().all(|real_time| *real_time))
}

/// A lane has every stage, a peer the transport alone.
fn stages_of(subject: Subject) -> &'static [Stage] {
    match subject.kind() {
        Kind::Lane(..) => &Stage::ALL,
        _ => &[Stage::ArrivalToSeen],
    }
}

/// The median, µs.
pub fn p50_us(histogram: &Histogram) -> Option<f64> {
    histogram.percentiles().p50_ns.map(|ns| ns as f64 * 1e-3)
}

/// The 99th percentile, µs.
pub fn p99_us(histogram: &Histogram) -> Option<f64> {
    histogram.percentiles().p99_ns.map(|ns| ns as f64 * 1e-3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_is_median_smallest_and_largest() {
        let spread = Spread::of(&[3.0, 1.0, 2.0]);
        assert_eq!(spread, Some(Spread { median: 2.0, smallest: 1.0, largest: 3.0 }));
        assert_eq!(Spread::of(&[]), None);
    }

    #[test]
    fn real_time_is_claimed_only_if_every_round_had_it() {
        let outcome = |value| Outcome {
            subject: Subject::Lane,
            latency: None,
            figures: vec![(REAL_TIME.into(), value)],
        };
        assert_eq!(real_time(&[outcome(1.0), outcome(1.0)]), Some(true));
        assert_eq!(real_time(&[outcome(1.0), outcome(0.0)]), Some(false));
        assert_eq!(real_time(&[]), None);
    }
}
