//! The fit: one maximum a posteriori problem over a whole recording.
//!
//! ```text
//! Stream ─> start (level, no soft iron) ─> search ─> Fit
//!    └────> segments ─> Problem: field, force, link, priors ─> arrow ──┘ each step
//! ```

mod arrow;
mod colour;
mod field;
mod fit;
mod force;
mod link;
pub(crate) mod parameters;
mod problem;
mod segments;
mod start;
#[cfg(test)]
mod tests;
mod turned;

pub(crate) use arrow::GlobalBlock;
pub(crate) use fit::Fit;
pub(crate) use problem::{Left, Problem};

use crate::settings::Settings;

/// Fits a problem; `None` if its equations cannot be solved in numbers.
pub(crate) fn fit(problem: &Problem<'_>, settings: &Settings) -> Option<Fit> {
    let (start, residual_ut) = start::start(problem.stream, &problem.segments);
    let noise = fit::first_noise(&settings.noise, residual_ut, problem.stream.interval_s);
    fit::search(problem, start, noise)
}
