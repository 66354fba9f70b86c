//! A rigid rig of several cameras: one lane, fed by the rings of its members.
//!
//! ```text
//! readings of each member ─> Conditioner ─> Grid on the common clock ─┐
//!                                                                     ├─> Assembler ─> RigEstimator
//! readings of each member ─> Conditioner ─> Grid on the common clock ─┘   (lodestone-fusion)
//! ```
//!
//! The rig's pose goes out under the body's name, and each camera's, derived by its mounting, under the
//! camera's.

mod assembler;
mod core;
mod gradient_csv;
pub mod lane;
mod settings;
#[cfg(test)]
mod tests;
mod worker;

pub use assembler::{Assembler, AssemblerCounts, Fit, Row};
pub use core::{RigCore, RigStep};
pub use gradient_csv::{GradientWriter, verdict_name};
pub use settings::{MemberSettings, RigError, RigSettings, is_member};
pub use worker::{Outlet, RigWorker};
