//! Prediction over one grid step: strapdown of the nominal state, shears of the covariance.
//!
//! Mechanisation in the world frame: `Ṙ = R [ω]×`, `v̇ = R f + g`, `ṗ = v` (Titterton and Weston,
//! ch. 3, without the earth rate). Error model with the orientation error about the world axes:
//!
//! ```text
//! δθ̇ = −R δb_g            δv̇ = −[R f]× δθ − R δb_a          δṗ = δv
//! δu̇ = δv̇ − δu / τ         (leaky velocity)
//! ```

use glam::{DMat3, DVec3};

use crate::covariance::{ACCEL_BIAS, GYRO_BIAS, LEAKY_VELOCITY, ORIENTATION, POSITION, VELOCITY};
use crate::grid::Increment;
use crate::parameters::Parameters;
use crate::so3;
use crate::state::State;

/// Factors that depend on the parameters alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ProcessNoise {
    gyro: f64,
    gyro_bias: f64,
    gyro_scale: f64,
    accel: f64,
    accel_bias: f64,
    leak_rate: f64,
    gravity: DVec3,
}

impl ProcessNoise {
    pub(crate) fn new(p: &Parameters) -> Self {
        Self {
            gyro: p.noise.gyro_density * p.noise.gyro_density,
            gyro_bias: p.noise.gyro_bias_walk * p.noise.gyro_bias_walk,
            gyro_scale: p.noise.gyro_scale_walk * p.noise.gyro_scale_walk,
            accel: p.noise.accel_density * p.noise.accel_density,
            accel_bias: p.noise.accel_bias_walk * p.noise.accel_bias_walk,
            leak_rate: p.levelling.time_constant_s.recip(),
            gravity: DVec3::new(0.0, 0.0, -p.gravity_m_s2),
        }
    }
}

/// What the nominal state went through since the covariance last followed.
///
/// The covariance is some thousand operations wide and changes slowly; so steps are summed up, and it
/// follows once in [`FOLLOW_S`], or before anything that reads or corrects it (Groves, ch. 3.2.4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pending {
    /// Time, s.
    pub(crate) span_s: f64,
    /// `∫ R dt`, s.
    turned: DMat3,
    /// `∫ R f dt`, m/s in the world.
    gained: DVec3,
    /// Angle turned through, whatever the axis, rad.
    turn_rad: f64,
}

/// Longest time the covariance lags behind: a hundredth of a second turns a fast hand by 0.1 rad,
/// which the sums above still resolve step by step.
pub(crate) const FOLLOW_S: f64 = 0.01;

impl Pending {
    pub(crate) const NONE: Self =
        Self { span_s: 0.0, turned: DMat3::ZERO, gained: DVec3::ZERO, turn_rad: 0.0 };
}

/// Advances the nominal state by one increment; gives the angle of its turn, rad.
pub(crate) fn advance(
    state: &mut State,
    pending: &mut Pending,
    increment: &Increment,
    noise: &ProcessNoise,
) -> f64 {
    let dt = increment.span_s;
    let angle = increment.angle - state.gyro_bias * dt;
    let gained = increment.velocity - state.accel_bias * dt;
    let before = state.matrix();
    // Rotation compensation: the velocity was gained while the body turned (Savage, sculling to
    // first order), so it is resolved in the attitude half-way.
    let force_gain = before * (gained + 0.5 * angle.cross(gained));
    let gain = force_gain + noise.gravity * dt;
    state.position += (state.velocity + 0.5 * gain) * dt;
    state.velocity += gain;
    state.leaky_velocity = (state.leaky_velocity + gain) * (1.0 - noise.leak_rate * dt);
    state.orientation = so3::renormalise(state.orientation * so3::exp(angle));

    let turn_rad = libm::sqrt(angle.length_squared());
    pending.span_s += dt;
    pending.turned += before * dt;
    pending.gained += force_gain;
    pending.turn_rad += turn_rad;
    turn_rad
}

/// Lets the covariance follow what is pending.
pub(crate) fn follow(state: &mut State, pending: &mut Pending, noise: &ProcessNoise) {
    let Pending { span_s, turned, gained, turn_rad } = core::mem::replace(pending, Pending::NONE);
    if span_s <= 0.0 {
        return;
    }
    let p = &mut state.covariance;
    // Later states first: each shear must see the others as they were before.
    p.shear_scalar(POSITION, span_s, VELOCITY);
    let by_tilt = so3::skew(-gained);
    p.shear_alike([VELOCITY, LEAKY_VELOCITY], [(by_tilt, ORIENTATION), (-turned, ACCEL_BIAS)]);
    p.shear(ORIENTATION, -turned, GYRO_BIAS);
    p.scale(LEAKY_VELOCITY.0, 3, 1.0 - noise.leak_rate * span_s);

    p.add_variances(ORIENTATION, DVec3::splat(noise.gyro * span_s + noise.gyro_scale * turn_rad));
    p.add_variances(VELOCITY, DVec3::splat(noise.accel * span_s));
    p.add_variances(LEAKY_VELOCITY, DVec3::splat(noise.accel * span_s));
    p.add_variances(GYRO_BIAS, DVec3::splat(noise.gyro_bias * span_s));
    p.add_variances(ACCEL_BIAS, DVec3::splat(noise.accel_bias * span_s));
    p.restore();
}

#[cfg(test)]
mod tests;
