//! Instants on the two clocks a consumer may hold.

use core::time::Duration;

use rustix::time::{ClockId, clock_gettime};

/// An instant on one of the computer's clocks.
///
/// ```
/// use lodestone_client::Time;
/// let image = Time::Unix(1_700_000_000_000_000_000);
/// // What to add to a monotonic time to get UNIX time stands in every pose.
/// assert_eq!(image.to_monotonic_ns(1_699_999_000_000_000_000), 1_000_000_000_000);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Time {
    /// `CLOCK_MONOTONIC`, ns.
    Monotonic(i64),
    /// Since the UNIX epoch (`CLOCK_REALTIME`), ns.
    Unix(i64),
}

impl Time {
    /// The instant on `CLOCK_MONOTONIC`, ns, saturating.
    ///
    /// `unix_offset_ns` is [`crate::Pose::unix_offset_ns`]: UNIX time minus monotonic time.
    pub const fn to_monotonic_ns(self, unix_offset_ns: i64) -> i64 {
        match self {
            Self::Monotonic(ns) => ns,
            Self::Unix(ns) => ns.saturating_sub(unix_offset_ns),
        }
    }
}

/// `CLOCK_MONOTONIC` now, ns.
pub fn monotonic_now_ns() -> i64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec.saturating_mul(1_000_000_000).saturating_add(now.tv_nsec)
}

/// `CLOCK_MONOTONIC` at the last tick of the kernel, ns: some milliseconds old, at a fraction of the cost.
/// For what is asked at every look and may be a little late.
pub(crate) fn coarse_now_ns() -> i64 {
    let now = clock_gettime(ClockId::MonotonicCoarse);
    now.tv_sec.saturating_mul(1_000_000_000).saturating_add(now.tv_nsec)
}

/// Time since an instant on `CLOCK_MONOTONIC`; zero if it is ahead.
pub(crate) fn age_of(time_ns: i64) -> Duration {
    let age_ns = monotonic_now_ns().saturating_sub(time_ns);
    Duration::from_nanos(u64::try_from(age_ns).unwrap_or(0))
}
