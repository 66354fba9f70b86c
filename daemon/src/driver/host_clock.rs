//! A source that runs as fast as it goes, in a live lane.

use std::time::Duration;

use super::{Driver, DriverCounters, DriverInfo, Sink, SourceState};
use crate::reading::{HostTime, Reading};

/// Stamps each reading with the time the host's clock shows when it is handed on.
///
/// A recording or a simulated world without a pace has its own clock for the host's. Beside a live
/// lane stand consumers, whose clock is the host's: such a pose would be hours old or in the future,
/// and its lane would be taken for silent.
#[derive(Debug)]
pub struct OnHostClock<D>(pub D);

impl<D: Driver> Driver for OnHostClock<D> {
    fn info(&self) -> DriverInfo {
        self.0.info()
    }

    fn poll(&mut self, timeout: Duration, sink: &mut dyn Sink) -> SourceState {
        self.0.poll(timeout, &mut Stamping(sink))
    }

    fn counters(&self) -> DriverCounters {
        self.0.counters()
    }
}

struct Stamping<'a>(&'a mut dyn Sink);

impl Sink for Stamping<'_> {
    fn push(&mut self, reading: Reading) {
        self.0.push(Reading { arrival: HostTime::now(), ..reading });
    }
}
