//! What the lanes ask of the kernel to be in time, and what becomes of it.
//!
//! ```text
//! configuration ─> ThreadSetup ─> enter, on the thread itself ─> Roster ─> health
//!                  memory::lock, once for the process ────────────┘ ^
//!                                     housekeeping: pins again ─────┘
//! ```
//!
//! Nothing here is needed to run: what is refused is logged with the limit to raise, stands in each
//! camera's health, and the lane goes on without it. A lane never spins, whatever its priority: the
//! kernel would take the processor from it for 50 ms of every second.

mod memory;
mod refusal;
mod roster;
mod scheduling;
mod setup;
mod stack;

pub use memory::lock as lock_memory;
pub use refusal::Refusal;
pub use roster::{Enrolled, Roster, enter};
pub use setup::ThreadSetup;
