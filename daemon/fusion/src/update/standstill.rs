//! Standstill: velocity is zero and so is the angular rate.
//!
//! Gate: the likelihood of a window, [`crate::rest`]. A camera at rest neither moves nor turns; the sole of
//! a foot in its stance does not move, but may turn, for as long as its own, shorter window says.
//!
//! Zero-velocity update: residual `0 − v`, Jacobian the unit matrix on the velocity error (Groves,
//! ch. 15.3). Zero-rate update: residual `ω̄ − Rᵀ Ω − b_g` with the mean rate over the window and the
//! earth's rate Ω, Jacobian the unit matrix on the bias error.

use glam::{DMat3, DVec3};

use super::belief::Belief;
use super::{Outcome, apply_blind, apply_standing};
use crate::alignment::Aligned;
use crate::covariance::{Block, GYRO_BIAS, LEAKY_VELOCITY, Row, STATES, VELOCITY};
use crate::grid::Increment;
use crate::parameters::{Parameters, StanceParameters};
use crate::rest::{RestDetector, Standing, WindowStatistics};
use crate::state::State;

/// Rest after which a standing camera has learnt where it stands, s.
const SETTLED_S: f64 = 1.0;

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

/// What else is known while it is decided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Around {
    /// The earth's rate, rad/s, in the world.
    pub(crate) earth_rate: DVec3,
    /// Others than standstill measure the velocity.
    pub(crate) velocity_is_measured: bool,
}

/// Whether the camera stands, and what was learnt of how it stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Standstill {
    rest: RestDetector,
    stance: RestDetector,
    belief: Belief,
    /// How long the camera has been at rest, s.
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
        belief: Belief::NEW,
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
        around: Around,
        p: &Parameters,
    ) -> Option<Outcome> {
        if windows.is_empty() {
            return None;
        }
        let earth_rate = state.orientation.conjugate() * around.earth_rate;
        let around = Around { earth_rate, ..around };
        let standing = Standing {
            gyro_bias: state.gyro_bias + earth_rate,
            gyro_bias_sigma: libm::sqrt(state.covariance.variances(GYRO_BIAS).max_element()),
            force: p.gravity_m_s2,
            force_sigma: p.noise.accel_bias_sigma,
        };
        let stance = windows.stance.zip(p.stance);
        let stance = stance.and_then(|(window, p)| self.stance(state, &window, &standing, &p));
        let rest = windows.rest.and_then(|w| self.rest(state, &w, (&standing, &around), p));
        self.velocity_then = state.velocity;
        stance.or(rest)
    }

    fn rest(
        &mut self,
        state: &mut State,
        window: &WindowStatistics,
        (standing, around): (&Standing, &Around),
        p: &Parameters,
    ) -> Option<Outcome> {
        let (interval_s, sigma_m_s) = (p.rest.interval_s(), p.rest.velocity_sigma_m_s);
        let quiet = p.rest.enabled && window.is_rest(standing, &p.rest);
        let timing = (interval_s, around.velocity_is_measured);
        self.at_rest = quiet && self.belief.holds(state, window, sigma_m_s, timing);
        if !quiet {
            self.belief.end_quiet();
        }
        if !self.at_rest {
            self.resting_s = 0.0;
            return None;
        }
        let update = if self.resting_s < SETTLED_S { apply_blind } else { apply_standing };
        self.resting_s += interval_s;
        let outcome = zero_velocity(state, update, sigma_m_s);
        restart_leaky_velocity(state, sigma_m_s);
        // The window is longer than the interval, so successive means are correlated: the noise is
        // counted as if each block came alone.
        let noise = p.noise.gyro_density / libm::sqrt(interval_s);
        let sigma = noise.max(p.rest.turn_sigma_rad_s);
        zero_rate(state, update, window.confirmed_rate - around.earth_rate, sigma);
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
            zero((state, apply_blind), VELOCITY, |s| gained - s.velocity, sigma_m_s)
        })
    }
}

/// How a residual corrects a state.
type Update = fn(&mut State, &Row, f64, f64) -> Outcome;

/// The velocity is zero, with a standard deviation in m/s.
pub(crate) fn zero_velocity(state: &mut State, update: Update, sigma_m_s: f64) -> Outcome {
    zero((state, update), VELOCITY, |s| -s.velocity, sigma_m_s)
}

/// The leaky velocity begins anew at zero, with a standard deviation in m/s.
///
/// It still remembers the motion before, which after braking may be some metres per second. What it
/// knows of the tilt, the velocity knows better at a standstill.
pub(crate) fn restart_leaky_velocity(state: &mut State, sigma_m_s: f64) {
    state.leaky_velocity = DVec3::ZERO;
    let variance = DMat3::from_diagonal(DVec3::splat(sigma_m_s * sigma_m_s));
    state.covariance.set_independent(LEAKY_VELOCITY, variance);
    if let Some(tie) = &mut state.tie {
        (0..3).for_each(|k| tie.shares.scale(LEAKY_VELOCITY.0 + k, 0.0));
    }
}

/// The mean rate over the window, rad/s in the body, is the bias.
pub(crate) fn zero_rate(
    state: &mut State,
    update: Update,
    mean_rate: DVec3,
    sigma_rad_s: f64,
) -> Outcome {
    zero((state, update), GYRO_BIAS, |s| mean_rate - s.gyro_bias, sigma_rad_s)
}

/// A block is off by a residual, which each axis' update changes for the next one.
fn zero(
    (state, update): (&mut State, Update),
    block: Block,
    residual: impl Fn(&State) -> DVec3,
    sigma: f64,
) -> Outcome {
    let mut worst = Outcome { residual: 0.0, nis: 0.0, used: true };
    for axis in 0..3 {
        let off = residual(state)[axis];
        let outcome = update(state, &jacobian(block, axis), off, sigma * sigma);
        if outcome.nis > worst.nis {
            worst = outcome;
        }
    }
    worst
}
