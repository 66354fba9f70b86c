//! The estimator: alignment first, then prediction with its updates, one grid step at a time.

use glam::{DMat3, DVec3};

use crate::aid_status::{AidStatus, PositionOrigin};
use crate::aids::Aids;
use crate::alignment::{Alignment, Waiting};
use crate::covariance::{DEVIATION, ORIENTATION, POSITION, VELOCITY};
use crate::frame::{Body, Rotation, World};
use crate::grid::{Increment, Step};
use crate::parameters::Parameters;
use crate::predict::{Pending, ProcessNoise, advance, follow};
use crate::relative::{FieldTie, Station};
use crate::so3;
use crate::state::State;
use crate::time::{SensorSpan, SensorTime};
use crate::update::Outcome;
use crate::update::compass::CompassReport;

pub(crate) mod place;

/// Where a heading comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeadingOrigin {
    /// There never was a magnetometer reading: the heading counts from the start.
    Arbitrary,
    /// The magnetometer corrects it now.
    Magnetometer,
    /// The gyroscope carries what the magnetometer gave earlier.
    Held,
    /// Only the alignment used the magnetometer.
    InitialOnly,
}

/// What one step did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepReport {
    /// Why there is no state yet; `None` once aligned.
    pub waiting: Option<Waiting>,
    /// The alignment was concluded in this step.
    pub just_aligned: bool,
    /// North was found after an alignment without a magnetometer: the world turned about up, and
    /// earlier poses do not compare.
    pub world_turned: bool,
    /// The camera stands.
    pub at_rest: bool,
    /// The levelling update, if one was due.
    pub levelling: Option<Outcome>,
    /// The heading update, if one was due.
    pub compass: Option<CompassReport>,
}

impl StepReport {
    /// Nothing happened.
    pub(crate) const QUIET: Self = Self {
        waiting: None,
        just_aligned: false,
        world_turned: false,
        at_rest: false,
        levelling: None,
        compass: None,
    };
}

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
    /// Angular rate in the body, bias removed, rad/s.
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
            field: self.field,
        }
    }

    /// Whether anything is known of the position.
    pub fn is_position_known(&self) -> bool {
        place::is_position_known(self.position_covariance)
    }
}

/// The estimator's state; a copy of it saves and restores the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimator {
    parameters: Parameters,
    noise: ProcessNoise,
    alignment: Alignment,
    state: Option<State>,
    pending: Pending,
    aids: Aids,
    time: SensorTime,
    last: Increment,
}

/// An unseen turn during a gap, per second of gap: a fast hand movement.
const GAP_RATE_RAD_S: f64 = 1.0;
/// An unseen acceleration during a gap.
const GAP_ACCELERATION_M_S2: f64 = 3.0;
/// No camera's attitude is less known than after half a turn, nor its speed than on a motorway; a
/// larger variance would only swamp the rest of the covariance by rounding.
const GAP_TURN_LIMIT_RAD: f64 = core::f64::consts::PI;
const GAP_SPEED_LIMIT_M_S: f64 = 50.0;

impl Estimator {
    /// An estimator that waits for its alignment.
    pub fn new(parameters: Parameters) -> Self {
        Self {
            parameters,
            noise: ProcessNoise::new(&parameters),
            alignment: Alignment::new(),
            state: None,
            pending: Pending::NONE,
            aids: Aids::new(&parameters),
            time: SensorTime::from_nanos(0),
            last: Increment::ZERO,
        }
    }

    /// Advances by one grid step.
    pub fn step(&mut self, step: &Step) -> StepReport {
        self.time = step.time;
        self.last = step.increment;
        let Some(state) = &mut self.state else {
            return self.align(step);
        };
        let turn_rad = advance(state, &mut self.pending, &step.increment, &self.noise);
        let settings = (&self.parameters, &self.noise);
        self.aids.step(state, &mut self.pending, (step, turn_rad), settings)
    }

