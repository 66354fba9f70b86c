//! The inertial motion of the last seconds: from the present state back to a time of validity.
//!
//! A measurement that comes late says something about a state that was. That state follows from the
//! present one by running the strapdown backwards over the motion since, with the biases as they are
//! known now: so whatever was corrected meanwhile counts. The errors of both are tied by the same
//! motion. With `Δ = ∫ R f dt` and `A = ∫ R dt` from then to now, and [`crate::predict`]'s error model,
//!
//! ```text
//! δθ(then) = δθ + A δb_g
//! δv(then) = δv + [Δ]× δθ + ∫ [R f]× A dt δb_g + A δb_a
//! δp(then) = δp − ∫ δv(t) dt
//! ```
//!
//! so a Jacobian about the past becomes one about the present (Larsen et al. 1998, "Incorporation of
//! time delayed measurements in a discrete-time Kalman filter", for the idea). Noise of the inertial
//! sensors within these two seconds is left out: it is small against what is measured.

use glam::{DMat3, DQuat, DVec3};

use crate::covariance::{ACCEL_BIAS, Block, GYRO_BIAS, ORIENTATION, POSITION, Row, VELOCITY};
use crate::grid::Increment;
use crate::so3;
use crate::state::State;

/// Length of a block, s: a fast hand turns by 0.1 rad within it, a vehicle by 0.02.
const BLOCK_S: f64 = 0.02;
/// Blocks kept: two seconds.
const BLOCKS: usize = 100;
/// Shortest stretch over which a rate is averaged, s: one sample's is noisy.
const RATE_OVER_S: f64 = 0.25 * BLOCK_S;

/// Motion over a short stretch, biases included, in the body frame at its start.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stretch {
    span_s: f64,
    angle: DVec3,
    velocity: DVec3,
}

impl Stretch {
    const NONE: Self = Self { span_s: 0.0, angle: DVec3::ZERO, velocity: DVec3::ZERO };

    fn add(&mut self, step: &Increment) {
        // Resolved in the attitude half-way through the step.
        let turned = self.angle + 0.5 * step.angle;
        self.velocity += step.velocity + turned.cross(step.velocity);
        self.angle += step.angle;
        self.span_s += step.span_s;
    }
}

/// What surrounds the motion: gravity, m/s², and the earth's rate, rad/s, in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Surroundings {
    pub(crate) gravity: DVec3,
    pub(crate) earth_rate: DVec3,
}

/// A ring of stretches, the open one at its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct History {
    stretches: [Stretch; BLOCKS],
    next: usize,
    filled: usize,
    open: Stretch,
}

/// The state as it was, and how its errors hang on those of the present one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Past {
    /// Body to world.
    pub(crate) orientation: DQuat,
    /// m/s in the world.
    pub(crate) velocity: DVec3,
    /// m in the world.
    pub(crate) position: DVec3,
    /// Angular rate in the body, bias removed, rad/s.
    pub(crate) rate: DVec3,
    /// Specific force in the body, bias removed, m/s².
    pub(crate) force: DVec3,
    /// How long ago, s.
    pub(crate) ago_s: f64,
    /// `A` and its integral.
    turned: [DMat3; 2],
    /// `Δ` and its integral.
    gained: [DVec3; 2],
    /// `∫ [R f]× A dt` and its integral.
    by_bias: [DMat3; 2],
}

impl History {
    pub(crate) const EMPTY: Self =
        Self { stretches: [Stretch::NONE; BLOCKS], next: 0, filled: 0, open: Stretch::NONE };

    /// Takes the motion of one step, as measured.
    pub(crate) fn push(&mut self, step: &Increment) {
        self.open.add(step);
        // Half a step of tolerance: rounding must not make blocks longer.
        if self.open.span_s + 0.5 * step.span_s < BLOCK_S {
            return;
        }
        self.stretches[self.next] = self.open;
        self.next = (self.next + 1) % BLOCKS;
        self.filled = (self.filled + 1).min(BLOCKS);
        self.open = Stretch::NONE;
    }

