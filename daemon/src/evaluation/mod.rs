//! How good is it? The paper's own tables, measured again in the synthetic world.
//!
//! ```text
//! scenario ─> place ─┬─> recording ─> calibration ──┐
//!                    ├─> fresh recordings ──────────┼─> scores ─┬─> table, report.json
//!                    └─> recordings at rest ────────┘           └─> report.html (crate::report)
//! ```
//!
//! A calibration is made from one recording and judged on others of the same place that it has not
//! seen. The truth of the synthetic world is for scores alone.

pub mod allan;
pub mod correction;
pub mod dynamic;
pub mod paper;
pub mod place;
pub mod recording;
pub mod rest;
pub mod static_places;
pub mod statistics;
pub mod trace;
