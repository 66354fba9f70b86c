//! The end of the lane: messages into shared memory.
//!
//! # What allocates
//! `loan_uninit` of iceoryx2 0.10 makes one `Rc` for each sample (its
//! `port/details/chunk_mut_shared_state.rs`), and sending frees it: one allocation and one
//! deallocation for each message. A [`LanePublisher`] loans the next sample right after it sent
//! one, so both happen after the message is out. Nothing else allocates, ours or iceoryx2's,
//! except while a subscriber joins or leaves.

mod inbox;
mod lane;
mod port;
mod qos;
mod side;
mod wake;
mod world;

pub use inbox::AidingInbox;
pub use lane::LanePublisher;
pub(crate) use lane::blank_pose;
pub use port::PublisherError;
pub use qos::{MAX_BORROWED, qos_of, sample_bytes};
pub(crate) use side::blank_health;
pub use side::{HealthPublisher, TruthPublisher};
pub use world::{Requests, WorldPublisher};
