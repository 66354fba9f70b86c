//! What a depth source has done.

use std::fmt;
use std::time::Duration;

/// Counts of one source since it began.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Tally {
    /// Clouds published.
    pub(super) published: u64,
    /// Frames passed over, because those before took too long.
    pub(super) missed: u64,
    /// Frames of which the truth was not told.
    pub(super) without_truth: u64,
    /// Clouds that the transport refused.
    pub(super) refused: u64,
    /// Time spent on rays and noise.
    pub(super) busy: Duration,
}

impl Tally {
    /// What was done since an earlier tally.
    pub(super) fn since(&self, earlier: &Self) -> Self {
        Self {
            published: self.published - earlier.published,
            missed: self.missed - earlier.missed,
            without_truth: self.without_truth - earlier.without_truth,
            refused: self.refused - earlier.refused,
            busy: self.busy.saturating_sub(earlier.busy),
        }
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} clouds published", self.published)?;
        if self.published > 0 {
            let each_ms = self.busy.as_secs_f64() * 1e3 / self.published as f64;
            write!(out, ", {each_ms:.1} ms each")?;
        }
        let losses = [
            (self.missed, "missed for want of time"),
            (self.without_truth, "without truth"),
            (self.refused, "refused by the transport"),
        ];
        for (count, what) in losses.into_iter().filter(|(count, _)| *count > 0) {
            write!(out, ", {count} {what}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_losses_that_were_are_told() {
        let earlier = Tally { published: 10, busy: Duration::from_millis(40), ..Tally::default() };
        let now = Tally { published: 30, missed: 2, busy: Duration::from_millis(100), ..earlier };
        assert_eq!(
            now.since(&earlier).to_string(),
            "20 clouds published, 3.0 ms each, 2 missed for want of time"
        );
        assert_eq!(Tally::default().to_string(), "0 clouds published");
    }
}
