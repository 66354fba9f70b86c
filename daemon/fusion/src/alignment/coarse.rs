//! Coarse alignment of a camera that does not come to rest.
//!
//! Over a second or two the gyroscope alone keeps the body's turns, so specific force and field are
//! averaged in the frame that the body had at the start. The mean force is gravity, but for what the
//! camera sped up meanwhile: a change of speed of 2 m/s in 1.8 s tilts it by 6 degrees, and where
//! the field dips steeply, a tilt turns the heading by more than itself. All this is in the covariance,
//! correlations included, so that levelling corrects the heading too. Compare Groves, ch. 5.6.3
//! (quasi-stationary alignment).

use glam::{DMat3, DQuat, DVec3};

use super::{Aligned, level};
use crate::covariance::{
    ACCEL_BIAS, Covariance, DEVIATION, GYRO_BIAS, LEAKY_VELOCITY, MAG_DELAY, ORIENTATION, VELOCITY,
};
use crate::grid::{Increment, Step};
use crate::parameters::Parameters;
use crate::so3;
use crate::state::State;
use crate::update::compass;

/// What was felt since the first step, in the body's frame at the first step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coarse {
    span_s: f64,
    /// Body now to body at the first step.
    turned: DQuat,
    /// Integral of the specific force, m/s.
    gained: DVec3,
    field_sum: DVec3,
    field_count: f64,
}

impl Coarse {
    pub(super) const NONE: Self = Self {
        span_s: 0.0,
        turned: DQuat::IDENTITY,
        gained: DVec3::ZERO,
        field_sum: DVec3::ZERO,
        field_count: 0.0,
    };

    pub(super) fn push(&mut self, step: &Step) {
        let Increment { span_s, angle, velocity } = step.increment;
        self.gained += self.turned * (velocity + 0.5 * angle.cross(velocity));
        self.turned = so3::renormalise(self.turned * so3::exp(angle));
        self.span_s += span_s;
        if let Some(mag) = step.mag {
            self.field_sum += self.turned * mag.vector;
            self.field_count += 1.0;
        }
    }

    /// The first state, if enough was felt; begins anew where the mean force cannot be gravity.
    pub(super) fn conclude(&mut self, p: &Parameters) -> Option<Aligned> {
        let needed_s = p.alignment.motion_s?;
        if self.span_s < needed_s {
            return None;
        }
        let force = libm::sqrt(self.gained.length_squared()) / self.span_s;
        if (force - p.gravity_m_s2).abs() > p.alignment.motion_speed_sigma_m_s / self.span_s {
            *self = Self::NONE;
            return None;
        }
        Some(self.aligned(p))
    }

    fn aligned(&self, p: &Parameters) -> Aligned {
        let level = level(self.gained);
        let field = (self.field_count > 0.0).then(|| level * (self.field_sum / self.field_count));
        let bearing = field.and_then(compass::bearing);
        let heading = so3::exp(DVec3::Z * bearing.map_or(0.0, |b| b - p.field_bearing_rad));
        let field = field.map(|f| heading * f);
        let orientation = so3::renormalise(heading * level * self.turned);
        let mut state = State::at(orientation);
        state.covariance = self.covariance(state.matrix(), field, p);
        Aligned { state, field, field_span_s: self.span_s, at_rest: false, detector: None }
    }

    fn covariance(&self, matrix: DMat3, field: Option<DVec3>, p: &Parameters) -> Covariance {
        let square = |x: f64| x * x;
        let (n, a) = (&p.noise, &p.alignment);
        let alike = |sigma: f64| DMat3::IDENTITY * square(sigma);
        let mut cov = Covariance::ZERO;
        cov.set_independent(GYRO_BIAS, alike(n.gyro_bias_sigma));
        cov.set_independent(ACCEL_BIAS, alike(n.accel_bias_sigma));
        cov.set_independent(VELOCITY, alike(a.motion_start_sigma_m_s));
        cov.set_independent(LEAKY_VELOCITY, alike(a.motion_speed_sigma_m_s));
        cov.add_variance(MAG_DELAY, square(p.compass.delay_sigma_s));
        let deviation = square(p.compass.deviation_sigma_rad);
        cov.add_variance(DEVIATION, deviation);

        let by_speed = square(a.motion_speed_sigma_m_s / (self.span_s * p.gravity_m_s2));
        cov.set_independent(ORIENTATION, DMat3::from_diagonal(DVec3::new(by_speed, by_speed, 0.0)));
        let to_tilt = so3::skew(DVec3::Z) * matrix * p.gravity_m_s2.recip();
        cov.shear(ORIENTATION, to_tilt, ACCEL_BIAS);
        if let Some(field) = field
            && let Some(row) = compass::jacobian(field, DVec3::ZERO)
        {
            // The heading was set so that the field points where it belongs.
            let horizontal_ut2 = field.x * field.x + field.y * field.y;
            let noise = square(n.mag_sigma_ut) / (self.field_count * horizontal_ut2);
            cov.tie(ORIENTATION.0 + 2, &row, noise);
        }
        // Turned by the gyroscope: half of the span on average since force and field were felt.
        cov.shear(ORIENTATION, matrix * (-0.5 * self.span_s), GYRO_BIAS);
        cov.restore();
        cov
    }
}

#[cfg(test)]
mod tests;
