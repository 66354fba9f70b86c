//! From a sample's arrival to a consumer's eyes, by the stamps in the poses.
//!
//! ```text
//! daemon process                                            consumer process
//! arrival ─> step start ─> step end ─> published ═════════> seen
//!     ring, wake-up     filter     message        shared memory
//! ```
//!
//! The daemon is `lodestoned` itself with one synthetic camera at 400 Hz. Two consumers in
//! processes of their own look on, one after the other: one polls without pause, one sleeps in
//! [`PoseStream::wait`](lodestone_client::PoseStream::wait). The peer is a plain iceoryx2
//! publisher of the same message at the same rate, without a lane, and a polling subscriber.

pub mod peer;
pub mod role;
pub mod rounds;
pub mod stages;
pub mod table;
