//! The demonstration: two cameras, one room, and how well their clouds fit.
//!
//! ```text
//!            ┌─> lodestoned run ────────┐ poses, truth
//! setup ─────┼─> lodestoned depth ×2 ───┤ clouds        all in shared memory
//! calibration└─> consumer <─────────────┘
//!                    │ PLY files, what it saw
//!                    └─> score (against the scene) ─> table, picture, demo.json
//! ```
//!
//! Every part is a process of its own, as on a vehicle; the consumer uses the client's library alone. Truth is
//! for the score, and for the one merge by perfect poses that the others are compared with.

pub mod calibration;
pub mod children;
pub mod cloud_file;
pub mod consumer;
pub mod event;
pub mod headings;
pub mod memory;
pub mod outcome;
pub mod progress;
pub mod result;
pub mod rigid;
pub mod score;
pub mod setup;
pub mod sheet;
pub mod table;
