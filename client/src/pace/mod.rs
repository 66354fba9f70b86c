//! When the next pose is due, and how to wait for it at hardly any cost.
//!
//! ```text
//! stamps of the last poses ─> Rhythm (when they come) ─┐
//! lateness of the last sleeps ─> Timer ────────────────┴─> Plan: sleep, look, nap
//! ```
//!
//! A consumer that polls sees a pose at once and costs a processor; one that is woken pays for the
//! wake-up after the pose is there. This one pays for it before: it sleeps until shortly before the pose
//! is due and looks from then on. How much sooner is worth its cost is what the poses' own jitter
//! and the sleeps' own lateness say.

mod plan;
mod rhythm;
mod timer;

use core::time::Duration;
use std::thread::sleep;

pub(crate) use plan::{Plan, Rest};
pub(crate) use rhythm::{OBSERVED, Rhythm};
pub(crate) use timer::Timer;

use crate::history::History;
use crate::time::monotonic_now_ns;

/// Before a rhythm is known.
const UNKNOWN_NAP: Duration = Duration::from_millis(1);
/// Without a connection, or when the publisher has stopped.
const IDLE_NAP: Duration = Duration::from_millis(10);

/// Waits between two looks at a stream of poses.
#[derive(Debug, Default)]
pub(crate) struct Vigil {
    timer: Timer,
    /// For the pose after those taken so far.
    plan: Option<(u64, Plan)>,
}

impl Vigil {
    /// Passes the time until the next look is worth while, but not beyond `latest_ns`.
    pub(crate) fn rest(&mut self, history: &History, connected: bool, latest_ns: i64) {
        let now_ns = monotonic_now_ns();
        let rest = match self.plan_for(history) {
            Some(plan) => plan.rest(now_ns),
            None => Rest::Nap(if connected { UNKNOWN_NAP } else { IDLE_NAP }),
        };
        let left = Duration::from_nanos(u64::try_from(latest_ns - now_ns).unwrap_or(0));
        match rest {
            Rest::Look => core::hint::spin_loop(),
            Rest::SleepUntil(time_ns) if time_ns < latest_ns => self.timer.sleep_until(time_ns),
            Rest::SleepUntil(_) => sleep(left),
            Rest::Nap(nap) => sleep(nap.min(left)),
        }
    }

    /// The plan for the pose after the newest; made once for each.
    fn plan_for(&mut self, history: &History) -> Option<Plan> {
        let taken = history.taken();
        if let Some((for_taken, plan)) = self.plan
            && for_taken == taken
        {
            return Some(plan);
        }
        let stamps = history.recent(OBSERVED).map(|pose| pose.message().published_time_ns);
        let plan = Rhythm::learn(stamps).map(|rhythm| Plan::new(&rhythm, &self.timer))?;
        self.plan = Some((taken, plan));
        Some(plan)
    }
}
