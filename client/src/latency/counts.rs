//! What was seen, and what was left out, and why.

use serde::{Deserialize, Serialize};

/// Counts of poses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counted {
    /// In the histograms of all.
    pub measured: u64,
    /// Of these, their way crossed a gap that a sentinel or the consumer itself noted; they are
    /// in the histograms of all, and not in the others.
    pub across_gaps: u64,
    /// Left out: seen during warm-up, or from before the consumer came.
    pub warm_up: u64,
    /// Left out: several came in one look; only the newest of them was seen in time.
    pub caught_up: u64,
    /// Left out: the last pose once more, because the sensor is silent.
    pub repeated: u64,
    /// Left out: stamps that run backwards, so not of this computer's clock.
    pub out_of_order: u64,
    /// Never seen: missing by their sequence.
    pub lost: u64,
}

impl Counted {
    /// Adds what another run counted.
    pub const fn add(&mut self, other: &Self) {
        self.measured += other.measured;
        self.across_gaps += other.across_gaps;
        self.warm_up += other.warm_up;
        self.caught_up += other.caught_up;
        self.repeated += other.repeated;
        self.out_of_order += other.out_of_order;
        self.lost += other.lost;
    }

    /// With the words of a report, those that are not zero; the first is what was measured.
    pub fn told(&self) -> Vec<String> {
        let parts = [
            (self.across_gaps, "across gaps"),
            (self.warm_up, "during warm-up"),
            (self.caught_up, "caught up"),
            (self.repeated, "repeated while silent"),
            (self.out_of_order, "with stamps out of order"),
            (self.lost, "lost"),
        ];
        let told = parts.into_iter().filter(|(count, _)| *count > 0);
        told.map(|(count, what)| format!("{count} {what}")).collect()
    }
}
