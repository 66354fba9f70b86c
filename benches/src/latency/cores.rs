//! Which part of the harness runs where, and with which priority.

use std::io;
use std::sync::Arc;

use lodestone_client::latency::{allowed_processors, pin_to};
use lodestone_daemon::realtime::{Enrolled, Roster, ThreadSetup, enter};

/// Priority of lanes, peers' publishers and consumers under `SCHED_FIFO`.
pub const PRIORITY: u8 = 50;

/// The side of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Whoever publishes has the first processor.
    Publisher,
    /// The consumer has the last one for itself: otherwise a publisher that wakes up would push a polling
    /// consumer aside, and the scheduler would be measured.
    Consumer,
    /// Any.
    Both,
}

impl Side {
    /// Its processor; `None` where any will do, or where there is only one.
    ///
    /// # Errors
    /// Whatever the system says.
    pub fn processor(self) -> io::Result<Option<usize>> {
        let allowed = allowed_processors()?;
        Ok(match self {
            _ if allowed.len() < 2 => None,
            Self::Publisher => allowed.first().copied(),
            Self::Consumer => allowed.last().copied(),
            Self::Both => None,
        })
    }

    /// Keeps the calling thread, and those that it starts, on its processor.
    ///
    /// # Errors
    /// Whatever the system says.
    pub fn enter(self) -> io::Result<()> {
        let Some(processor) = self.processor()? else { return Ok(()) };
        pin_to(processor)
    }
}

/// Gives the calling thread what a lane's thread asks for under `realtime.policy = "fifo"`, as far as it
/// is allowed: threads that it starts are scheduled normally.
#[must_use]
pub fn become_real_time() -> Enrolled {
    let setup = ThreadSetup {
        priority: Some(PRIORITY),
        cpu: None,
        timer_slack_ns: 1000,
        prefault_stack_kib: 128,
    };
    enter(&setup, &Arc::new(Roster::default()))
}
