//! Measurement updates: one file each, its gate beside its residual and Jacobian.

pub(crate) mod anchored;
pub(crate) mod belief;
pub mod compass;
pub(crate) mod fix;
pub mod gradient;
pub mod levelling;
pub(crate) mod non_holonomic;
pub(crate) mod speed;
pub mod standstill;
pub(crate) mod vector;
pub(crate) mod vehicle;

use crate::covariance::{ORIENTATION, POSITION, Row};
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
    if state.is_held() {
        return apply_considering(state, h, (residual, variance), |_| false);
    }
    let ph = state.covariance.times(h);
    let innovation_variance = dot(h, &ph) + variance;
    let gain = residual / innovation_variance;
    state.correct(&ph.map(|x| x * gain));
    state.learn(h, &ph, innovation_variance);
    Outcome { residual, nis: residual * gain, used: true }
}

/// Index of the heading error.
const HEADING: usize = ORIENTATION.0 + 2;
/// Variance of the heading from which it counts as unknown, rad²: 1σ of 18°, where sine and tangent
/// of the error begin to differ.
pub(crate) const UNKNOWN_HEADING: f64 = 0.1;

/// Applies one scalar measurement that cannot see the heading: of gravity, of standstill.
///
/// A heading error turns a velocity without changing its size. For a small error that does no harm;
/// for a large one a linear filter sees growth, which a small velocity then contradicts, and becomes
/// sure of a heading that nothing measures. So an unknown heading is spared: what is known of it
/// counts, nothing is learnt about it (Schmidt's consider state).
pub(crate) fn apply_blind(state: &mut State, h: &Row, residual: f64, variance: f64) -> Outcome {
    if state.covariance.variance(HEADING) < UNKNOWN_HEADING {
        return apply(state, h, residual, variance);
    }
    apply_considering(state, h, (residual, variance), |index| index == HEADING)
}

/// The same of a camera that has stood for a while: where it stands, it learns no more. Whatever its
/// standing says about the way here was said when it stopped, and a position that creeps would be wrong.
pub(crate) fn apply_standing(state: &mut State, h: &Row, residual: f64, variance: f64) -> Outcome {
    let blind = state.covariance.variance(HEADING) >= UNKNOWN_HEADING;
    apply_considering(state, h, (residual, variance), |index| {
        (POSITION.0..POSITION.0 + 3).contains(&index) || blind && index == HEADING
    })
}

/// Applies a scalar measurement that teaches nothing about some of the states (Schmidt's consider
/// states): what is known of them counts.
fn apply_considering(
    state: &mut State,
    h: &Row,
    (residual, variance): (f64, f64),
    is_spared: impl Fn(usize) -> bool,
) -> Outcome {
    let ph = state.covariance.times(h);
    let innovation_variance = dot(h, &ph) + variance;
    let own = state.own_part(h, &ph);
    let gain: Row =
        core::array::from_fn(|k| if is_spared(k) { 0.0 } else { own[k] / innovation_variance });
    state.correct(&gain.map(|x| x * residual));
    state.learn_by(h, &ph, &gain, innovation_variance);
    Outcome { residual, nis: residual * residual / innovation_variance, used: true }
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
