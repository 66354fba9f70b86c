//! How a loop on a thread of its own waits for its driver's readings.

use std::thread;
use std::time::Duration;

use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec};

use crate::reading::HostTime;
use crate::ring::Consumer;

/// The sleep ends this long before a reading is due: timers are late by some tens of µs.
const EARLY_NS: i64 = 100_000;
/// Looked for until this long after it was due; then the loop sleeps until it is woken.
const LATE_NS: i64 = 200_000;

/// The two ways.
#[derive(Clone, Copy, Debug)]
pub(crate) enum HandOver {
    /// Sleep until the driver wakes the loop.
    WakeUp,
    /// Sleep until just before the next reading is due, then look.
    Timed(Rhythm),
}

impl HandOver {
    /// Waits until a reading is in the ring, it is closed, or `timeout` has passed; may return early.
    pub(crate) fn wait(&self, consumer: &mut Consumer, timeout: Duration) {
        if let Self::Timed(rhythm) = self
            && let Some(until) = rhythm.look_until(HostTime::now())
        {
            sleep_until(rhythm.due_ns.unwrap_or(0) - EARLY_NS);
            while consumer.is_empty() && !consumer.is_closed() && HostTime::now() < until {
                // Where both threads share a core, the driver must get it.
                thread::yield_now();
            }
            if !consumer.is_empty() {
                return;
            }
        }
        consumer.wait(timeout);
    }

    /// Takes note of when a reading arrived.
    pub(crate) const fn note(&mut self, arrival: HostTime) {
        if let Self::Timed(rhythm) = self {
            rhythm.note(arrival);
        }
    }
}

/// When readings come: a phase-locked loop on their arrivals.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rhythm {
    interval_ns: i64,
    /// When the next one should arrive; none before the first.
    due_ns: Option<i64>,
}

impl Rhythm {
    /// Expects readings at a rate.
    pub(crate) fn new(rate_hz: f64) -> Self {
        Self { interval_ns: (1e9 / rate_hz) as i64, due_ns: None }
    }

    /// Corrects phase and interval by how far off the expectation was; what is off by more than
    /// half an interval begins anew.
    const fn note(&mut self, arrival: HostTime) {
        let at_ns = arrival.as_nanos();
        let due_ns = match self.due_ns {
            Some(due_ns) => due_ns,
            None => at_ns,
        };
        let error_ns = at_ns.saturating_sub(due_ns);
        if error_ns.saturating_abs() > self.interval_ns / 2 {
            self.due_ns = Some(at_ns.saturating_add(self.interval_ns));
            return;
        }
        // Damped a little more than critically; drifts are some parts in a thousand.
        self.interval_ns += error_ns / 64;
        self.due_ns = Some(due_ns + error_ns / 4 + self.interval_ns);
    }

    /// Until when to look for the next reading; `None` if it is too late for that, or nothing is
    /// known of it.
    fn look_until(&self, now: HostTime) -> Option<HostTime> {
        let until_ns = self.due_ns?.saturating_add(LATE_NS);
        (now.as_nanos() < until_ns).then(|| HostTime::from_nanos(until_ns))
    }
}

fn sleep_until(time_ns: i64) {
    const SECOND_NS: i64 = 1_000_000_000;
    let time =
        Timespec { tv_sec: time_ns.div_euclid(SECOND_NS), tv_nsec: time_ns.rem_euclid(SECOND_NS) };
    // A signal may end it early; then the loop looks for a little longer.
    let _ = clock_nanosleep_absolute(ClockId::Monotonic, &time);
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use glam::DVec3;
    use lodestone_fusion::{Accel, Gyro, SensorTime};

    use super::*;
    use crate::driver::Sink;
    use crate::reading::{Reading, RecordedAiding};
    use crate::ring::ring;

    const STEP_NS: i64 = 2_500_000;

    fn at(ns: i64) -> HostTime {
        HostTime::from_nanos(ns)
    }

    #[test]
    fn a_rhythm_follows_a_source_that_runs_fast_and_jitters() {
        // Given a source that is fast by 2 % and late by up to 40 µs, without a pattern
        let mut rhythm = Rhythm::new(400.0);
        let arrival = |n: i64| 2_450_000 * n + 40_000 * (n * 7 % 11) / 11;
        let mut worst_ns = 0;
        for n in 0..2000 {
            if n > 200 {
                worst_ns = worst_ns.max((arrival(n) - rhythm.due_ns.unwrap()).abs());
            }
            rhythm.note(at(arrival(n)));
        }
        assert!(worst_ns < EARLY_NS / 2, "{worst_ns} ns off");
    }

    #[test]
    fn after_a_gap_the_rhythm_begins_anew() {
        let mut rhythm = Rhythm::new(400.0);
        (0..100).for_each(|n| rhythm.note(at(n * STEP_NS)));
        rhythm.note(at(10_000_000_000));
        assert!((rhythm.due_ns.unwrap() - 10_000_000_000 - STEP_NS).abs() < 100_000);
    }

    #[test]
    fn nothing_is_looked_for_before_the_first_reading_or_long_after_one_is_due() {
        let mut rhythm = Rhythm::new(400.0);
        assert_eq!(rhythm.look_until(at(0)), None);
        rhythm.note(at(0));
        assert_eq!(rhythm.look_until(at(1)), Some(at(STEP_NS + LATE_NS)));
        assert_eq!(rhythm.look_until(at(STEP_NS + LATE_NS)), None);
    }

    fn reading(arrival: HostTime) -> Reading {
        Reading {
            epoch: 0,
            sensor_time: SensorTime::from_nanos(0),
            arrival,
            gyro: Gyro::new(DVec3::ZERO),
            accel: Accel::new(DVec3::ZERO),
            mag: None,
            temperature_c: None,
            saturated: false,
            aiding: RecordedAiding::NONE,
        }
    }

    #[test]
    fn a_reading_that_comes_when_it_is_due_or_much_later_ends_the_wait() {
        // Given a loop that knows the rhythm, and a driver that keeps it once and then stalls
        let (mut producer, mut consumer) = ring(8);
        let mut hand_over = HandOver::Timed(Rhythm::new(400.0));
        hand_over.note(HostTime::now());
        let driver = thread::spawn(move || {
            for pause_ms in [2, 50] {
                thread::sleep(Duration::from_millis(pause_ms));
                producer.push(reading(HostTime::now()));
            }
            producer
        });
        for _ in 0..2 {
            let begin = Instant::now();
            while consumer.is_empty() && begin.elapsed() < Duration::from_mins(1) {
                hand_over.wait(&mut consumer, Duration::from_mins(1));
            }
            let reading = consumer.pop().expect("a reading");
            hand_over.note(reading.arrival);
        }
        // When the driver ends, the wait ends too
        drop(driver.join());
        hand_over.wait(&mut consumer, Duration::MAX);
        assert!(consumer.is_closed());
    }
}
