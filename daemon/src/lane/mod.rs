//! One camera's lane: from a reading to a pose.
//!
//! ```text
//! Reading ─> Conditioner ─> Grid ─> Estimator ─> Estimate ─> message
//!            axes, calibration      (lodestone-fusion)
//! ```
//!
//! [`Core`] is all of it that depends on the readings alone; replaying a recording and running
//! live differ only in what surrounds it ([`Worker`] for a live lane).

mod aiding;
mod conditioner;
mod core;
mod heard;
mod message;
mod set_back;
mod settings;
#[cfg(test)]
mod tests;
mod trail;
mod vehicle;
mod worker;

pub(crate) use aiding::AidQueue;
pub use conditioner::Conditioner;
pub use core::{Core, CoreCounts, Phase, StepOutput, Taken, is_unlike_earth, recovered};
pub(crate) use heard::{Addressee, understood};
pub use message::{fill_pose, pose_row, sample_message, status_of, validity_of, wait_of};
pub use set_back::SetBack;
pub use settings::{LaneSettings, SettingsError, Timing, low_pass_of};
pub(crate) use worker::show_counts;
pub use worker::{Publish, Worker};
