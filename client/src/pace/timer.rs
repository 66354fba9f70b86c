//! Sleeps that know how late they end.

use core::num::NonZeroU64;

use rustix::thread::{clock_nanosleep_absolute, current_timer_slack, set_current_timer_slack};
use rustix::time::{ClockId, Timespec};

use super::rhythm::Offsets;
use crate::time::monotonic_now_ns;

/// Sleeps from which the lateness is learnt.
const REMEMBERED: usize = 32;
/// The lateness assumed of the first sleeps, ns.
const AT_FIRST_NS: f64 = 60_000.0;
/// Part of all sleeps that shall not end later than allowed for.
const IN_TIME: f64 = 0.75;
const SECOND_NS: i64 = 1_000_000_000;
/// As little as the kernel takes: it may end other sleeps late to save wake-ups, ours not.
const SLACK: NonZeroU64 = NonZeroU64::new(1).unwrap();

/// Sleeps on `CLOCK_MONOTONIC`, and the lateness with which they ended.
#[derive(Clone, Debug)]
pub(crate) struct Timer {
    late_ns: [f64; REMEMBERED],
    next: usize,
}

impl Default for Timer {
    fn default() -> Self {
        Self { late_ns: [AT_FIRST_NS; REMEMBERED], next: 0 }
    }
}

impl Timer {
    /// Sleeps until a time, with the thread's timer slack set aside meanwhile; a signal may end it
    /// sooner.
    pub(crate) fn sleep_until(&mut self, time_ns: i64) {
        let time = Timespec {
            tv_sec: time_ns.div_euclid(SECOND_NS),
            tv_nsec: time_ns.rem_euclid(SECOND_NS),
        };
        let own = current_timer_slack().ok().and_then(NonZeroU64::new);
        // Refused, the sleep is less exact, which the lateness shows.
        let _ = set_current_timer_slack(Some(SLACK));
        let slept = clock_nanosleep_absolute(ClockId::Monotonic, &time);
        let _ = set_current_timer_slack(own);
        if slept.is_ok() {
            self.note(monotonic_now_ns().saturating_sub(time_ns));
        }
    }

    fn note(&mut self, late_ns: i64) {
        self.late_ns[self.next] = late_ns as f64;
        self.next = (self.next + 1) % REMEMBERED;
    }

    /// How late a sleep may end, by three of four, ns.
    pub(crate) fn late_ns(&self) -> f64 {
        Offsets::of(self.late_ns.into_iter()).quantile(IN_TIME)
    }

    /// How much sooner than that sleeps end on average, ns.
    pub(crate) fn early_ns(&self) -> f64 {
        let allowed_ns = self.late_ns();
        let early = self.late_ns.iter().map(|late| (allowed_ns - late).max(0.0));
        early.sum::<f64>() / REMEMBERED as f64
    }

    #[cfg(test)]
    pub(crate) fn always_late_by(late_ns: i64) -> Self {
        Self { late_ns: [late_ns as f64; REMEMBERED], next: 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sleep_ends_after_its_time_and_gives_the_threads_slack_back() {
        let before = current_timer_slack().unwrap();
        let mut timer = Timer::default();
        let until_ns = monotonic_now_ns() + 2_000_000;
        timer.sleep_until(until_ns);
        assert!(monotonic_now_ns() >= until_ns);
        assert_eq!(current_timer_slack().unwrap(), before);
        assert!(timer.late_ns[0] >= 0.0 && timer.next == 1);
    }

    #[test]
    fn a_sleep_that_the_host_stretched_once_is_not_allowed_for() {
        let mut timer = Timer::always_late_by(20_000);
        timer.note(5_000_000);
        assert!((timer.late_ns() - 20_000.0).abs() < 1.0);
        assert!(timer.early_ns() < 1.0);
        // Three of four in time: rare early ends cost looking.
        timer.note(0);
        assert!(timer.early_ns() > 0.0);
    }
}
