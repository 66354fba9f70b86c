//! What the estimator says of an instant: pose, motion, how well they are known, and from what.

use glam::{DMat3, DVec3};

use super::place::is_position_known;
use super::{Estimator, HeadingOrigin};
use crate::aid_status::{AidStatus, PositionOrigin};
use crate::covariance::{DEVIATION, ORIENTATION, POSITION, VELOCITY};
use crate::drift::Drift;
use crate::frame::{Body, Rotation, World};
use crate::grid::Increment;
use crate::relative::{FieldTie, Station, Tied};
use crate::so3;
use crate::state::State;
use crate::time::{SensorSpan, SensorTime};

/// Pose, motion and their covariances at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Time of validity.
    pub time: SensorTime,
    /// Body to world.
    pub orientation: Rotation<World, Body>,
    /// Position in the world, m.
    pub position: DVec3,
    /// Velocity in the world, m/s.
    pub velocity: DVec3,
    /// Angular rate against the world in the body, bias and earth rate removed, rad/s.
    pub angular_rate: DVec3,
    /// Specific force in the body, bias removed, m/s².
    pub specific_force: DVec3,
    /// Covariance of the orientation error about the world axes, rad².
    pub orientation_covariance: DMat3,
    /// Covariance of the position, m².
    pub position_covariance: DMat3,
    /// Covariance of the velocity, (m/s)².
    pub velocity_covariance: DMat3,
    /// How the orientation's error hangs on the field at this place.
    pub field: FieldTie,
    /// What its errors have in common with another camera's, against which it was measured.
    pub tie: Option<Tied>,
    /// How far its errors have moved on.
    pub drift: Drift,
    /// Where the heading comes from.
    pub heading_origin: HeadingOrigin,
    /// Where the position comes from.
    pub position_origin: PositionOrigin,
    /// The aids of the last second.
    pub aids: AidStatus,
    /// The camera stands.
    pub at_rest: bool,
    /// The magnetic field does not fit the reference.
    pub magnetic_disturbance: bool,
    /// The field in the world, smoothed, µT, if the magnetometer spoke.
    pub magnetic_field_ut: Option<DVec3>,
}

impl Estimate {
    /// The same in a time that runs the other way: what an estimator that goes back in time
    /// ([`Estimator::reversed`]) says of the past.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self {
            time: SensorTime::from_nanos(-self.time.as_nanos()),
            velocity: -self.velocity,
            angular_rate: -self.angular_rate,
            ..*self
        }
    }

    /// What a relative pose needs of it.
    pub fn station(&self) -> Station {
        Station {
            orientation: self.orientation,
            orientation_covariance: self.orientation_covariance,
            angular_rate: self.angular_rate,
            position: self.position,
            position_covariance: self.position_covariance,
            velocity: self.velocity,
            velocity_covariance: self.velocity_covariance,
            at_rest: self.at_rest,
            field: self.field,
        }
    }

    /// Whether anything is known of the position.
    pub fn is_position_known(&self) -> bool {
        is_position_known(self.position_covariance)
    }
}

impl Estimator {
    /// Pose and motion at the end of the last step, once aligned.
    pub fn estimate(&self) -> Option<Estimate> {
        self.estimate_ahead(&Increment::ZERO)
    }

    /// Pose and motion a little later: the last step's, carried on over what the grid holds beyond.
    pub fn estimate_ahead(&self, beyond: &Increment) -> Option<Estimate> {
        let state = self.state.as_ref()?;
        if !(self.covariance_is_sound && state.has_finite_values()) {
            return None;
        }
        let latest = if beyond.span_s > 0.0 { beyond } else { &self.last };
        let per_second = latest.span_s.recip();
        let earth_rate = state.orientation.conjugate() * self.aids.earth_rate(&self.parameters);
        let angular_rate = latest.angle * per_second - state.gyro_bias - earth_rate;
        let specific_force = latest.velocity * per_second - state.accel_bias;
        let span_s = beyond.span_s + self.parameters.lead_s;
        let gain =
            (state.orientation * specific_force - DVec3::Z * self.parameters.gravity_m_s2) * span_s;
        let turned = state.orientation * so3::exp(angular_rate * span_s);
        let block = |b| state.covariance.block(b, b);
        let aids = self.aids.ledger.status();
        Some(Estimate {
            time: self.time + SensorSpan::from_secs_f64(beyond.span_s),
            orientation: Rotation::from_unit(so3::renormalise(turned)),
            position: state.position + (state.velocity + 0.5 * gain) * span_s,
            velocity: state.velocity + gain,
            angular_rate,
            specific_force,
            orientation_covariance: self.orientation_covariance(state),
            position_covariance: block(POSITION),
            velocity_covariance: block(VELOCITY),
            field: self.field_tie(state),
            tie: Tied::of(state),
            drift: state.drift,
            heading_origin: self.aids.heading_origin,
            position_origin: aids.position_origin(),
            aids,
            at_rest: self.aids.standstill.stands(),
            magnetic_disturbance: self.aids.compass.is_disturbed(),
            magnetic_field_ut: self.aids.compass.field_ut(),
        })
    }

    /// The filter's own covariance, and what no filter learns about a compass, as far as the heading is its
    /// own: an anchor's has that already.
    fn orientation_covariance(&self, state: &State) -> DMat3 {
        let mut covariance = state.covariance.block(ORIENTATION, ORIENTATION);
        let own =
            state.tie.as_ref().map_or(1.0, |tie| (1.0 - tie.shares.of_heading()).clamp(0.0, 1.0));
        let beyond = own
            * match self.aids.heading_origin {
                HeadingOrigin::Arbitrary => core::f64::consts::PI,
                HeadingOrigin::PoseFix => 0.0,
                _ => self.parameters.compass.systematic_sigma_rad,
            };
        covariance.z_axis.z += beyond * beyond;
        covariance
    }

    fn field_tie(&self, state: &State) -> FieldTie {
        let p = &self.parameters.compass;
        FieldTie {
            with_orientation_rad2: state.covariance.with_state(ORIENTATION, DEVIATION),
            variance_rad2: state.covariance.variance(DEVIATION),
            prior_variance_rad2: p.deviation_sigma_rad * p.deviation_sigma_rad,
            way_m: p.deviation_way_m,
        }
    }
}
