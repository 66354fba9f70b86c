//! What to do until the next pose: sleep, look, or nap.

use core::time::Duration;

use super::rhythm::{Offsets, Rhythm};
use super::timer::Timer;

/// Of a period, what looking may take on average: the price of seeing a pose at once.
const LOOK_SHARE: f64 = 1.0 / 160.0;
/// How many times the average a single look may take before it gives up, ns.
const LONGEST_LOOK: f64 = 4.0;
/// Looking begins no sooner than this before the earliest pose observed, ns.
const GUARD_NS: f64 = 3_000.0;
/// The least share of the looking that goes to the poses' jitter, where sleeps are unsure.
const LEAST_SHARE: f64 = 0.25;
/// Naps for a pose that is late, in a period.
const NAPS: f64 = 16.0;
/// So many periods after the newest pose the publisher has lost its rhythm, and so many naps of 1 ms later
/// it has stopped.
const LOST_PERIODS: f64 = 3.0;
const STOPPED_NS: i64 = 100_000_000;
const LOST_NAP: Duration = Duration::from_millis(1);
const STOPPED_NAP: Duration = Duration::from_millis(10);

/// What to do while no new pose is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rest {
    /// Look again at once.
    Look,
    /// Sleep until this time on `CLOCK_MONOTONIC`, ns, as exactly as can be.
    SleepUntil(i64),
    /// Look again after this long, more or less.
    Nap(Duration),
}

/// The way to the next pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Plan {
    newest_ns: i64,
    sleep_until_ns: i64,
    look_until_ns: i64,
    lost_at_ns: i64,
    nap: Duration,
}

impl Plan {
    /// Looks as early as the budget for looking allows, but no earlier than is of use.
    pub(crate) fn new(rhythm: &Rhythm, timer: &Timer) -> Self {
        let period_ns = rhythm.period_ns();
        let budget_ns = LOOK_SHARE * period_ns;
        // Sleeps end late; what they end early after allowing for that is looking, too.
        let lead_ns = timer.late_ns().min(period_ns / 4.0);
        let for_jitter_ns = (budget_ns - timer.early_ns()).max(LEAST_SHARE * budget_ns);
        let longest_ns = LONGEST_LOOK * budget_ns;
        let look_from_ns = earliest(rhythm.offsets(), for_jitter_ns, longest_ns);
        let at = |offset_ns: f64| rhythm.next_ns().saturating_add(offset_ns as i64);
        let lost_ns = (LOST_PERIODS * period_ns) as i64;
        Self {
            newest_ns: rhythm.newest_ns(),
            sleep_until_ns: at(look_from_ns - lead_ns),
            look_until_ns: at(look_from_ns + longest_ns),
            lost_at_ns: rhythm.newest_ns().saturating_add(lost_ns),
            nap: Duration::from_nanos((period_ns / NAPS) as u64).min(LOST_NAP),
        }
    }

    /// What to do at a time with no pose newer than those planned from.
    pub(crate) fn rest(self, now_ns: i64) -> Rest {
        match now_ns {
            // The publisher's times are not ours.
            _ if now_ns < self.newest_ns => Rest::Nap(LOST_NAP),
            _ if now_ns < self.sleep_until_ns => Rest::SleepUntil(self.sleep_until_ns),
            _ if now_ns < self.look_until_ns => Rest::Look,
            _ if now_ns < self.lost_at_ns => Rest::Nap(self.nap),
            _ if now_ns < self.lost_at_ns.saturating_add(STOPPED_NS) => Rest::Nap(LOST_NAP),
            _ => Rest::Nap(STOPPED_NAP),
        }
    }
}

/// The earliest offset from which on looking costs no more than the budget on average over the poses
/// observed; looking gives up after `longest_ns`.
fn earliest(offsets: &Offsets, budget_ns: f64, longest_ns: f64) -> f64 {
    let sorted = offsets.sorted();
    let cost_ns = |from_ns: f64| {
        let looks = sorted.iter().map(|offset| (offset - from_ns).clamp(0.0, longest_ns));
        looks.sum::<f64>() / sorted.len().max(1) as f64
    };
    let (mut early, mut late) = (offsets.quantile(0.0) - GUARD_NS, offsets.quantile(1.0));
    if cost_ns(early) <= budget_ns {
        return early;
    }
    // The cost falls from here to the last pose, where it is nothing.
    for _ in 0..20 {
        let middle = f64::midpoint(early, late);
        if cost_ns(middle) <= budget_ns { late = middle } else { early = middle }
    }
    late
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PERIOD_NS: i64 = 2_500_000;
    const NEWEST_NS: i64 = 1_000_000_000;
    /// When the next pose is due.
    const DUE_NS: i64 = NEWEST_NS + PERIOD_NS;

    /// A publisher without jitter, and a timer that is always late by this much.
    fn plan(late_ns: i64) -> Plan {
        let stamps = (-63..=0).map(|n| NEWEST_NS + n * PERIOD_NS);
        Plan::new(&Rhythm::learn(stamps).unwrap(), &Timer::always_late_by(late_ns))
    }

    #[test]
    fn sleeps_so_that_it_is_awake_shortly_before_the_pose_is_due() {
        let Rest::SleepUntil(until_ns) = plan(40_000).rest(NEWEST_NS + 10_000) else {
            panic!("does not sleep")
        };
        let awake_ns = until_ns + 40_000;
        assert!((DUE_NS - 10_000..DUE_NS).contains(&awake_ns), "{}", awake_ns - DUE_NS);
    }

    #[test]
    fn looks_around_the_time_and_no_longer_than_its_budget() {
        let plan = plan(40_000);
        assert_eq!(plan.rest(DUE_NS), Rest::Look);
        assert_eq!(plan.rest(DUE_NS + PERIOD_NS / 10), Rest::Nap(Duration::from_nanos(156_250)));
    }

    #[test]
    fn naps_longer_when_the_publisher_has_lost_its_rhythm_and_longer_still_when_it_has_stopped() {
        let plan = plan(0);
        assert_eq!(plan.rest(DUE_NS + 3 * PERIOD_NS), Rest::Nap(LOST_NAP));
        assert_eq!(plan.rest(DUE_NS + 1_000_000_000), Rest::Nap(STOPPED_NAP));
        // Times of another clock.
        assert_eq!(plan.rest(0), Rest::Nap(LOST_NAP));
    }

    proptest! {
        #[test]
        fn looking_stays_within_its_budget_and_is_never_too_early(
            offsets in prop::collection::vec(-1e6..1e6_f64, 1..64),
            budget_ns in 1.0..1e5_f64,
        ) {
            let longest_ns = 4.0 * budget_ns;
            let offsets = Offsets::of(offsets.into_iter());
            let from_ns = earliest(&offsets, budget_ns, longest_ns);
            let looks = offsets.sorted().iter().map(|o| (o - from_ns).clamp(0.0, longest_ns));
            let mean_ns = looks.sum::<f64>() / offsets.sorted().len() as f64;
            prop_assert!(mean_ns <= budget_ns * 1.001, "{mean_ns} of {budget_ns}");
            prop_assert!(from_ns >= offsets.quantile(0.0) - GUARD_NS);
        }
    }
}
