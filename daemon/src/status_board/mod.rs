//! What a lane tells the other threads, without a lock and without ever waiting for them.
//!
//! The lane adds to [counters](LaneCounters), records [latencies](Histogram) and
//! [reports](Latest::report) its latest [status](LaneStatus); housekeeping and console read.
//! Everything is made of atomic integers, so a reader that is stopped half-way stops nobody.

mod counter;
mod histogram;
mod latest;
mod status;

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, AtomicU32, Ordering};

use lodestone_schema::{AlignmentWait, AnchorRefusal, LaneState};

pub use counter::{Counter, CounterValues, LaneCounters};
pub use histogram::{Histogram, LatencySummary};
pub use latest::Latest;
pub use status::{LaneStatus, SensorStatus};

use crate::realtime::Roster;

/// One lane's board, shared as an `Arc`.
#[derive(Debug, Default)]
pub struct LaneBoard {
    /// What the lane counts.
    pub counters: LaneCounters,
    /// Reports the driver could not read, or that the device itself calls invalid.
    pub driver_invalid: Counter,
    /// Reports the driver kept back because their time stamp repeats.
    pub driver_duplicates: Counter,
    /// From the arrival of a sample to the publication of its pose, ns.
    pub latency: Histogram,
    /// The latest pose and sensor readings.
    pub latest: Latest,
    /// The lane's threads; not looked at on the way of a sample.
    pub roster: Arc<Roster>,
    state: AtomicU8,
    alignment_wait: AtomicU8,
    anchor_refusal: AtomicU8,
    members_in_use: AtomicU32,
}

impl LaneBoard {
    /// A board on which nothing is reported yet; the lane is searching.
    pub fn new() -> Self {
        Self::default()
    }

    /// Every counter, driver and lane taken together.
    pub fn counter_values(&self) -> CounterValues {
        let lane = self.counters.values();
        CounterValues {
            invalid: lane.invalid + self.driver_invalid.get(),
            duplicates: lane.duplicates + self.driver_duplicates.get(),
            ..lane
        }
    }

    /// What the lane is doing.
    pub fn state(&self) -> LaneState {
        LaneState::from_code(self.state.load(Ordering::Relaxed)).unwrap_or(LaneState::Searching)
    }

    /// Why the alignment is not done.
    pub fn alignment_wait(&self) -> AlignmentWait {
        let code = self.alignment_wait.load(Ordering::Relaxed);
        AlignmentWait::from_code(code).unwrap_or(AlignmentWait::None)
    }

    /// Says why the alignment is not done.
    pub fn set_alignment_wait(&self, wait: AlignmentWait) {
        self.alignment_wait.store(wait.code(), Ordering::Relaxed);
    }

    /// Why the last measurement against another camera was not used.
    pub fn anchor_refusal(&self) -> AnchorRefusal {
        let code = self.anchor_refusal.load(Ordering::Relaxed);
        AnchorRefusal::from_code(code).unwrap_or(AnchorRefusal::None)
    }

    /// Says why the last measurement against another camera was not used.
    pub fn set_anchor_refusal(&self, refusal: AnchorRefusal) {
        self.anchor_refusal.store(refusal.code(), Ordering::Relaxed);
    }

    /// One bit for each member of a rigid body in use; 0 for a camera.
    pub fn members_in_use(&self) -> u32 {
        self.members_in_use.load(Ordering::Relaxed)
    }

    /// Says which members of a rigid body are in use.
    pub fn set_members_in_use(&self, bits: u32) {
        self.members_in_use.store(bits, Ordering::Relaxed);
    }

    /// Says what the lane is doing.
    pub fn set_state(&self, state: LaneState) {
        self.state.store(state.code(), Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests;
