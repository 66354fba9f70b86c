//! What faults do to the order, the number and the arrival of samples.

use lodestone_config::model::{Fault, FaultKind};

use crate::driver::Sink;
use crate::reading::{HostTime, Reading};

/// Room for samples beyond what a stall needs at the nominal rate.
const SPARE: f64 = 64.0;

/// Most samples that a stall holds: 11 minutes at 400 Hz.
const MOST: f64 = 262_144.0;

/// Samples to hold for the longest stall of a list, with a quarter in reserve for a fast sensor.
pub(super) fn stall_capacity(faults: &[Fault], rate_hz: f64) -> usize {
    let stalls = faults.iter().filter(|fault| fault.kind == FaultKind::Stall);
    let together_s: f64 = stalls.map(|fault| fault.duration_s).sum();
    if together_s > 0.0 { (together_s * rate_hz * 1.25 + SPARE).min(MOST) as usize } else { 0 }
}

/// Reorders, doubles and holds up samples.
pub(super) struct Flow {
    /// Change places with the next sample.
    pub(super) reorder: bool,
    /// Come twice.
    pub(super) duplicate: bool,
    /// Wait.
    pub(super) stall: bool,
    /// The sample that lets its neighbour go first.
    waiting: Option<Reading>,
    /// The samples held up, oldest first; never grows.
    held: Vec<Reading>,
}

impl Flow {
    pub(super) fn with_capacity(capacity: usize) -> Self {
        Self {
            reorder: false,
            duplicate: false,
            stall: false,
            waiting: None,
            held: Vec::with_capacity(capacity),
        }
    }

    /// Sends a sample on its way.
    pub(super) fn take(&mut self, reading: Reading, sink: &mut dyn Sink) {
        if let Some(late) = self.waiting.take() {
            self.double(reading, sink);
            self.double(Reading { arrival: reading.arrival, ..late }, sink);
        } else if self.reorder {
            self.waiting = Some(reading);
        } else {
            self.double(reading, sink);
        }
    }

    /// Lets out what is still inside: the source has ended.
    pub(super) fn end(&mut self, sink: &mut dyn Sink) {
        if let Some(late) = self.waiting.take() {
            self.double(late, sink);
        }
        if let Some(arrival) = self.held.last().map(|reading| reading.arrival) {
            self.burst(arrival, sink);
        }
    }

    #[cfg(test)]
    pub(super) fn capacity(&self) -> usize {
        self.held.capacity()
    }

    fn double(&mut self, reading: Reading, sink: &mut dyn Sink) {
        self.hold(reading, sink);
        if self.duplicate {
            self.hold(reading, sink);
        }
    }

    fn hold(&mut self, reading: Reading, sink: &mut dyn Sink) {
        if !self.stall {
            self.burst(reading.arrival, sink);
            sink.push(reading);
        } else if self.held.len() < self.held.capacity() {
            self.held.push(reading);
        }
        // A full buffer loses the newest, as the kernel's ring does: the stamps show the gap.
    }

    /// Lets out everything held up; it arrives together.
    fn burst(&mut self, arrival: HostTime, sink: &mut dyn Sink) {
        for reading in self.held.drain(..) {
            sink.push(Reading { arrival, ..reading });
        }
    }
}
