//! The estimator: alignment first, then prediction with its updates, one grid step at a time.

use glam::{DMat3, DVec3};

use crate::alignment::{Alignment, Waiting};
use crate::covariance::{GYRO_BIAS, ORIENTATION, POSITION, VELOCITY};
use crate::frame::{Body, Rotation, World};
use crate::grid::{Increment, Step};
use crate::parameters::{HeadingMode, Parameters};
use crate::predict::{ProcessNoise, predict};
use crate::rest::{RestDetector, WindowStatistics};
use crate::so3;
use crate::state::State;
use crate::time::{SensorSpan, SensorTime};
use crate::update::compass::{Compass, CompassReport, FieldAverage};
use crate::update::{Outcome, levelling, standstill};

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
    /// Where the heading comes from.
    pub heading_origin: HeadingOrigin,
    /// The camera stands.
    pub at_rest: bool,
    /// The magnetic field does not fit the reference.
    pub magnetic_disturbance: bool,
    /// Strength of the field in the last average, µT, if there was one.
    pub magnetic_norm_ut: Option<f64>,
}

/// The estimator's state; a copy of it saves and restores the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimator {
    parameters: Parameters,
    noise: ProcessNoise,
    alignment: Alignment,
    state: Option<State>,
    time: SensorTime,
    last: Increment,
    rest: RestDetector,
    resting_s: f64,
    at_rest: bool,
    since_levelling_s: f64,
    compass: Compass,
    heading_origin: HeadingOrigin,
    since_compass_s: f64,
    world_turned: bool,
    magnetic_norm_ut: Option<f64>,
}

