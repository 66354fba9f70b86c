//! Where samples come from: one trait, one module per source.
//!
//! A driver is polled from one thread. It blocks inside [`Driver::poll`] for at most the time it
//! is given, pushes what has arrived into the sink, oldest first, and says how the source is. It
//! allocates nothing after it was opened, except while it looks for a lost device.

pub mod faulty;
pub mod host_clock;
pub mod replay;
pub mod synthetic;
pub mod zed2;

use std::time::Duration;

use crate::reading::Reading;

/// Most readings that a source which could go on for ever (a recording, a simulated world) hands on
/// in one poll: the least `lane.ring_capacity`. A lane on one thread empties its ring between polls
/// only, so more of them would push readings out of a small ring.
const BATCH: usize = 16;

/// Takes readings, oldest first. The lane's ring is one; a `Vec` is another, for tests.
pub trait Sink {
    /// Takes one reading; never blocks.
    fn push(&mut self, reading: Reading);
}

impl Sink for Vec<Reading> {
    fn push(&mut self, reading: Reading) {
        Self::push(self, reading);
    }
}

/// How the source is after a poll.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceState {
    /// The source is open; samples came, or may come.
    Streaming,
    /// The device is not there or does not answer; the driver looks for it by itself in later polls.
    Lost,
    /// There will be no more samples.
    Ended,
}

/// What a driver counted since it was made. Nothing decreases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DriverCounters {
    /// Reports that could not be read as a sample.
    pub malformed: u64,
    /// Reports marked invalid by the device itself.
    pub marked_invalid: u64,
    /// Times the device was lost and opened again.
    pub reconnects: u64,
    /// Reports that repeat the time stamp before; the driver keeps them back.
    pub duplicates: u64,
    /// Reports whose time stamp is older than the one before; handed on for the lane to refuse.
    pub backwards: u64,
    /// Times that at least one sample is missing by the time stamps.
    pub gaps: u64,
    /// Samples missing by the time stamps, all gaps together.
    pub samples_missing: u64,
    /// Times the device's clock started anew without the device being lost.
    pub clock_restarts: u64,
    /// Times the stream had to be started again because no report came.
    pub stream_restarts: u64,
    /// Keep-alive messages the device took.
    pub pings: u64,
    /// Keep-alive messages that failed.
    pub pings_failed: u64,
}

/// What a source says about itself.
#[derive(Clone, Debug, PartialEq)]
pub struct DriverInfo {
    /// What a person calls it: `ZED 2 (firmware 3.9)`, `synthetic walk`, a file's path.
    pub description: String,
    /// Serial number, where there is one.
    pub serial: Option<u64>,
    /// Samples per second the source means to deliver.
    pub nominal_rate_hz: f64,
}

/// A source of samples.
pub trait Driver: Send {
    /// What is known of the source now.
    fn info(&self) -> DriverInfo;

    /// Waits at most `timeout` for samples and pushes all that have arrived.
    fn poll(&mut self, timeout: Duration, sink: &mut dyn Sink) -> SourceState;

    /// What was counted so far.
    fn counters(&self) -> DriverCounters;
}

impl<D: Driver + ?Sized> Driver for Box<D> {
    fn info(&self) -> DriverInfo {
        (**self).info()
    }

    fn poll(&mut self, timeout: Duration, sink: &mut dyn Sink) -> SourceState {
        (**self).poll(timeout, sink)
    }

    fn counters(&self) -> DriverCounters {
        (**self).counters()
    }
}
