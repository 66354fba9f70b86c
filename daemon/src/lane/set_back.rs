//! A source whose clock was set back, told from readings that come late.

use lodestone_fusion::{SensorSpan, SensorTime};

/// Readings in a row that lie before the newest one taken, in order among themselves.
#[derive(Clone, Copy, Debug, PartialEq)]
struct BackwardRun {
    first: SensorTime,
    last: SensorTime,
}

/// Watches refused readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SetBack {
    after: SensorSpan,
    run: Option<BackwardRun>,
}

impl SetBack {
    /// A clock counts as set back once readings have run behind for so long.
    pub const fn new(after: SensorSpan) -> Self {
        Self { after, run: None }
    }

    /// A reading was taken.
    pub const fn note_taken(&mut self) {
        self.run = None;
    }

    /// Whether refused readings have come in order for as long as a gap that resets the filter. A
    /// burst of late readings is shorter, and readings that change places are not in order.
    pub fn was_set_back(&mut self, time: SensorTime) -> bool {
        let run = match self.run {
            Some(run) if time >= run.last => BackwardRun { last: time, ..run },
            _ => BackwardRun { first: time, last: time },
        };
        let set_back = run.last - run.first > self.after;
        self.run = (!set_back).then_some(run);
        set_back
    }
}
