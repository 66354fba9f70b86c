//! Velocity by the magnetic gradient of a rig.
//!
//! The field tells how the rig moves against itself, and the estimated attitude turns that into the world:
//! `z = R̂ v_body`, with `R = Exp(δθ) R̂`. Residual `z − v̂ = δv − δθ × v`, so the Jacobian is the unit matrix
//! on the velocity error and `[v]×` on the orientation's: a wrong heading is no wrong velocity. Along the
//! eigenvectors of the measurement's covariance the three components are independent, and taken one
//! after the other. The gate is the window's ([`crate::rig`]), and here the innovation.

use glam::{DMat3, DVec3};

use super::apply_blind;
use crate::covariance::{ORIENTATION, Row, STATES, VELOCITY};
use crate::rig::eigen;
use crate::so3;
use crate::state::State;

/// Variance from which a direction tells nothing, (m/s)².
const UNTOLD: f64 = 1e4;
/// Largest normalised innovation squared in a direction: four sigma.
const GATE_NIS: f64 = 16.0;

/// Row of the Jacobian along a direction, at a velocity in the world, m/s: `e · (δv + v × δθ)`.
pub fn jacobian(direction: DVec3, velocity: DVec3) -> Row {
    let mut row = [0.0; STATES];
    let by_turn = direction.cross(velocity);
    for axis in 0..3 {
        row[VELOCITY.0 + axis] = direction[axis];
        row[ORIENTATION.0 + axis] = by_turn[axis];
    }
    row
}

/// Standard deviation in the worst direction, in the rig's own axes, up to which the velocity is held, m/s.
const HELD_SIGMA_M_S: f64 = 0.06;

/// What a velocity did to the state's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Held {
    /// It contradicts the state, and was not used.
    Contradicted,
    /// It was used; some direction is still vague.
    Partly,
    /// It was used, and all directions are known.
    Wholly,
}

/// Takes a velocity in the world, m/s, with its covariance.
pub(crate) fn update(state: &mut State, velocity: DVec3, covariance: DMat3) -> Held {
    let parts = eigen(covariance);
    let told = (0..3).filter(|&k| parts.values[k] < UNTOLD);
    let contradicts = |k: usize| {
        let e = parts.vectors.col(k);
        let residual = e.dot(velocity - state.velocity);
        let variance =
            super::innovation_variance(state, &jacobian(e, state.velocity), parts.values[k]);
        residual * residual > GATE_NIS * variance
    };
    if told.clone().any(contradicts) {
        return Held::Contradicted;
    }
    for k in told {
        let e = parts.vectors.col(k);
        let residual = e.dot(velocity - state.velocity);
        let row = jacobian(e, state.velocity);
        apply_blind(state, &row, residual, parts.values[k]);
    }
    let worst = eigen(in_own_axes(state)).values.x;
    if worst < HELD_SIGMA_M_S * HELD_SIGMA_M_S { Held::Wholly } else { Held::Partly }
}

/// Covariance of the velocity as the rig itself has it, (m/s)²: what an error of the attitude does to the
/// velocity in the world is not in it.
fn in_own_axes(state: &State) -> DMat3 {
    let turn = so3::skew(state.velocity);
    let block = |i, j| state.covariance.block(i, j);
    let across = turn * block(ORIENTATION, VELOCITY);
    let by_turn = turn * block(ORIENTATION, ORIENTATION) * turn.transpose();
    block(VELOCITY, VELOCITY) + across + across.transpose() + by_turn
}
