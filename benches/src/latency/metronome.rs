//! The rhythm of a camera.

use std::io;

use lodestone_client::monotonic_now_ns;
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec};

/// Between two samples of a camera: 400 Hz.
pub const STEP_NS: i64 = 2_500_000;
const SECOND_NS: i64 = 1_000_000_000;

/// Beats every [`STEP_NS`].
#[derive(Clone, Copy, Debug)]
pub struct Metronome {
    due_ns: i64,
}

impl Metronome {
    /// The first beat is one step after a time on `CLOCK_MONOTONIC`.
    pub const fn after(time_ns: i64) -> Self {
        Self { due_ns: time_ns }
    }

    /// Sleeps until the next beat; gives the time after it, ns.
    ///
    /// # Errors
    /// If a signal ends the sleep.
    pub fn wait(&mut self) -> io::Result<i64> {
        self.due_ns += STEP_NS;
        let (seconds, nanos) = (self.due_ns / SECOND_NS, self.due_ns % SECOND_NS);
        clock_nanosleep_absolute(
            ClockId::Monotonic,
            &Timespec { tv_sec: seconds, tv_nsec: nanos },
        )?;
        Ok(monotonic_now_ns())
    }
}

/// Beats in so many seconds.
pub fn beats(seconds: f64) -> usize {
    ((seconds * SECOND_NS as f64) as i64 / STEP_NS).unsigned_abs() as usize
}
