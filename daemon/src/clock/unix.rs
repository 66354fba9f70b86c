//! From `CLOCK_MONOTONIC` to UNIX time.

use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};

use rustix::time::{ClockId, Timespec, clock_gettime};

/// [`unix_offset_ns`] as it was last sampled, shared by cloning: one thread refreshes it, lanes
/// only load it.
#[derive(Clone, Debug)]
pub struct UnixOffset(Arc<AtomicI64>);

impl UnixOffset {
    /// Sampled now.
    pub fn sampled() -> Self {
        Self(Arc::new(AtomicI64::new(unix_offset_ns())))
    }

    /// Samples it again.
    pub fn refresh(&self) {
        self.0.store(unix_offset_ns(), Ordering::Relaxed);
    }

    /// Add to a time on `CLOCK_MONOTONIC` to get nanoseconds since the UNIX epoch.
    pub fn as_nanos(&self) -> i64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// What to add to a time on `CLOCK_MONOTONIC` to get nanoseconds since the UNIX epoch, now.
///
/// The real-time clock is read between two readings of the monotonic one, three times; the closest
/// bracket counts. It changes whenever UNIX time is set or slewed: sample it again from time to
/// time.
pub fn unix_offset_ns() -> i64 {
    let bracketed = || {
        let before = nanos(clock_gettime(ClockId::Monotonic));
        let unix = nanos(clock_gettime(ClockId::Realtime));
        let after = nanos(clock_gettime(ClockId::Monotonic));
        (after - before, unix - before.midpoint(after))
    };
    [bracketed(), bracketed(), bracketed()].into_iter().min().map_or(0, |(_, offset)| offset)
}

fn nanos(time: Timespec) -> i64 {
    time.tv_sec.saturating_mul(1_000_000_000).saturating_add(time.tv_nsec)
}

#[cfg(test)]
mod tests {
    use std::time::{SystemTime, UNIX_EPOCH};

    use super::*;
    use crate::reading::HostTime;

    /// UNIX time may be slewed meanwhile, and a bracket is as wide as the scheduler lets it.
    const TOLERANCE_NS: i64 = 50_000_000;

    #[test]
    fn monotonic_plus_offset_lies_between_two_readings_of_unix_time() {
        let unix = || SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos() as i64;
        let earlier = unix();
        let offset = unix_offset_ns();
        let mapped = HostTime::now().as_nanos() + offset;
        assert!(mapped >= earlier - TOLERANCE_NS && mapped <= unix() + TOLERANCE_NS);
    }
}