/// Readings refused for this long make the heading "held".
const HELD_AFTER_S: f64 = 1.0;

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
            time: SensorTime::from_nanos(0),
            last: Increment::ZERO,
            rest: RestDetector::new(),
            resting_s: 0.0,
            at_rest: false,
            since_levelling_s: 0.0,
            compass: Compass::new(),
            heading_origin: HeadingOrigin::Arbitrary,
            since_compass_s: 0.0,
            world_turned: false,
            magnetic_norm_ut: None,
        }
    }

    /// Advances by one grid step.
    pub fn step(&mut self, step: &Step) -> StepReport {
        self.time = step.time;
        self.last = step.increment;
        let Some(mut state) = self.state else {
            return self.align(step);
        };
        predict(&mut state, &step.increment, &self.noise);
        self.watch_rest(&mut state, &step.increment);
        let levelling = self.level(&mut state, step.increment.span_s);
        let compass = self.steer(&mut state, step);
        state.covariance.restore();
        self.state = Some(state);
        StepReport {
            waiting: None,
            just_aligned: false,
            world_turned: core::mem::take(&mut self.world_turned),
            at_rest: self.at_rest,
            levelling,
            compass,
        }
    }

    /// Accounts for a stretch of time without samples, too long to bridge.
    pub fn cross_gap(&mut self, span: SensorSpan) {
        let gap_s = span.as_secs_f64();
        self.rest = RestDetector::new();
        self.at_rest = false;
        self.resting_s = 0.0;
        self.alignment = Alignment::new();
        let Some(state) = &mut self.state else { return };
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

    /// Pose and motion at the end of the last step, once aligned.
    pub fn estimate(&self) -> Option<Estimate> {
        self.estimate_of(self.state.as_ref()?, &self.last)
    }

    /// Pose and motion a little later: the last step's, carried on over what the grid holds beyond.
    pub fn estimate_ahead(&self, beyond: &Increment) -> Option<Estimate> {
        let state = self.state.as_ref()?;
        if beyond.span_s <= 0.0 {
            return self.estimate();
        }
        let mut ahead = *state;
        let angle = beyond.angle - state.gyro_bias * beyond.span_s;
        let gain = state.orientation * (beyond.velocity - state.accel_bias * beyond.span_s)
            - DVec3::Z * self.parameters.gravity_m_s2 * beyond.span_s;
        ahead.position += (state.velocity + 0.5 * gain) * beyond.span_s;
        ahead.velocity += gain;
        ahead.orientation = so3::renormalise(state.orientation * so3::exp(angle));
        let mut estimate = self.estimate_of(&ahead, beyond)?;
        estimate.time = self.time + SensorSpan::from_secs_f64(beyond.span_s);
        Some(estimate)
    }

    fn estimate_of(&self, state: &State, increment: &Increment) -> Option<Estimate> {
        let per_second = increment.span_s.recip();
        state.is_finite().then(|| Estimate {
            time: self.time,
            orientation: state.orientation(),
            position: state.position,
            velocity: state.velocity,
            angular_rate: increment.angle * per_second - state.gyro_bias,
            specific_force: increment.velocity * per_second - state.accel_bias,
            orientation_covariance: state.covariance.block(ORIENTATION, ORIENTATION),
            position_covariance: state.covariance.block(POSITION, POSITION),
            velocity_covariance: state.covariance.block(VELOCITY, VELOCITY),
            heading_origin: self.heading_origin,
            at_rest: self.at_rest,
            magnetic_disturbance: self.compass.is_disturbed(),
            magnetic_norm_ut: self.magnetic_norm_ut,
        })
    }

    fn align(&mut self, step: &Step) -> StepReport {
        let aligned = self.alignment.push(step, &self.parameters);
        if let Some(aligned) = aligned {
            self.state = Some(aligned.state);
            if let Some(field) = aligned.field {
                self.compass.set_reference(field);
                self.heading_origin = self.origin_when_used();
            }
        }
        StepReport {
            waiting: aligned.is_none().then(|| self.alignment.waiting()),
            just_aligned: aligned.is_some(),
            world_turned: false,
            at_rest: aligned.is_some(),
            levelling: None,
            compass: None,
        }
    }

    const fn origin_when_used(&self) -> HeadingOrigin {
        match self.parameters.heading {
            HeadingMode::InitialOnly => HeadingOrigin::InitialOnly,
            HeadingMode::Continuous | HeadingMode::Adaptive => HeadingOrigin::Magnetometer,
        }
    }

    fn watch_rest(&mut self, state: &mut State, increment: &Increment) {
        let Some(window) = self.rest.push(increment, &self.parameters.rest) else { return };
        let bias_variance = state.covariance.variances(GYRO_BIAS).max_element();
        let bias_sigma = libm::sqrt(bias_variance);
        self.at_rest = window.is_rest(state.gyro_bias, bias_sigma, &self.parameters.rest);
        if self.at_rest {
            self.resting_s += self.parameters.rest.interval_s;
            self.hold_still(state, &window);
        } else {
            self.resting_s = 0.0;
        }
    }

    fn hold_still(&self, state: &mut State, window: &WindowStatistics) {
        let p = &self.parameters;
        let faded = self.resting_s > 2.0 * p.levelling.time_constant_s;
        standstill::zero_velocity(state, p.rest.velocity_sigma_m_s, faded);
        // The window is longer than the interval, so successive means are correlated: the noise is
        // counted as if each block came alone.
        let noise = p.noise.gyro_density / libm::sqrt(p.rest.interval_s);
        standstill::zero_rate(state, window.confirmed_rate, noise.max(2e-4));
    }

    fn level(&mut self, state: &mut State, span_s: f64) -> Option<Outcome> {
        self.since_levelling_s += span_s;
        if self.since_levelling_s < self.parameters.levelling.interval_s {
            return None;
        }
        self.since_levelling_s = 0.0;
        Some(levelling::update(state, &self.parameters.levelling))
    }

    fn steer(&mut self, state: &mut State, step: &Step) -> Option<CompassReport> {
        self.since_compass_s += step.increment.span_s;
        let report = self.compass_update(state, step);
        if report.is_some_and(|r| r.outcome.used) {
            self.since_compass_s = 0.0;
        }
        if self.compass.reference().is_some() {
            self.heading_origin = self.origin_now();
        }
        report
    }

    fn compass_update(&mut self, state: &mut State, step: &Step) -> Option<CompassReport> {
        let p = &self.parameters;
        let rate = step.increment.angle * step.increment.span_s.recip() - state.gyro_bias;
        let in_world = |v: DVec3| state.orientation * v;
        let reading = step.mag.map(|m| (in_world(m.vector), in_world(rate)));
        let turn = libm::sqrt(step.increment.angle.length_squared());
        let speed = libm::sqrt(state.leaky_velocity.length_squared());
        self.compass.note_motion(step.increment.span_s, turn, speed);
        let average =
            self.compass.average(reading, state.mag_delay_s, step.increment.span_s, &p.compass)?;
        if self.compass.reference().is_none() {
            self.find_north(state, &average);
            return None;
        }
        let report = self.compass.update(state, &average, p)?;
        self.magnetic_norm_ut = Some(report.norm_ut);
        Some(report)
    }

    /// The magnetometer speaks for the first time after an alignment without it.
    fn find_north(&mut self, state: &mut State, average: &FieldAverage) {
        let field = average.field;
        let bearing = self.parameters.field_bearing_rad;
        let Some(angle) = self.compass.adopt(field, bearing) else { return };
        let square = |x: f64| x * x;
        let horizontal_ut2 = square(field.x) + square(field.y);
        let noise = square(self.parameters.noise.mag_sigma_ut) / (average.count * horizontal_ut2);
        let tilt = state.covariance.variances(ORIENTATION).truncate().max_element();
        let deviation = square(self.parameters.compass.deviation_sigma_rad);
        let by_tilt = square(field.z) / horizontal_ut2 * tilt;
        state.turn_world(angle, noise + by_tilt + deviation, deviation);
        self.heading_origin = self.origin_when_used();
        self.since_compass_s = 0.0;
        self.world_turned = true;
    }

    /// Where the heading comes from, silence of the magnetometer included.
    fn origin_now(&self) -> HeadingOrigin {
        match self.parameters.heading {
            HeadingMode::InitialOnly => HeadingOrigin::InitialOnly,
            _ if self.since_compass_s > HELD_AFTER_S || self.compass.is_disturbed() => {
                HeadingOrigin::Held
            }
            _ => HeadingOrigin::Magnetometer,
        }
    }
}
