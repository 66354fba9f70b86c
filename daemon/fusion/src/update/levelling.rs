//! Levelling by gravity.
//!
//! A carried camera speeds up and slows down, so its specific force is gravity only on average.
//! What is bounded is its velocity. The leaky velocity `u` (`u̇ = R f + g − u/τ`) is therefore
//! expected to be small: a tilt error of θ makes it grow towards `g θ τ`. The residual is `0 − u`,
//! its Jacobian the unit matrix on the error of `u`; the tilt learns through the correlation that
//! prediction builds up. This is VQF's inclination correction (Laidig and Seel 2023, eq. 8: low-pass
//! filtered specific force in an almost inertial frame) as a measurement with a covariance.
//!
//! Successive values of `u` are correlated over τ, so each counts only for the share of a time
//! constant that has passed since the last one.

use glam::DVec3;

use super::{Outcome, apply_blind};
use crate::covariance::{LEAKY_VELOCITY, Row, STATES};
use crate::parameters::LevellingParameters;
use crate::state::State;

/// Expected minus predicted leaky velocity, m/s, in the world.
pub fn residual(state: &State) -> DVec3 {
    -state.leaky_velocity
}

/// Row of the Jacobian of [`residual`] for one axis, in terms of the error of the state.
pub fn jacobian(axis: usize) -> Row {
    let mut row = [0.0; STATES];
    row[LEAKY_VELOCITY.0 + axis] = 1.0;
    row
}

/// How fast the camera goes about, as far as levelling has seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levelling {
    /// Mean square of the leaky velocity per horizontal axis, (m/s)².
    speed_square: f64,
}

impl Levelling {
    /// Nothing seen.
    pub const fn new() -> Self {
        Self { speed_square: 0.0 }
    }

    /// Levels the state; gives the largest normalised innovation squared of the three axes.
    ///
    /// A camera that speeds up and slows down more than a hand does, in a vehicle, has a larger leaky
    /// velocity all the time, so gravity counts for less. A residual beyond the gate is not refused,
    /// which could lock a tilted filter out for ever: its variance is raised until it sits on the gate.
    pub(crate) fn update(&mut self, state: &mut State, p: &LevellingParameters) -> Outcome {
        let usual_square = self.usual_square(state, p);
        let variance = usual_square * (p.time_constant_s / p.interval_s);
        let mut worst = Outcome { residual: 0.0, nis: 0.0, used: true };
        for axis in 0..3 {
            let row = jacobian(axis);
            let residual = residual(state)[axis];
            let usual = state.covariance.variance(LEAKY_VELOCITY.0 + axis) + usual_square;
            let excess = residual * residual / (usual * p.gate_sigma * p.gate_sigma);
            let variance = variance * excess.max(1.0);
            let outcome = apply_blind(state, &row, residual, variance);
            let nis = residual * residual / usual;
            if nis > worst.nis {
                worst = Outcome { nis, ..outcome };
            }
        }
        worst
    }

    fn usual_square(&mut self, state: &State, p: &LevellingParameters) -> f64 {
        let u = state.leaky_velocity;
        let now = 0.5 * (u.x * u.x + u.y * u.y);
        let share = p.interval_s / (p.interval_s + p.memory_s);
        self.speed_square += share * (now - self.speed_square);
        (p.sigma_m_s * p.sigma_m_s).max(p.liveliness * self.speed_square)
    }
}

impl Default for Levelling {
    fn default() -> Self {
        Self::new()
    }
}
