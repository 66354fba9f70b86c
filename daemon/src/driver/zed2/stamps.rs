//! What the time stamps of successive reports tell: repeated, missing, running back, started anew.
//!
//! The kernel's ring holds 64 reports and overflows silently, and cameras deliver 358 to 412 Hz
//! with duplicate stamps, so the stamps alone show what was lost.

use lodestone_fusion::SensorTime;

/// How a report follows the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// It is the next one; so many samples are missing in between.
    Forward {
        /// Samples missing.
        missing: u64,
    },
    /// It has the same time stamp.
    Duplicate,
    /// It is older.
    Backward,
    /// Reports older than the newest one have come for so long that the clock must have started
    /// anew (or the newest stamp was wrong).
    Restart,
}

/// Older reports in a row that prove a new start of the clock: 50 ms at 400 Hz.
const RESTART_RUN: u32 = 20;

/// The sensor's nominal period and the bounds of what is learnt about it: 400 Hz ± 12.5 %.
const NOMINAL_NS: i64 = 2_500_000;
const PERIOD_NS: std::ops::RangeInclusive<i64> = 2_222_222..=2_857_143;

/// Follows the stamps of one device.
#[derive(Clone, Debug)]
pub(super) struct Stamps {
    newest: Option<SensorTime>,
    /// The latest stamp of a run of older ones, and how long the run is.
    older: Option<(SensorTime, u32)>,
    period_ns: i64,
}

impl Default for Stamps {
    fn default() -> Self {
        Self { newest: None, older: None, period_ns: NOMINAL_NS }
    }
}

impl Stamps {
    /// Takes the next stamp.
    pub(super) fn take(&mut self, stamp: SensorTime) -> Step {
        let Some(newest) = self.newest else {
            self.newest = Some(stamp);
            return Step::Forward { missing: 0 };
        };
        let dt_ns = (stamp - newest).as_nanos();
        match dt_ns {
            0 => Step::Duplicate,
            ..0 => self.take_older(stamp),
            _ => self.take_newer(stamp, dt_ns),
        }
    }

    fn take_newer(&mut self, stamp: SensorTime, dt_ns: i64) -> Step {
        self.newest = Some(stamp);
        self.older = None;
        // Half a period more than one period: the sample between is missing.
        let missing = dt_ns.saturating_add(self.period_ns / 2) / self.period_ns - 1;
        if missing < 1 {
            // A slow mean, so that a sensor 10 % off does not turn long gaps into wrong counts.
            let learnt = self.period_ns + (dt_ns - self.period_ns) / 256;
            self.period_ns = learnt.clamp(*PERIOD_NS.start(), *PERIOD_NS.end());
        }
        Step::Forward { missing: u64::try_from(missing).unwrap_or(0) }
    }

    fn take_older(&mut self, stamp: SensorTime) -> Step {
        let run = match self.older {
            Some((last, run)) if last < stamp => run + 1,
            Some((last, run)) if last == stamp => run,
            _ => 1,
        };
        if run < RESTART_RUN {
            self.older = Some((stamp, run));
            return Step::Backward;
        }
        self.newest = Some(stamp);
        self.older = None;
        Step::Restart
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: f64) -> SensorTime {
        SensorTime::from_nanos((ms * 1e6) as i64)
    }

    #[test]
    fn given_a_steady_sensor_then_nothing_is_missing_at_any_real_rate() {
        for rate_hz in [358.0, 400.0, 412.0] {
            let mut stamps = Stamps::default();
            for i in 0..5000 {
                let step = stamps.take(at(f64::from(i) * 1000.0 / rate_hz));
                assert_eq!(step, Step::Forward { missing: 0 }, "{rate_hz} Hz, sample {i}");
            }
        }
    }

    #[test]
    fn given_a_slow_sensor_when_many_samples_are_lost_then_their_number_is_right() {
        let mut stamps = Stamps::default();
        let period_ms = 1000.0 / 358.0;
        for i in 0..3000 {
            stamps.take(at(f64::from(i) * period_ms));
        }
        assert_eq!(stamps.take(at(3100.0 * period_ms)), Step::Forward { missing: 100 });
    }

    #[test]
    fn given_a_repeated_stamp_then_it_is_a_duplicate_and_the_next_goes_on() {
        let mut stamps = Stamps::default();
        stamps.take(at(0.0));
        assert_eq!(stamps.take(at(0.0)), Step::Duplicate);
        assert_eq!(stamps.take(at(2.5)), Step::Forward { missing: 0 });
    }

    #[test]
    fn given_one_old_stamp_then_only_that_one_is_backward() {
        let mut stamps = Stamps::default();
        stamps.take(at(100.0));
        assert_eq!(stamps.take(at(97.5)), Step::Backward);
        assert_eq!(stamps.take(at(102.5)), Step::Forward { missing: 0 });
    }

    #[test]
    fn given_a_wrong_stamp_far_ahead_when_the_true_ones_go_on_then_the_clock_is_taken_anew_once() {
        let mut stamps = Stamps::default();
        stamps.take(at(0.0));
        stamps.take(at(1e9));
        let steps: Vec<Step> = (1..40).map(|i| stamps.take(at(f64::from(i) * 2.5))).collect();

        assert!(steps[..19].iter().all(|step| *step == Step::Backward));
        assert_eq!(steps[19], Step::Restart);
        assert!(steps[20..].iter().all(|step| *step == Step::Forward { missing: 0 }));
    }

    #[test]
    fn given_stamps_that_run_backwards_then_they_never_pass_for_a_new_clock() {
        let mut stamps = Stamps::default();
        stamps.take(at(1000.0));
        for i in 1..200 {
            assert_eq!(stamps.take(at(1000.0 - f64::from(i) * 2.5)), Step::Backward);
        }
    }
}
