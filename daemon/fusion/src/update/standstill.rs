//! Standstill: velocity is zero and so is the angular rate.
//!
//! Zero-velocity update: residual `0 − v`, Jacobian the unit matrix on the velocity error (Groves,
//! ch. 15.3). Zero-rate update: residual `ω̄ − b_g` with the mean rate over the window, Jacobian the
//! unit matrix on the bias error. The gate is the detector, [`crate::rest`].

use glam::{DMat3, DVec3};

use super::apply_blind;
use crate::covariance::{Block, GYRO_BIAS, LEAKY_VELOCITY, Row, STATES, VELOCITY};
use crate::state::State;

/// Row of the Jacobian for one axis of a block that is measured directly.
pub fn jacobian(block: Block, axis: usize) -> Row {
    let mut row = [0.0; STATES];
    row[block.0 + axis] = 1.0;
    row
}

/// The velocity is zero, with a standard deviation in m/s.
pub(crate) fn zero_velocity(state: &mut State, sigma_m_s: f64) {
    for axis in 0..3 {
        let residual = -state.velocity[axis];
        apply_blind(state, &jacobian(VELOCITY, axis), residual, sigma_m_s * sigma_m_s);
    }
}

/// The leaky velocity begins anew at zero, with a standard deviation in m/s.
///
/// It still remembers the motion before, which after braking may be some metres per second. What it
/// knows of the tilt, the velocity knows better at a standstill.
pub(crate) fn restart_leaky_velocity(state: &mut State, sigma_m_s: f64) {
    state.leaky_velocity = DVec3::ZERO;
    let variance = DMat3::from_diagonal(DVec3::splat(sigma_m_s * sigma_m_s));
    state.covariance.set_independent(LEAKY_VELOCITY, variance);
}

/// The mean rate over the window, rad/s in the body, is the bias.
pub(crate) fn zero_rate(state: &mut State, mean_rate: DVec3, sigma_rad_s: f64) {
    for axis in 0..3 {
        let residual = mean_rate[axis] - state.gyro_bias[axis];
        apply_blind(state, &jacobian(GYRO_BIAS, axis), residual, sigma_rad_s * sigma_rad_s);
    }
}
