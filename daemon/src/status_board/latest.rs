//! The latest status.

use super::status::{LaneStatus, WORDS};
use crate::triple_buffer::TripleBuffer;

/// Where one thread reports and others look; see [`TripleBuffer`].
#[derive(Debug)]
pub struct Latest(TripleBuffer<WORDS>);

impl Default for Latest {
    fn default() -> Self {
        Self(TripleBuffer::new(&LaneStatus::default().to_words()))
    }
}

impl Latest {
    /// Reports a status. Wait-free; for one thread only (two would mix their reports).
    pub fn report(&self, status: &LaneStatus) {
        self.0.report(&status.to_words());
    }

    /// The last status reported; the default before the first.
    pub fn read(&self) -> LaneStatus {
        LaneStatus::from_words(&self.0.read())
    }
}
