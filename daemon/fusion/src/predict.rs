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

/// Advances the state by one increment.
pub(crate) fn predict(state: &mut State, increment: &Increment, noise: &ProcessNoise) {
    let dt = increment.span_s;
    let angle = increment.angle - state.gyro_bias * dt;
    let gained = increment.velocity - state.accel_bias * dt;
    // Rotation compensation: the velocity was gained while the body turned (Savage, sculling to
    // first order), so it is resolved in the attitude half-way.
    let gained_start = gained + 0.5 * angle.cross(gained);
    let force_gain = state.orientation * gained_start;
    let before = state.matrix();

    propagate_covariance(state, &Errors { dt, before, force_gain, angle }, noise);

    let gain = force_gain + noise.gravity * dt;
    state.position += (state.velocity + 0.5 * gain) * dt;
    state.velocity += gain;
    state.leaky_velocity = (state.leaky_velocity + gain) * (1.0 - noise.leak_rate * dt);
    state.orientation = so3::renormalise(state.orientation * so3::exp(angle));
}

struct Errors {
    dt: f64,
    before: DMat3,
    force_gain: DVec3,
    angle: DVec3,
}

fn propagate_covariance(state: &mut State, e: &Errors, noise: &ProcessNoise) {
    let p = &mut state.covariance;
    let dt = e.dt;
    // Later states first: each shear must see the others as they were before the step.
    p.shear_scalar(POSITION, dt, VELOCITY);
    let by_tilt = so3::skew(-e.force_gain);
    let by_bias = e.before * -dt;
    p.shear_alike([VELOCITY, LEAKY_VELOCITY], [(by_tilt, ORIENTATION), (by_bias, ACCEL_BIAS)]);
    p.shear(ORIENTATION, by_bias, GYRO_BIAS);
    p.scale(LEAKY_VELOCITY.0, 3, 1.0 - noise.leak_rate * dt);

    let turn = libm::sqrt(e.angle.length_squared());
    p.add_variances(ORIENTATION, DVec3::splat(noise.gyro * dt + noise.gyro_scale * turn));
    p.add_variances(VELOCITY, DVec3::splat(noise.accel * dt));
    p.add_variances(LEAKY_VELOCITY, DVec3::splat(noise.accel * dt));
    p.add_variances(GYRO_BIAS, DVec3::splat(noise.gyro_bias * dt));
    p.add_variances(ACCEL_BIAS, DVec3::splat(noise.accel_bias * dt));
}

#[cfg(test)]
mod tests;
