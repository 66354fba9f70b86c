//! From a sample's arrival to a consumer's eyes, beside peers that carry the same number of bytes at
//! the same rate, in one run.
//!
//! ```text
//! harness ─ round ─ subject ─┬─ daemon or peer's publisher   process, first cores
//!    │                       └─ consumer                     process, last core
//!    └─ sentinel             first core
//! ```
//!
//! Each round runs every [`subject`] once, in an order that is drawn anew; figures are medians over the
//! rounds, with their smallest and largest. Every part is a process of its own, this program started
//! again in a [`role`]. A sample whose way crossed a gap, which the sentinel or the consumer noted, is
//! counted and kept apart ([`lodestone_client::latency`]).

pub mod configuration;
pub mod cores;
pub mod cpu_time;
pub mod metronome;
pub mod part;
pub mod payload;
pub mod peers;
pub mod plan;
pub mod report;
pub mod role;
pub mod round;
pub mod seqlock;
pub mod step_alone;
pub mod subject;
pub mod target;
pub mod told;
