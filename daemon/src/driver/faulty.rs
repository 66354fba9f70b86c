//! Any driver, with faults put between it and the lane.
//!
//! Faults go by the stream's own time: its first sample is at 0 s, and a fault of `at_s` and
//! `duration_s` meets every sample with `at_s ≤ t < at_s + duration_s`. So a seeded source under
//! a list of faults gives the same stream in every run, however fast it is read.
//!
//! A sample passes the faults in a fixed order: it vanishes (unplug, drop), or its values and
//! stamp change (in the order of the list), then it changes places with its neighbour, comes
//! twice, and is held up.

mod effect;
mod flow;

use std::time::Duration;

use lodestone_config::model::{Fault, FaultKind};
use lodestone_fusion::SensorTime;

use self::effect::Effects;
use self::flow::{Flow, stall_capacity};
use super::{Driver, DriverCounters, DriverInfo, Sink, SourceState};
use crate::reading::Reading;

/// A driver whose samples meet faults on their way.
pub struct FaultyDriver<D> {
    inner: D,
    injector: Injector,
}

impl<D: Driver> FaultyDriver<D> {
    /// Puts faults between a driver and whoever polls it. All memory is taken here.
    pub fn new(inner: D, faults: &[Fault]) -> Self {
        let capacity = stall_capacity(faults, inner.info().nominal_rate_hz);
        let injector = Injector {
            effects: Effects::new(faults),
            flow: Flow::with_capacity(capacity),
            time: StreamTime::default(),
            faults: faults.to_vec(),
            unplugged: false,
            reconnects: 0,
        };
        Self { inner, injector }
    }
}

impl<D: Driver> Driver for FaultyDriver<D> {
    fn info(&self) -> DriverInfo {
        self.inner.info()
    }

    fn poll(&mut self, timeout: Duration, sink: &mut dyn Sink) -> SourceState {
        let injector = &mut self.injector;
        let state = self.inner.poll(timeout, &mut FaultySink { injector, sink });
        if state == SourceState::Ended {
            self.injector.flow.end(sink);
        }
        let unplugged = self.injector.unplugged && state == SourceState::Streaming;
        if unplugged { SourceState::Lost } else { state }
    }

    fn counters(&self) -> DriverCounters {
        let inner = self.inner.counters();
        let reconnects = inner.reconnects + u64::from(self.injector.reconnects);
        DriverCounters { reconnects, ..inner }
    }
}

/// Everything between the inner driver and the sink.
struct Injector {
    faults: Vec<Fault>,
    effects: Effects,
    flow: Flow,
    time: StreamTime,
    /// The latest sample fell into an unplugging.
    unplugged: bool,
    /// Unpluggings that ended; each raised the epoch.
    reconnects: u32,
}

impl Injector {
    fn take(&mut self, mut reading: Reading, sink: &mut dyn Sink) {
        let t_s = self.time.of(&reading);
        self.follow_unplugging(t_s);
        if self.unplugged || self.meets(FaultKind::Drop, t_s) {
            return;
        }
        reading.epoch = reading.epoch.wrapping_add(self.reconnects);
        for (index, fault) in self.faults.iter().enumerate() {
            if meets(fault, t_s) {
                self.effects.apply(index, fault.kind, &mut reading);
            }
        }
        self.flow.reorder = self.meets(FaultKind::Reorder, t_s);
        self.flow.duplicate = self.meets(FaultKind::Duplicate, t_s);
        self.flow.stall = self.meets(FaultKind::Stall, t_s);
        self.flow.take(reading, sink);
    }

    fn follow_unplugging(&mut self, t_s: f64) {
        let unplugged = self.meets(FaultKind::Unplug, t_s);
        if self.unplugged && !unplugged {
            self.reconnects += 1;
        }
        self.unplugged = unplugged;
    }

    fn meets(&self, kind: FaultKind, t_s: f64) -> bool {
        self.faults.iter().any(|fault| fault.kind == kind && meets(fault, t_s))
    }
}

/// Whether a fault is on at a time of the stream.
fn meets(fault: &Fault, t_s: f64) -> bool {
    t_s >= fault.at_s && t_s - fault.at_s < fault.duration_s
}

/// The inner driver's way into the injector.
struct FaultySink<'a> {
    injector: &'a mut Injector,
    sink: &'a mut dyn Sink,
}

impl Sink for FaultySink<'_> {
    fn push(&mut self, reading: Reading) {
        self.injector.take(reading, self.sink);
    }
}

/// Seconds since the first sample; a new epoch of the sensor's clock goes on where the last ended.
#[derive(Default)]
struct StreamTime {
    /// Epoch, its origin on the sensor's clock, and the stream's time at that origin.
    origin: Option<(u32, SensorTime, f64)>,
    latest_s: f64,
}

impl StreamTime {
    fn of(&mut self, reading: &Reading) -> f64 {
        let (epoch, stamp) = (reading.epoch, reading.sensor_time);
        let origin = match self.origin {
            Some(origin) if origin.0 == epoch => origin,
            _ => *self.origin.insert((epoch, stamp, self.latest_s)),
        };
        self.latest_s = origin.2 + (stamp - origin.1).as_secs_f64();
        self.latest_s
    }
}

#[cfg(test)]
mod tests;
