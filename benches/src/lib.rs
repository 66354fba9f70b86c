//! What Lodestone costs, and what a peer costs for the same work in the same run.
//!
//! | what | command |
//! |---|---|
//! | one sample through the lane's core, and its parts, in time | `cargo bench -p lodestone-benches --bench step` |
//! | the same in instructions, held to a budget | `benches/callgrind.sh` |
//! | from a sample's arrival to a consumer's eyes, beside peers | `cargo bench -p lodestone-benches --features zenoh --bench latency` |
//! | publishing to 0, 1, 4, 16 subscribers | `cargo bench -p lodestone-benches --bench publish` |
//! | merging a point of a cloud, placing and map | `cargo bench -p lodestone-benches --bench merge` |
//!
//! Times on a shared machine are noisy: trust ratios within one run and instruction counts.

pub mod domain;
pub mod latency;
pub mod ledger;
pub mod message;
pub mod readings;
pub mod room;
pub mod vqf;
