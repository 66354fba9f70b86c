//! Prediction over one grid step: strapdown of the nominal state, shears of the covariance.
//!
//! Mechanisation in the world frame: `Ṙ = R [ω − Rᵀ Ω]×`, `v̇ = R f + g − 2 Ω × v`, `ṗ = v`, with the
//! earth's rate Ω in the world (Titterton and Weston, ch. 3.5; Groves, ch. 5.3). Gravity is that of a
//! plumb line. Error model with the orientation error about the world axes, in which Ω (a degree
//! in four minutes) changes nothing that the noise does not cover:
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
    gyro_aliasing: f64,
    accel_aliasing: f64,
    gyro_lag_s: f64,
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
            gyro_aliasing: p.noise.gyro_aliasing * p.noise.gyro_aliasing,
            accel_aliasing: p.noise.accel_aliasing * p.noise.accel_aliasing,
            gyro_lag_s: p.gyro_lag_s,
            leak_rate: p.levelling.time_constant_s.recip(),
            gravity: DVec3::new(0.0, 0.0, -p.gravity_m_s2),
        }
    }
}

/// What is known of the ground that the camera moves above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ground {
    /// The earth's rate in the world, rad/s, as far as it is known.
    pub(crate) earth_rate: DVec3,
    /// The camera stands on it.
    pub(crate) stands: bool,
}

/// What the nominal state went through since the covariance last followed.
///
/// The covariance is some thousand operations wide and changes slowly; so steps are summed up, and it
/// follows once in [`FOLLOW_S`], or before anything that reads or corrects it (Groves, ch. 3.2.4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pending {
    /// Time, s.
    pub(crate) span_s: f64,
    /// Time in which the position followed the velocity, s.
    moved_s: f64,
    /// `∫ R dt`, s.
    turned: DMat3,
    /// `∫ R f dt`, m/s in the world.
    gained: DVec3,
    /// Angle turned through, whatever the axis, rad.
    turn_rad: f64,
    /// Sum of the squared changes of the angle from step to step, rad².
    rate_change: f64,
    /// Sum of the squared changes of the velocity gain from step to step, (m/s)².
    force_change: f64,
}

/// Longest time the covariance lags behind: a hundredth of a second turns a fast hand by 0.1 rad,
/// which the sums above still resolve step by step.
pub(crate) const FOLLOW_S: f64 = 0.01;

impl Pending {
    pub(crate) const NONE: Self = Self {
        span_s: 0.0,
        moved_s: 0.0,
        turned: DMat3::ZERO,
        gained: DVec3::ZERO,
        turn_rad: 0.0,
        rate_change: 0.0,
        force_change: 0.0,
    };
}

/// Integrals over a step, bias removed, in the body frame at its start.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Gains {
    /// `∫ ω dt`, rad.
    angle: DVec3,
    /// `∫ f dt`, m/s.
    velocity: DVec3,
}

/// The steps before, which tell how rate and force change within a step.
///
/// Integrals alone do not say in which order turns about different axes were made, nor at which
/// attitude a velocity was gained. Both are read off the change from step to step (Ignagni 1996,
/// coning from the increments before; Roscoe 2001, the same coefficients for sculling):
///
/// ```text
/// φ  = Δα + Σ cₖ Δαₖ × Δα                                          coning
/// Δv' = Δv + ½ Δα × Δv + ⅙ Δα × (Δα × Δv)                          rotation
///          + Σ cₖ (Δαₖ × Δv + Δvₖ × Δα)                            sculling
/// ```
///
/// with Δαₖ, Δvₖ of k steps before. [`CONING`] makes it exact for rates that change linearly, and
/// in a coning motion to fourth order of the phase that a step covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Strapdown {
    /// The latest first.
    before: Option<[Gains; 2]>,
    /// What the accelerometer gave in the steps before, the latest first, m/s.
    felt: Option<[DVec3; 2]>,
}

/// `c₁ + 2 c₂ = 1/12` integrates a linear rate exactly; `c₁ + 8 c₂ = −1/60` cancels the next term of a
/// coning motion's drift, `½ θ² (φ − sin φ)` for a cone of half-angle θ and a phase φ each step.
const CONING: [f64; 2] = [7.0 / 60.0, -1.0 / 60.0];

impl Strapdown {
    /// Nothing before: at the start, and after a gap.
    pub(crate) const NEW: Self = Self { before: None, felt: None };

