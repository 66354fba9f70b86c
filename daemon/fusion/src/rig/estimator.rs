//! The rig's estimator: its members' steps in, one pose out.

use glam::DVec3;

use super::geometry::{Geometry, MAX_MEMBERS};
use super::gradient::{
    Carrier, GradientAid, GradientParameters, GradientReport, GradientVerdict, Readings,
};
use super::virtual_imu::{Inertial, VirtualImu};
use crate::covariance::VELOCITY;
use crate::estimator::{Estimate, Estimator, StepReport};
use crate::grid::{Increment, Step};
use crate::parameters::{Parameters, SensorNoise};
use crate::quantity::Mag;
use crate::time::{SensorSpan, SensorTime};

/// Parameters of a rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigParameters {
    /// Of the pose's filter; its noise is one member's.
    pub estimator: Parameters,
    /// Of the velocity by gradient; none if it is switched off.
    pub gradient: Option<GradientParameters>,
}

/// What one step did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigReport {
    /// The step's end.
    pub time: SensorTime,
    /// What the pose's filter did.
    pub step: StepReport,
    /// A window of the gradient that ended here.
    pub gradient: Option<GradientReport>,
}

/// The rig's state; a copy of it saves and restores it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigEstimator {
    geometry: Geometry,
    parameters: RigParameters,
    virtual_imu: VirtualImu,
    estimator: Estimator,
    gradient: Option<GradientAid>,
    /// The field is bent by steel.
    bent: bool,
}

/// Error of the gradient from which it is not known, µT/m.
const UNKNOWN_UT_M: f64 = 10.0;
/// Usual distance of steel that bends the field, m: a dipole's field is a third of its gradient there.
const STEEL_M: f64 = 2.0;

impl RigEstimator {
    /// A rig that waits for its alignment.
    pub fn new(geometry: Geometry, parameters: RigParameters) -> Self {
        let estimator = Parameters {
            noise: of_many(parameters.estimator.noise, geometry.count()),
            ..parameters.estimator
        };
        Self {
            geometry,
            parameters,
            virtual_imu: VirtualImu::new(),
            estimator: Estimator::new(estimator),
            gradient: parameters.gradient.map(|p| GradientAid::new(&geometry, p)),
            bent: false,
        }
    }

    /// Advances by one step of the members' common grid; nothing if no member has one.
    pub fn step(&mut self, steps: &[Option<Step>; MAX_MEMBERS]) -> Option<RigReport> {
        let first = steps.iter().flatten().next()?;
        let (time, span_s) = (first.time, first.increment.span_s);
        let mut members = [None; MAX_MEMBERS];
        for (k, step) in steps.iter().enumerate().take(self.geometry.count()) {
            members[k] = step.as_ref().and_then(|s| Inertial::of(s, &self.geometry, k));
        }
        let admitted = members.map(|m| m.is_some());
        let increment = self.virtual_imu.fuse(&members, &admitted, &self.geometry, span_s)?;
        self.virtual_imu.learn(&members, &admitted, &self.geometry, &increment);
        let readings = self.readings(steps);
        let step = self.estimator.step(&Step {
            time,
            increment,
            mag: mean(&readings).filter(|_| !self.is_held()).map(Mag::new),
            bridged: steps.iter().flatten().any(|s| s.bridged),
            saturated: steps.iter().flatten().any(|s| s.saturated),
        });
        let gradient = self.by_gradient(&increment, &readings, step.at_rest);
        self.watch_field(step.just_aligned);
        Some(RigReport { time, step, gradient })
    }

    /// Pose and motion of the filter point, once aligned.
    pub fn estimate(&self) -> Option<Estimate> {
        self.estimator.estimate()
    }

    /// The pose's filter.
    pub const fn estimator(&self) -> &Estimator {
        &self.estimator
    }

    /// Whether the compass is held: the field is bent, and the heading known without it.
    fn is_held(&self) -> bool {
        self.bent && self.estimator.state().is_some()
    }

    /// Follows whether the field is bent by steel, with hysteresis.
    fn watch_field(&mut self, just_aligned: bool) {
        let (Some(aid), Some(p)) = (&self.gradient, &self.parameters.gradient) else { return };
        let Some((size, sigma)) = aid.gradient_now() else { return };
        let limit = p.bent_ut_m.max(2.0 * sigma);
        self.bent = sigma < UNKNOWN_UT_M && size > if self.bent { 0.7 * limit } else { limit };
        if just_aligned && size > limit {
            self.estimator.doubt_heading(size * STEEL_M / 3.0);
        }
    }

    fn readings(&self, steps: &[Option<Step>; MAX_MEMBERS]) -> Readings {
        let mut readings = [None; MAX_MEMBERS];
        for (k, step) in steps.iter().enumerate().take(self.geometry.count()) {
            let field = step.as_ref().and_then(|s| s.mag);
            readings[k] = field.map(|m| self.geometry.mounting(k).rotation.apply(m.vector));
        }
        readings
    }

    fn by_gradient(
        &mut self,
        increment: &Increment,
        readings: &Readings,
        at_rest: bool,
    ) -> Option<GradientReport> {
        let aid = self.gradient.as_mut()?;
        let state = self.estimator.state()?;
        let carrier = Carrier {
            orientation: state.orientation,
            velocity: state.velocity,
            velocity_covariance: state.covariance.block(VELOCITY, VELOCITY),
            gyro_bias: state.gyro_bias,
            accel_bias: state.accel_bias,
            gravity: self.parameters.estimator.gravity_m_s2,
        };
        let mut report = aid.step(increment, readings, &carrier, &self.geometry)?;
        if report.verdict == GradientVerdict::Open {
            if at_rest {
                report.verdict = GradientVerdict::Still;
            } else if !self.estimator.aid_by_gradient(report.velocity_m_s, report.covariance) {
                report.verdict = GradientVerdict::Contradicted;
            }
        }
        Some(report)
    }
}

/// What turning adds to the error of a rig's mean, as a share of what it adds to a hand-held
/// camera's. That figure stands for turns of radians; a rig sways to and fro, where errors of scale and
/// alignment cancel.
const RIG_SCALE_SHARE: f64 = 0.5;

/// Noise of the mean of several sensors: independent parts shrink by the root of their number.
fn of_many(one: SensorNoise, count: usize) -> SensorNoise {
    let share = libm::sqrt(count as f64).recip();
    SensorNoise {
        gyro_density: one.gyro_density * share,
        gyro_bias_walk: one.gyro_bias_walk * share,
        gyro_bias_sigma: one.gyro_bias_sigma * share,
        gyro_scale_walk: one.gyro_scale_walk * share * RIG_SCALE_SHARE,
        accel_density: one.accel_density * share,
        accel_bias_walk: one.accel_bias_walk * share,
        accel_bias_sigma: one.accel_bias_sigma * share,
        mag_sigma_ut: one.mag_sigma_ut * share,
    }
}

fn mean(readings: &Readings) -> Option<DVec3> {
    let (sum, count) = readings
        .iter()
        .flatten()
        .fold((DVec3::ZERO, 0.0), |(sum, count), field| (sum + *field, count + 1.0));
    (count > 0.0).then(|| sum / count)
}

impl Default for RigParameters {
    fn default() -> Self {
        Self { estimator: Parameters::default(), gradient: Some(GradientParameters::default()) }
    }
}
