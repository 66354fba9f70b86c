//! The two programs as processes, in shared memory that no other test sees.
#![allow(clippy::missing_panics_doc, reason = "a test that cannot go on fails")]

mod broad;
mod counting;
mod daemon;
mod domain;
mod follower;
mod patience;
mod programs;
mod recordings;
mod replayed;
mod walks;

pub use broad::{Trial, TrialScore};
pub use counting::{Counting, counted};
pub use daemon::Daemon;
pub use domain::{MOST_CONSUMERS, TestDomain};
pub use follower::{Follower, Tally};
pub use patience::{PATIENCE, eventually, skipped};
pub use programs::{lodestone, lodestoned, on_small_shm, said, without_rights};
pub use recordings::{Recorded, SensorRow, compressed, synthetic_camera};
use replayed::text_of;
pub use replayed::{PoseLine, Replayed, replay, table};
pub use walks::Walk;
