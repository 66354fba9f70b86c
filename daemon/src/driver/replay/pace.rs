//! When a row of a recording is due.

use std::time::Duration;

use lodestone_fusion::SensorTime;
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec};

use crate::reading::HostTime;

/// Step of the recording's time, forwards or backwards, that is not waited for: its clock was set,
/// or its recorder paused. ns of the recording.
const LONGEST_WAIT_NS: i64 = 10_000_000_000;

/// Turns the times of rows into times of the host.
#[derive(Debug)]
pub(super) struct Pace {
    /// Sensor seconds in a second of the host; 0 has the recording's clock for the host's.
    speed: f64,
    /// Nominal time between rows, ns of the recording.
    interval_ns: f64,
    /// A row's time, and when it is due.
    anchor: Option<(SensorTime, HostTime)>,
    /// The row scheduled last, and when it is due.
    last: Option<(SensorTime, HostTime)>,
}

impl Pace {
    pub(super) const fn new(speed: f64, rate_hz: f64) -> Self {
        Self { speed, interval_ns: 1e9 / rate_hz, anchor: None, last: None }
    }

    pub(super) fn is_real_time(&self) -> bool {
        self.speed > 0.0
    }

    /// The recording begins again: its first row follows the last at the nominal interval.
    pub(super) const fn begin_round(&mut self) {
        self.anchor = None;
    }

    /// When the row that follows the last scheduled one is due; never waits.
    pub(super) fn schedule(&mut self, time: SensorTime) -> HostTime {
        if self.is_real_time() && self.leaps(time) {
            self.anchor = None;
        }
        let (origin, start) = self.anchor.unwrap_or_else(|| (time, self.start(time)));
        self.anchor = Some((origin, start));
        let due = later(start, self.host_nanos((time - origin).as_nanos()));
        self.last = Some((time, due));
        due
    }

    /// Whether the recording's clock made a step that is not to be waited for.
    fn leaps(&self, time: SensorTime) -> bool {
        self.last.is_some_and(|(last, _)| {
            (time - last).as_nanos().unsigned_abs() > LONGEST_WAIT_NS.unsigned_abs()
        })
    }

    /// When a row is due that has no predecessor to be measured from.
    fn start(&self, time: SensorTime) -> HostTime {
        match self.last {
            Some((_, due)) => later(due, self.host_nanos(self.interval_ns as i64)),
            None if self.is_real_time() => HostTime::now(),
            None => HostTime::from_nanos(time.as_nanos()),
        }
    }

    /// How long a span of the recording lasts on the host.
    fn host_nanos(&self, span_ns: i64) -> i64 {
        #[allow(clippy::float_cmp, reason = "1 is what was configured, not computed")]
        let unscaled = !self.is_real_time() || self.speed == 1.0;
        if unscaled { span_ns } else { (span_ns as f64 / self.speed).round() as i64 }
    }

    /// Waits for what is due, at most until the deadline; when it arrived, or `None` if not yet.
    pub(super) fn arrival(&self, due: HostTime, deadline: HostTime) -> Option<HostTime> {
        if !self.is_real_time() {
            return Some(due);
        }
        let mut now = HostTime::now();
        if now < due && now < deadline {
            sleep_until(due.min(deadline));
            now = HostTime::now();
        }
        (now >= due).then_some(now)
    }

    /// The end of a wait that begins now.
    pub(super) fn deadline(timeout: Duration) -> HostTime {
        later(HostTime::now(), i64::try_from(timeout.as_nanos()).unwrap_or(i64::MAX))
    }
}

fn later(time: HostTime, nanos: i64) -> HostTime {
    HostTime::from_nanos(time.as_nanos().saturating_add(nanos))
}

/// Sleeps; a signal ends the sleep early, which the caller sees by the clock.
fn sleep_until(time: HostTime) {
    let nanos = time.as_nanos();
    let request = Timespec {
        tv_sec: nanos.div_euclid(1_000_000_000),
        tv_nsec: nanos.rem_euclid(1_000_000_000),
    };
    let _ = clock_nanosleep_absolute(ClockId::Monotonic, &request);
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    fn dues(pace: &mut Pace, times_ms: &[i64]) -> Vec<i64> {
        times_ms
            .iter()
            .map(|&ms| pace.schedule(SensorTime::from_nanos(ms * MS)).as_nanos())
            .collect()
    }

    /// Due times against the first one, ms.
    fn relative(speed: f64, times_ms: &[i64]) -> Vec<i64> {
        let dues = dues(&mut Pace::new(speed, 100.0), times_ms);
        dues.iter().map(|due| (due - dues[0]) / MS).collect()
    }

    #[test]
    fn without_a_speed_the_clock_is_the_recordings_whatever_it_does() {
        let times = [5_000, 5_010, 4_000, 9_000_000, 5_020];
        let expected = times.map(|ms| ms * MS);
        assert_eq!(dues(&mut Pace::new(0.0, 100.0), &times), expected);
    }

    #[test]
    fn without_a_speed_the_next_round_follows_the_last_row_by_an_interval() {
        let mut pace = Pace::new(0.0, 100.0);
        dues(&mut pace, &[1_000, 1_010]);
        pace.begin_round();
        assert_eq!(dues(&mut pace, &[1_000, 1_010]), [1_020 * MS, 1_030 * MS]);
    }

    #[test]
    fn rows_are_due_at_the_recordings_pace_over_the_speed() {
        let times = [7_000, 7_010, 7_005, 12_000];
        assert_eq!(relative(1.0, &times), [0, 10, 5, 5_000]);
        assert_eq!(relative(2.5, &times), [0, 4, 2, 2_000]);
        assert_eq!(relative(0.5, &times), [0, 20, 10, 10_000]);
    }

    #[test]
    fn given_a_leap_of_the_recordings_clock_then_it_is_not_waited_for() {
        let times = [0, 10, 3_600_000, 3_600_010, 20, 30];
        assert_eq!(relative(1.0, &times), [0, 10, 20, 30, 40, 50]);
    }

    #[test]
    fn a_row_that_is_not_due_by_the_deadline_does_not_arrive() {
        let pace = Pace::new(1.0, 100.0);
        let due = later(HostTime::now(), 3_600_000 * MS);
        assert_eq!(pace.arrival(due, Pace::deadline(Duration::from_millis(2))), None);
        let soon = later(HostTime::now(), 2 * MS);
        let arrived = pace.arrival(soon, Pace::deadline(Duration::from_mins(1))).unwrap();
        assert!(arrived >= soon);
    }
}
