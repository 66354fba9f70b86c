//! Measurement updates: one file each, its gate beside its residual and Jacobian.

pub mod compass;
pub mod levelling;
pub mod standstill;

use crate::covariance::Row;
use crate::state::State;

/// What became of a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Residual: what was measured minus what was expected, in the measurement's unit.
    pub residual: f64,
    /// Normalised innovation squared, residual² / variance; 1 on average if the filter is honest.
    pub nis: f64,
    /// Whether it changed the state.
    pub used: bool,
}

/// Applies one scalar measurement `residual = h · error + noise` with the optimal gain.
pub(crate) fn apply(state: &mut State, h: &Row, residual: f64, variance: f64) -> Outcome {
    let ph = state.covariance.times(h);
    let innovation_variance = dot(h, &ph) + variance;
    let gain = residual / innovation_variance;
    state.correct(&ph.map(|x| x * gain));
    state.covariance.deflate(&ph, innovation_variance);
    Outcome { residual, nis: residual * gain, used: true }
}

/// Variance of the innovation of a scalar measurement.
pub(crate) fn innovation_variance(state: &State, h: &Row, variance: f64) -> f64 {
    dot(h, &state.covariance.times(h)) + variance
}

fn dot(a: &Row, b: &Row) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests;
