//! Standstill: velocity is zero and so is the angular rate.
//!
//! Gate: the likelihood of a window, [`crate::rest`]. A camera at rest neither moves nor turns; the sole of
//! a foot in its stance does not move, but may turn, for as long as its own, shorter window says.
//!
//! Zero-velocity update: residual `0 − v`, Jacobian the unit matrix on the velocity error (Groves,
//! ch. 15.3). Zero-rate update: residual `ω̄ − Rᵀ Ω − b_g` with the mean rate over the window and the
//! earth's rate Ω, Jacobian the unit matrix on the bias error.

use glam::DVec3;

use super::{Outcome, apply_blind};
use crate::alignment::Aligned;
use crate::covariance::{Block, GYRO_BIAS, LEAKY_VELOCITY, Row, STATES, VELOCITY};
use crate::grid::Increment;
use crate::parameters::{Parameters, StanceParameters};
use crate::rest::{RestDetector, Standing, WindowStatistics};
use crate::state::State;

/// Row of the Jacobian for one axis of a block that is measured directly.
pub fn jacobian(block: Block, axis: usize) -> Row {
    let mut row = [0.0; STATES];
    row[block.0 + axis] = 1.0;
    row
}

/// What the detectors have to decide upon after a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Windows {
    rest: Option<WindowStatistics>,
    stance: Option<WindowStatistics>,
}

impl Windows {
    /// Whether there is nothing to decide.
    pub(crate) const fn is_empty(&self) -> bool {
        self.rest.is_none() && self.stance.is_none()
    }
}

/// Whether the camera stands, and for how long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Standstill {
    rest: RestDetector,
    stance: RestDetector,
    resting_s: f64,
    at_rest: bool,
    in_stance: bool,
    /// Velocity after the last decision, m/s.
    velocity_then: DVec3,
}

impl Standstill {
    /// Nothing decided: at the start, and after a gap.
    pub(crate) const UNKNOWN: Self = Self {
        rest: RestDetector::new(),
        stance: RestDetector::new(),
        resting_s: 0.0,
        at_rest: false,
        in_stance: false,
        velocity_then: DVec3::ZERO,
    };

    /// As the alignment found the camera, if its window is the one that goes on.
    pub(crate) fn begin(aligned: &Aligned) -> Self {
        Self {
            rest: aligned.detector.unwrap_or_default(),
            at_rest: aligned.detector.is_some(),
            ..Self::UNKNOWN
        }
    }

    /// Whether the velocity is known to be zero.
    pub(crate) const fn stands(&self) -> bool {
        self.at_rest || self.in_stance
    }

    /// Whether the position stays where it is.
    pub(crate) const fn holds(&self) -> bool {
        self.at_rest
    }

    /// Takes one step.
    pub(crate) fn watch(&mut self, increment: &Increment, p: &Parameters) -> Windows {
        Windows {
            rest: self.rest.push(increment, p.rest.window_s),
            stance: p.stance.and_then(|s| self.stance.push(increment, s.window_s)),
        }
    }

    /// Decides, and corrects the state of a camera that stands; gives the update of the velocity with
    /// the largest normalised innovation of the axes, if there was one.
    pub(crate) fn update(
        &mut self,
        state: &mut State,
        windows: &Windows,
        earth_rate: DVec3,
        p: &Parameters,
    ) -> Option<Outcome> {
        if windows.is_empty() {
            return None;
        }
        let earth_rate = state.orientation.conjugate() * earth_rate;
        let standing = Standing {
            gyro_bias: state.gyro_bias + earth_rate,
            gyro_bias_sigma: libm::sqrt(state.covariance.variances(GYRO_BIAS).max_element()),
            force: p.gravity_m_s2,
            force_sigma: p.noise.accel_bias_sigma,
        };
        let stance = windows.stance.zip(p.stance);
        let stance = stance.and_then(|(window, p)| self.stance(state, &window, &standing, &p));
        let rest = windows.rest.and_then(|w| self.rest(state, &w, (&standing, earth_rate), p));
        self.velocity_then = state.velocity;
        stance.or(rest)
    }

    fn rest(
        &mut self,
        state: &mut State,
        window: &WindowStatistics,
        (standing, earth_rate): (&Standing, DVec3),
        p: &Parameters,
    ) -> Option<Outcome> {
        self.at_rest = window.is_rest(standing, &p.rest);
        if !self.at_rest {
            self.resting_s = 0.0;
            return None;
        }
        let interval_s = p.rest.interval_s();
        self.resting_s += interval_s;
        let outcome = zero_velocity(state, p.rest.velocity_sigma_m_s);
        // Begin of a standstill: the leaky velocity still remembers the motion before, so it is left
        // to fade until it is as small as a standing camera's.
        if self.resting_s > 2.0 * p.levelling.time_constant_s {
            fade(state, p.rest.velocity_sigma_m_s);
        }
        // The window is longer than the interval, so successive means are correlated: the noise is
        // counted as if each block came alone.
        let noise = p.noise.gyro_density / libm::sqrt(interval_s);
        let sigma = noise.max(p.rest.turn_sigma_rad_s);
        zero_rate(state, window.confirmed_rate - earth_rate, sigma);
        Some(outcome)
    }

    /// The window ends now, and its last block may already belong to the next swing: what is zero is the
    /// velocity a block ago.
    fn stance(
        &mut self,
        state: &mut State,
        window: &WindowStatistics,
        standing: &Standing,
        p: &StanceParameters,
    ) -> Option<Outcome> {
        let gained = state.velocity - self.velocity_then;
        let statistic = window.statistic(standing, &p.stillness);
        self.in_stance = statistic < p.threshold;
        self.in_stance.then(|| {
            let share = statistic / p.statistic_scale;
            let sigma_m_s = p.velocity_sigma_m_s * libm::sqrt(1.0 + share * share);
            zero(state, VELOCITY, |s| gained - s.velocity, sigma_m_s)
        })
    }
}

/// The velocity is zero, with a standard deviation in m/s.
pub(crate) fn zero_velocity(state: &mut State, sigma_m_s: f64) -> Outcome {
    zero(state, VELOCITY, |s| -s.velocity, sigma_m_s)
}

/// The leaky velocity is zero, with a standard deviation in m/s.
pub(crate) fn fade(state: &mut State, sigma_m_s: f64) -> Outcome {
    zero(state, LEAKY_VELOCITY, |s| -s.leaky_velocity, sigma_m_s)
}

/// The mean rate over the window, rad/s in the body, is the bias.
pub(crate) fn zero_rate(state: &mut State, mean_rate: DVec3, sigma_rad_s: f64) -> Outcome {
    zero(state, GYRO_BIAS, |s| mean_rate - s.gyro_bias, sigma_rad_s)
}

/// A block is off by a residual, which each axis' update changes for the next one.
fn zero(
    state: &mut State,
    block: Block,
    residual: impl Fn(&State) -> DVec3,
    sigma: f64,
) -> Outcome {
    let mut worst = Outcome { residual: 0.0, nis: 0.0, used: true };
    for axis in 0..3 {
        let off = residual(state)[axis];
        let outcome = apply_blind(state, &jacobian(block, axis), off, sigma * sigma);
        if outcome.nis > worst.nis {
            worst = outcome;
        }
    }
    worst
}