    /// The state some time ago, s; `None` beyond what is kept.
    pub(crate) fn past(&self, state: &State, ago_s: f64, around: &Surroundings) -> Option<Past> {
        let mut past = Past::present(state);
        let mut left_s = ago_s;
        let mut rate_known = false;
        for stretch in self.backwards() {
            if !rate_known && left_s <= stretch.span_s {
                rate_known = past.note_rate(stretch, state);
            }
            if left_s > 0.0 {
                let share = (left_s / stretch.span_s).min(1.0);
                past.retreat(stretch, share, state, around);
                left_s -= stretch.span_s * share;
            }
            if left_s <= 0.0 && rate_known {
                break;
            }
        }
        (left_s <= 1e-9).then_some(past)
    }

    /// The stretches, the latest first.
    fn backwards(&self) -> impl Iterator<Item = &Stretch> {
        let kept = (1..=self.filled).map(|k| &self.stretches[(self.next + BLOCKS - k) % BLOCKS]);
        core::iter::once(&self.open).chain(kept).filter(|stretch| stretch.span_s > 0.0)
    }
}

impl Past {
    /// The present.
    fn present(state: &State) -> Self {
        Self {
            orientation: state.orientation,
            velocity: state.velocity,
            position: state.position,
            rate: DVec3::ZERO,
            force: DVec3::ZERO,
            ago_s: 0.0,
            turned: [DMat3::ZERO; 2],
            gained: [DVec3::ZERO; 2],
            by_bias: [DMat3::ZERO; 2],
        }
    }

    /// Takes rate and force from a stretch that is long enough for it.
    fn note_rate(&mut self, stretch: &Stretch, state: &State) -> bool {
        self.rate = stretch.angle / stretch.span_s - state.gyro_bias;
        self.force = stretch.velocity / stretch.span_s - state.accel_bias;
        stretch.span_s >= RATE_OVER_S
    }

    /// Goes back over the last part of a stretch.
    fn retreat(&mut self, stretch: &Stretch, share: f64, state: &State, around: &Surroundings) {
        let (whole_s, span_s) = (stretch.span_s, stretch.span_s * share);
        let end = DMat3::from_quat(self.orientation);
        let bias = state.gyro_bias + end.transpose() * around.earth_rate;
        let angle = stretch.angle - bias * whole_s;
        let start = end * DMat3::from_quat(so3::exp(-angle));
        // The velocity was summed in an attitude that turned with the bias.
        let unbent = stretch.velocity - (0.5 * whole_s) * bias.cross(stretch.velocity);
        let force = start * (unbent - state.accel_bias * whole_s) * share;
        let coriolis = -2.0 * around.earth_rate.cross(self.velocity);
        let gain = force + (around.gravity + coriolis) * span_s;

        self.account(end * DMat3::from_quat(so3::exp(angle * (-0.5 * share))), force, span_s);
        self.position -= (self.velocity - 0.5 * gain) * span_s;
        self.velocity -= gain;
        self.orientation = so3::renormalise(self.orientation * so3::exp(-angle * share));
        self.ago_s += span_s;
    }

    /// Adds a stretch to the integrals from then to now: its mean attitude, and its gain by force.
    fn account(&mut self, attitude: DMat3, force: DVec3, span_s: f64) {
        let turned = attitude * span_s;
        let by_bias = so3::skew(force) * (self.turned[0] + 0.5 * turned);
        self.turned[1] += (self.turned[0] + 0.5 * turned) * span_s;
        self.gained[1] += (self.gained[0] + 0.5 * force) * span_s;
        self.by_bias[1] += (self.by_bias[0] + 0.5 * by_bias) * span_s;
        self.turned[0] += turned;
        self.gained[0] += force;
        self.by_bias[0] += by_bias;
    }

    /// A row of a Jacobian about the errors of the past, as one about the errors of the present.
    pub(crate) fn carry(&self, row: &Row) -> Row {
        let part = |b: Block| DVec3::new(row[b.0], row[b.0 + 1], row[b.0 + 2]);
        let (angle, velocity, position) = (part(ORIENTATION), part(VELOCITY), part(POSITION));
        let back = |m: &[DMat3; 2]| m[0].transpose() * velocity - m[1].transpose() * position;
        let mut carried = *row;
        let mut add = |b: Block, v: DVec3| (0..3).for_each(|k| carried[b.0 + k] += v[k]);
        add(ORIENTATION, velocity.cross(self.gained[0]) - position.cross(self.gained[1]));
        add(VELOCITY, -position * self.ago_s);
        add(GYRO_BIAS, self.turned[0].transpose() * angle + back(&self.by_bias));
        add(ACCEL_BIAS, back(&self.turned));
        carried
    }
}

#[cfg(test)]
mod tests;
