//! When frames are exposed: at fixed times, of which some are missed and none is late for long.

/// Frames at multiples of a period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Schedule {
    first_ns: i64,
    period_ns: i64,
    next: u64,
    missed: u64,
}

impl Schedule {
    /// The first frame is exposed at `first_ns`, `CLOCK_MONOTONIC`.
    pub(super) fn new(first_ns: i64, rate_hz: f64) -> Self {
        let period_ns = ((1e9 / rate_hz).round() as i64).max(1);
        Self { first_ns, period_ns, next: 0, missed: 0 }
    }

    /// Number of the next frame.
    pub(super) const fn number(&self) -> u64 {
        self.next
    }

    /// When the next frame is exposed, `CLOCK_MONOTONIC`, ns.
    pub(super) const fn time_ns(&self) -> i64 {
        self.first_ns + self.next.cast_signed() * self.period_ns
    }

    /// Between two frames, ns.
    pub(super) const fn period_ns(&self) -> i64 {
        self.period_ns
    }

    /// Frames passed over, because those before took too long.
    pub(super) const fn missed(&self) -> u64 {
        self.missed
    }

    /// Goes on to the next frame that began no longer ago than `patience_ns`.
    pub(super) fn advance(&mut self, now_ns: i64, patience_ns: i64) {
        self.next += 1;
        let behind_ns = now_ns - patience_ns - self.time_ns();
        if behind_ns > 0 {
            // Rounded up: a frame that is even a little too old is passed over.
            let skipped = (behind_ns.unsigned_abs()).div_ceil(self.period_ns.unsigned_abs());
            self.next += skipped;
            self.missed += skipped;
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn frames_fall_on_the_same_grid_however_long_each_takes() {
        let mut schedule = Schedule::new(1000, 1e7);
        schedule.advance(1090, 120);
        assert_eq!((schedule.number(), schedule.time_ns(), schedule.missed()), (1, 1100, 0));
        // At 1500, frames before 1380 are too old: 2, 3 and 4 are passed over... and 1 was done.
        schedule.advance(1500, 120);
        assert_eq!((schedule.number(), schedule.time_ns(), schedule.missed()), (4, 1400, 2));
    }

    proptest! {
        #[test]
        fn what_comes_next_is_the_first_that_is_not_too_old(
            rate_hz in 0.1..120.0_f64,
            steps in prop::collection::vec(0..2_000_000_000_i64, 1..20),
            patience_ns in 0..500_000_000_i64,
        ) {
            let mut schedule = Schedule::new(5_000_000_000, rate_hz);
            let mut now_ns = 5_000_000_000;
            for step_ns in steps {
                now_ns = now_ns.max(schedule.time_ns()) + step_ns;
                let before = schedule;
                schedule.advance(now_ns, patience_ns);
                let skipped = schedule.missed() - before.missed();
                prop_assert_eq!(schedule.number(), before.number() + 1 + skipped);
                prop_assert!(schedule.time_ns() >= now_ns - patience_ns);
                let one_before = schedule.time_ns() - schedule.period_ns();
                prop_assert!(skipped == 0 || one_before < now_ns - patience_ns);
            }
        }
    }
}
