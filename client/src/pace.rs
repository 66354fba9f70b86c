//! When the next pose is due, and how to wait for it.

use core::time::Duration;

use crate::pose::CameraPose;

/// Poses whose times give the publisher's step and delay.
pub(crate) const OBSERVED: usize = 32;
/// The sleep ends this long before the pose is due: a timer is late by its slack of 50 µs.
const EARLY_NS: i64 = 100_000;
/// Polled without sleeping until this long after the pose was due.
const LATE_NS: i64 = 100_000;
const SHORT_NAP: Duration = Duration::from_micros(100);
const LONG_NAP: Duration = Duration::from_millis(1);
const IDLE_NAP: Duration = Duration::from_millis(10);

/// What to do while no new pose is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rest {
    /// Look again at once.
    Spin,
    /// Look again after this long.
    Nap(Duration),
}

/// The rhythm of a publisher.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Pace {
    step_ns: i64,
    /// When the next pose should be published, `CLOCK_MONOTONIC`.
    due_ns: i64,
}

impl Pace {
    /// Learns step and delay from neighbouring poses, oldest first.
    ///
    /// The step is the mean over all of them, by sequence, so that a lost pose does not count; the
    /// delay from time of validity to publication is the smallest seen, so that none is missed.
    pub(crate) fn learn<'a>(poses: impl Iterator<Item = &'a CameraPose> + Clone) -> Option<Self> {
        let first = poses.clone().next()?;
        let newest = poses.clone().last()?;
        let steps = i64::try_from(newest.sequence().checked_sub(first.sequence())?).ok()?;
        let span_ns = newest.time_ns().checked_sub(first.time_ns())?;
        let step_ns = span_ns.checked_div(steps).filter(|step| *step > 0)?;
        let delay =
            |pose: &CameraPose| pose.message().published_time_ns.saturating_sub(pose.time_ns());
        let delay_ns = poses.map(delay).min()?;
        let due_ns = newest.time_ns().saturating_add(step_ns).saturating_add(delay_ns);
        Some(Self { step_ns, due_ns })
    }

    /// What to do at a time with no pose newer than those learnt from.
    pub(crate) fn rest(self, now_ns: i64) -> Rest {
        let to_go_ns = self.due_ns.saturating_sub(now_ns);
        // A publisher that is a whole step late has lost its rhythm, or its times are not ours.
        let in_step = to_go_ns.unsigned_abs() <= 2 * self.step_ns.unsigned_abs();
        match to_go_ns {
            _ if !in_step => Rest::Nap(LONG_NAP),
            EARLY_NS.. => Rest::Nap(Duration::from_nanos((to_go_ns - EARLY_NS).unsigned_abs())),
            _ if to_go_ns > -LATE_NS => Rest::Spin,
            _ => Rest::Nap(SHORT_NAP),
        }
    }

    /// What to do without a rhythm.
    pub(crate) const fn rest_without(connected: bool) -> Rest {
        Rest::Nap(if connected { LONG_NAP } else { IDLE_NAP })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DUE_NS: i64 = 1_003_000_000;
    const PACE: Pace = Pace { step_ns: 2_500_000, due_ns: DUE_NS };

    #[test]
    fn step_and_delay_are_learnt_across_lost_poses() {
        use crate::pose::samples::{checked, still};
        use lodestone_schema::Pose;
        // Given poses of a step of 2.5 ms, published 0.5 to 0.7 ms after their time
        let pose = |sequence: u64, delay_ns: i64| {
            let time_ns = 995_000_000 + 2_500_000 * sequence as i64;
            let published_time_ns = time_ns + delay_ns;
            checked(Pose { published_time_ns, ..still(sequence, time_ns) })
        };
        let poses = [pose(0, 600_000), pose(1, 500_000), pose(2, 700_000)];
        let with_loss = [poses[0], poses[2]];
        assert_eq!(Pace::learn(poses.iter()).unwrap().due_ns, DUE_NS);
        assert_eq!(Pace::learn(with_loss.iter()).unwrap().step_ns, 2_500_000);
        assert_eq!(Pace::learn(poses[..1].iter()), None);
    }

    #[test]
    fn sleeps_until_shortly_before_the_pose_is_due() {
        let rest = PACE.rest(DUE_NS - 1_100_000);
        assert_eq!(rest, Rest::Nap(Duration::from_millis(1)));
    }

    #[test]
    fn polls_around_the_time_and_no_longer() {
        assert_eq!(PACE.rest(DUE_NS - 50_000), Rest::Spin);
        assert_eq!(PACE.rest(DUE_NS + 50_000), Rest::Spin);
        assert_eq!(PACE.rest(DUE_NS + 200_000), Rest::Nap(SHORT_NAP));
    }

    #[test]
    fn naps_when_the_publisher_has_stopped_or_replays_old_times() {
        assert_eq!(PACE.rest(DUE_NS + 1_000_000_000), Rest::Nap(LONG_NAP));
        assert_eq!(PACE.rest(0), Rest::Nap(LONG_NAP));
    }
}