    /// The rotation vector of a step, rad, and its velocity gain in the attitude at its start, m/s.
    fn resolve(&self, now: &Gains) -> (DVec3, DVec3) {
        let Gains { angle, velocity } = *now;
        let [last, older] = self.before.unwrap_or([*now; 2]);
        let angle_before = last.angle * CONING[0] + older.angle * CONING[1];
        let velocity_before = last.velocity * CONING[0] + older.velocity * CONING[1];
        let rotation = angle_before.cross(angle) + angle;
        let sculling = angle_before.cross(velocity) + velocity_before.cross(angle);
        let turning = angle.cross(0.5 * velocity + angle.cross(velocity) * (1.0 / 6.0));
        (rotation, velocity + turning + sculling)
    }

    /// A step's velocity gain as it was when the gyroscope's angle was: an older one, by a part of a
    /// step or two, where the gyroscope is the slower sensor.
    fn synchronous(&mut self, velocity: DVec3, lag_steps: f64) -> DVec3 {
        let [last, older] = self.felt.unwrap_or([velocity; 2]);
        self.felt = Some([velocity, last]);
        if lag_steps < 1.0 {
            velocity + (last - velocity) * lag_steps
        } else {
            last + (older - last) * (lag_steps - 1.0).min(1.0)
        }
    }

    /// Keeps a step for the next ones, and what changed since the one before.
    fn keep(&mut self, now: Gains, pending: &mut Pending) {
        let last = self.before.map_or(now, |[last, _]| last);
        pending.rate_change += (now.angle - last.angle).length_squared();
        pending.force_change += (now.velocity - last.velocity).length_squared();
        self.before = Some([now, last]);
    }

    /// Advances the nominal state by one increment; gives the angle of the step's turn, rad.
    ///
    /// Where the camera stands, its position stays: what little velocity the filter believes in is an
    /// error. So the error of the position stays too, and [`follow`] leaves it as it is.
    pub(crate) fn advance(
        &mut self,
        state: &mut State,
        pending: &mut Pending,
        increment: &Increment,
        (noise, ground): (&ProcessNoise, Ground),
    ) -> f64 {
        let dt = increment.span_s;
        let before = state.matrix();
        let drift = state.gyro_bias + before.transpose() * ground.earth_rate;
        let felt = self.synchronous(increment.velocity, noise.gyro_lag_s / dt);
        let now =
            Gains { angle: increment.angle - drift * dt, velocity: felt - state.accel_bias * dt };
        let (angle, gained) = self.resolve(&now);
        self.keep(now, pending);
        let force_gain = before * gained;
        let coriolis = -2.0 * ground.earth_rate.cross(state.velocity);
        let gain = force_gain + (noise.gravity + coriolis) * dt;
        if !ground.stands {
            state.position += (state.velocity + 0.5 * gain) * dt;
            pending.moved_s += dt;
        }
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
}

/// Lets the covariance follow what is pending.
pub(crate) fn follow(state: &mut State, pending: &mut Pending, noise: &ProcessNoise) {
    let Pending { span_s, moved_s, turned, gained, turn_rad, rate_change, force_change } =
        core::mem::replace(pending, Pending::NONE);
    if span_s <= 0.0 {
        return;
    }
    let p = &mut state.covariance;
    // Later states first: each shear must see the others as they were before.
    if moved_s > 0.0 {
        p.shear_scalar(POSITION, moved_s, VELOCITY);
    }
    let by_tilt = so3::skew(-gained);
    p.shear_alike([VELOCITY, LEAKY_VELOCITY], [(by_tilt, ORIENTATION), (-turned, ACCEL_BIAS)]);
    p.shear(ORIENTATION, -turned, GYRO_BIAS);
    let kept = 1.0 - noise.leak_rate * span_s;
    p.scale(LEAKY_VELOCITY.0, 3, kept);
    if let Some(tie) = &mut state.tie {
        tie.age_s += span_s;
        tie.shares.follow(moved_s, (by_tilt, turned), kept);
    }

    let by_turning = noise.gyro_scale * turn_rad + noise.gyro_aliasing * rate_change;
    // What a standing camera seems to turn is noise, which is counted as such. Against the compass that
    // makes no difference, against another camera it is most of all.
    let by_noise = noise.gyro * span_s;
    let against_others = by_noise + if moved_s > 0.0 { by_turning } else { 0.0 };
    state.drift.pass(p, against_others, (span_s, moved_s));
    let by_noise = if state.tie.is_some() { against_others } else { by_noise + by_turning };
    p.add_variances(ORIENTATION, DVec3::splat(by_noise));
    let velocity = DVec3::splat(noise.accel * span_s + noise.accel_aliasing * force_change);
    p.add_variances(VELOCITY, velocity);
    p.add_variances(LEAKY_VELOCITY, velocity);
    p.add_variances(GYRO_BIAS, DVec3::splat(noise.gyro_bias * span_s));
    p.add_variances(ACCEL_BIAS, DVec3::splat(noise.accel_bias * span_s));
    p.restore();
}

#[cfg(test)]
mod tests;