    /// Accounts for a stretch of time without samples, too long to bridge.
    pub fn cross_gap(&mut self, span: SensorSpan) {
        let gap_s = span.as_secs_f64();
        self.aids.cross_gap();
        self.alignment = Alignment::new();
        let Some(state) = &mut self.state else { return };
        follow(state, &mut self.pending, &self.noise);
        let turn = (GAP_RATE_RAD_S * gap_s).min(GAP_TURN_LIMIT_RAD);
        let speed = (GAP_ACCELERATION_M_S2 * gap_s).min(GAP_SPEED_LIMIT_M_S);
        let way = (libm::sqrt(state.velocity.length_squared()) + 0.5 * speed) * gap_s;
        state.covariance.add_variances(ORIENTATION, DVec3::splat(turn * turn));
        state.covariance.add_variances(VELOCITY, DVec3::splat(speed * speed));
        state.covariance.add_variances(POSITION, DVec3::splat(way * way));
    }

    /// The state, once aligned.
    pub const fn state(&self) -> Option<&State> {
        self.state.as_ref()
    }

    /// The undisturbed field that the compass expects, in the world, µT; `None` without a magnetometer.
    pub fn expected_field_ut(&self) -> Option<DVec3> {
        let reference = self.aids.compass.reference()?;
        Some(reference.in_world(self.parameters.field_bearing_rad))
    }

    /// Pose and motion at the end of the last step, once aligned.
    pub fn estimate(&self) -> Option<Estimate> {
        self.estimate_ahead(&Increment::ZERO)
    }

    /// Pose and motion a little later: the last step's, carried on over what the grid holds beyond.
    pub fn estimate_ahead(&self, beyond: &Increment) -> Option<Estimate> {
        let state = self.state.as_ref()?;
        let latest = if beyond.span_s > 0.0 { beyond } else { &self.last };
        let per_second = latest.span_s.recip();
        let angular_rate = latest.angle * per_second - state.gyro_bias;
        let specific_force = latest.velocity * per_second - state.accel_bias;
        let span_s = beyond.span_s + self.parameters.lead_s;
        let gain =
            (state.orientation * specific_force - DVec3::Z * self.parameters.gravity_m_s2) * span_s;
        let turned = state.orientation * so3::exp(angular_rate * span_s);
        let block = |b| state.covariance.block(b, b);
        state.is_finite().then(|| Estimate {
            time: self.time + SensorSpan::from_secs_f64(beyond.span_s),
            orientation: Rotation::from_unit(so3::renormalise(turned)),
            position: state.position + (state.velocity + 0.5 * gain) * span_s,
            velocity: state.velocity + gain,
            angular_rate,
            specific_force,
            orientation_covariance: self.orientation_covariance(block(ORIENTATION)),
            position_covariance: block(POSITION),
            velocity_covariance: block(VELOCITY),
            field: self.field_tie(state),
            heading_origin: self.aids.heading_origin,
            position_origin: self.aids.ledger.status().position_origin(),
            aids: self.aids.ledger.status(),
            at_rest: self.aids.at_rest,
            magnetic_disturbance: self.aids.compass.is_disturbed(),
            magnetic_field_ut: self.aids.compass.field_ut(),
        })
    }

    /// The filter's own covariance, and what no filter learns about a compass.
    fn orientation_covariance(&self, mut covariance: DMat3) -> DMat3 {
        let beyond = match self.aids.heading_origin {
            HeadingOrigin::Arbitrary => core::f64::consts::PI,
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

    fn align(&mut self, step: &Step) -> StepReport {
        let Some(aligned) = self.alignment.push(step, &self.parameters) else {
            return StepReport { waiting: Some(self.alignment.waiting()), ..StepReport::QUIET };
        };
        self.state = Some(aligned.state);
        self.aids.begin(aligned.at_rest);
        if let Some(field) = aligned.field {
            self.aids.begin_with(field, aligned.field_span_s, self.parameters.heading);
        }
        StepReport { just_aligned: true, at_rest: aligned.at_rest, ..StepReport::QUIET }
    }
}
