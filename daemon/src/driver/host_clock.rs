//! A recording played as fast as it goes into a live lane.

use std::time::Duration;

use super::super::{Driver, DriverCounters, DriverInfo, Sink, SourceState};
use super::ReplayDriver;
use crate::reading::{HostTime, Reading};

/// Stamps each row with the time the host's clock shows.
///
/// Beside a live lane stand consumers, whose clock is the host's: a pose at the recording's own
/// time would be hours old or in the future, and its lane would be taken for silent.
#[derive(Debug)]
pub struct LiveReplay(ReplayDriver);

impl LiveReplay {
    /// Wraps a replay.
    pub const fn new(replay: ReplayDriver) -> Self {
        Self(replay)
    }
}

impl Driver for LiveReplay {
    fn info(&self) -> DriverInfo {
        self.0.info()
    }

    fn poll(&mut self, timeout: Duration, sink: &mut dyn Sink) -> SourceState {
        self.0.poll(timeout, &mut ByHostClock(sink))
    }

    fn counters(&self) -> DriverCounters {
        self.0.counters()
    }
}

struct ByHostClock<'a>(&'a mut dyn Sink);

impl Sink for ByHostClock<'_> {
    fn push(&mut self, reading: Reading) {
        self.0.push(Reading { arrival: HostTime::now(), ..reading });
    }
}
