//! The sensor's clock against the time of the world.

use lodestone_fusion::SensorTime;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Half a tick of the ZED 2's clock in ns: one is 39.0625 µs (zed2-protocol.md, offset 2).
const TWO_TICKS_NS: i64 = 78_125;

/// Nanoseconds since an arbitrary origin, a little too fast or too slow, in whole ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SensorClock {
    origin_ns: i64,
    rate: f64,
    ticks: bool,
}

impl SensorClock {
    /// A clock that runs (1 + `error`) times as fast as the world, since some minutes to an hour
    /// before the source began; `ticks` rounds down to the ZED 2's.
    pub(crate) fn drawn(error: f64, ticks: bool, rng: &mut ChaCha8Rng) -> Self {
        // 3 to 60 minutes in pairs of ticks.
        let pairs = rng.random_range(2_304_000..46_080_000_i64);
        Self { origin_ns: pairs * TWO_TICKS_NS, rate: 1.0 + error, ticks }
    }

    /// What the clock shows at a time since the source began, s.
    pub(crate) fn stamp(&self, time_s: f64) -> SensorTime {
        let shown_ns = self.origin_ns + (time_s * self.rate * 1e9).round() as i64;
        if !self.ticks {
            return SensorTime::from_nanos(shown_ns);
        }
        let ticks = (2 * shown_ns).div_euclid(TWO_TICKS_NS);
        SensorTime::from_nanos(ticks * TWO_TICKS_NS / 2)
    }

    /// The time since the source began, s, at which the clock shows a time.
    pub(crate) fn world_time_s(&self, stamp: SensorTime) -> f64 {
        (stamp - SensorTime::from_nanos(self.origin_ns)).as_secs_f64() / self.rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand::SeedableRng;

    proptest! {
        #[test]
        fn there_and_back_is_the_same_time(seed: u64, t in 0.0..1e6f64, error in -1e-3..1e-3f64) {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let exact = SensorClock::drawn(error, false, &mut rng);
            prop_assert!((exact.world_time_s(exact.stamp(t)) - t).abs() < 2e-9);
            let ticking = SensorClock { ticks: true, ..exact };
            let late = t - ticking.world_time_s(ticking.stamp(t));
            prop_assert!((-2e-9..39.2e-6).contains(&late), "{late}");
        }
    }

    #[test]
    fn nominal_samples_fall_on_ticks() {
        let clock = SensorClock::drawn(0.0, true, &mut ChaCha8Rng::seed_from_u64(1));
        let first = clock.stamp(0.0);
        assert!(first.as_nanos() > 0);
        for k in 0..4000_i64 {
            let span = clock.stamp(k as f64 * 0.0025) - first;
            assert_eq!(span.as_nanos(), k * 2_500_000);
        }
    }
}
