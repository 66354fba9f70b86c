//! A driver on its own, and what may be expected of its readings.

use std::time::{Duration, Instant};

use lodestone_daemon::driver::zed2::Zed2;
use lodestone_daemon::driver::{Driver, SourceState};
use lodestone_daemon::reading::Reading;
use lodestone_tests::virtual_zed2::TICKS_PER_SAMPLE;

use crate::{PATIENCE, POLL, ensure, text};

/// One step of the gyroscope's raw value, rad/s.
const RAD_S: f64 = 1000.0 / 32768.0 * std::f64::consts::PI / 180.0;

/// A driver and all it has given.
pub(crate) struct Lane {
    pub(crate) driver: Zed2,
    pub(crate) readings: Vec<Reading>,
}

impl Lane {
    pub(crate) fn open(serial: u64) -> Result<Self, String> {
        Ok(Self { driver: Zed2::open(serial).map_err(text)?, readings: Vec::new() })
    }

    pub(crate) fn poll(&mut self, timeout: Duration) -> SourceState {
        self.driver.poll(timeout, &mut self.readings)
    }

    /// Polls until `done`, or patience ends.
    pub(crate) fn poll_until(
        &mut self,
        what: &str,
        mut done: impl FnMut(&Self, SourceState) -> bool,
    ) -> Result<Duration, String> {
        let start = Instant::now();
        while start.elapsed() < PATIENCE {
            let state = self.poll(POLL);
            if done(self, state) {
                return Ok(start.elapsed());
            }
        }
        Err(format!("{what} did not happen: {:?}", self.driver.counters()))
    }

    pub(crate) fn take(&mut self, samples: usize) -> Result<(), String> {
        let goal = self.readings.len() + samples;
        self.poll_until("streaming", |lane, _| lane.readings.len() >= goal).map(drop)
    }

    pub(crate) fn ensure_only(&self, mark: i16) -> Result<(), String> {
        let expected = f64::from(mark) * RAD_S;
        let stranger = self.readings.iter().find(|r| (r.gyro.vector.x - expected).abs() > 1e-12);
        ensure(stranger.is_none(), || format!("a sample of another camera: {stranger:?}"))
    }

    /// The samples in sensor time from `from` on: none missing, none twice.
    pub(crate) fn ensure_unbroken(&self, from: usize) -> Result<(), String> {
        let period = i64::try_from(TICKS_PER_SAMPLE).map_err(text)? * 78_125 / 2;
        let breaks = self.readings[from..]
            .windows(2)
            .filter(|pair| (pair[1].sensor_time - pair[0].sensor_time).as_nanos() != period)
            .count();
        ensure(breaks == 0, || format!("{breaks} breaks: {:?}", self.driver.counters()))
    }

    /// Samples per second by arrival, from a reading on.
    pub(crate) fn rate_hz(&self, from: usize) -> f64 {
        let readings = &self.readings[from..];
        let (Some(first), Some(last)) = (readings.first(), readings.last()) else {
            return 0.0;
        };
        let span_ns = last.arrival.as_nanos() - first.arrival.as_nanos();
        (readings.len() - 1) as f64 * 1e9 / span_ns as f64
    }
}
