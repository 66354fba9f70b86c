//! How the world's time passes on this computer.

use std::time::Duration;

use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec};

use crate::reading::HostTime;

/// The world's time on the host's clock.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Pace {
    /// As fast as it goes: the host's clock is the world's time, beginning at 0.
    Unbounded,
    /// `speed` seconds of the world a second, from the first poll on.
    Timed {
        /// 1 is real speed.
        speed: f64,
        /// When the world began.
        start: Option<HostTime>,
    },
}

/// What is due: everything, or what the clock has reached.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Due {
    /// Everything, each sample at its own time.
    All,
    /// What arrives until now.
    Until(HostTime),
}

impl Pace {
    /// The pace of a configured speed.
    pub(crate) fn new(speed: f64) -> Self {
        if speed > 0.0 { Self::Timed { speed, start: None } } else { Self::Unbounded }
    }

    /// Waits until a world time, but no longer than `timeout`, and says what is due.
    pub(crate) fn wait(&mut self, due_s: f64, timeout: Duration) -> Due {
        let Self::Timed { start, .. } = self else { return Due::All };
        let now = HostTime::now();
        start.get_or_insert(now);
        let wake = self.host_time(due_s).min(later(now, timeout));
        if wake <= now {
            return Due::Until(now);
        }
        // A signal ends the sleep early, which gives the caller the chance to stop: no retry.
        let _ = clock_nanosleep_absolute(ClockId::Monotonic, &timespec(wake));
        Due::Until(HostTime::now())
    }

    /// When a world time is on the host's clock.
    pub(crate) fn host_time(&self, due_s: f64) -> HostTime {
        match *self {
            Self::Unbounded => HostTime::from_nanos(nanos(due_s)),
            Self::Timed { speed, start } => {
                let origin = start.unwrap_or_default().as_nanos();
                HostTime::from_nanos(origin.saturating_add(nanos(due_s / speed)))
            }
        }
    }
}

fn nanos(seconds: f64) -> i64 {
    (seconds * 1e9).round() as i64
}

fn later(now: HostTime, span: Duration) -> HostTime {
    let span = i64::try_from(span.as_nanos()).unwrap_or(i64::MAX);
    HostTime::from_nanos(now.as_nanos().saturating_add(span))
}

fn timespec(time: HostTime) -> Timespec {
    const SECOND: i64 = 1_000_000_000;
    let nanos = time.as_nanos();
    Timespec { tv_sec: nanos.div_euclid(SECOND), tv_nsec: nanos.rem_euclid(SECOND) }
}
