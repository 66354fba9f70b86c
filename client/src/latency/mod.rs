//! How long a sample takes from its arrival to a consumer, stage by stage, from the stamps in its pose.
//!
//! ```text
//! daemon                                                                     consumer
//! arrival ─> ring ─> step start ─> step end ─> published ══ shared memory ══> seen
//!    driver    hand-over    filter      message             transport
//! ```
//!
//! [`Poller`] sees poses as soon as they are there and notes when it was itself held up; a [`Sentinel`]
//! on another core notes when that core was. [`CameraLatency`] keeps histograms of what was seen, once
//! with every sample and once without those whose way crossed such a gap, and counts what was left
//! out and why. `lodestone bench` is these on a running daemon; `benches/` puts peers beside them.

mod chart;
mod counts;
mod gaps;
mod histogram;
mod machine;
mod page;
mod poller;
mod processors;
mod record;
mod sentinel;
mod stamps;

pub use chart::{Curve, chart};
pub use counts::Counted;
pub use gaps::{GAP_THRESHOLD, Gap, Gaps};
pub use histogram::{Histogram, Percentiles};
pub use machine::{Machine, ThreadSchedule, is_fast_clock, lane_threads};
pub use page::{Escaped, page, table};
pub use poller::{Poller, Seen};
pub use processors::{allowed_processors, pin_to};
pub use record::{CameraLatency, Sighting, StageHistograms};
pub use sentinel::{Sentinel, SentinelError};
pub use stamps::{Stage, Stamps};
