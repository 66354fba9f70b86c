//! The rig's estimator: its members' steps in, one pose out.

use super::derive::{self, Point};
use super::geometry::{Geometry, MAX_MEMBERS};
use super::gradient::{
    Carrier, GradientAid, GradientParameters, GradientReport, GradientVerdict, Readings,
};
use super::magnetism::{Magnetism, MagnetismParameters};
use super::virtual_imu::{Inertial, VirtualImu};
use super::voting::{Exclusion, Given, Voting, VotingParameters};
use crate::aiding::{Aid, AidReport};
use crate::covariance::{ORIENTATION, VELOCITY};
use crate::estimator::{Estimate, Estimator, StepReport};
use crate::grid::{Increment, Step};
use crate::parameters::{Parameters, SensorNoise};
use crate::quantity::Mag;
use crate::state::State;
use crate::time::{SensorSpan, SensorTime};
use crate::update::gradient::Held;

/// Parameters of a rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigParameters {
    /// Of the pose's filter; its noise is one member's.
    pub estimator: Parameters,
    /// Of the vote between members.
    pub voting: VotingParameters,
    /// Of the comparison between magnetometers.
    pub magnetism: MagnetismParameters,
    /// Of the velocity by gradient; none if it is switched off.
    pub gradient: Option<GradientParameters>,
}

/// How a member stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MemberStatus {
    /// Why its inertial sensors do not count; nothing if they do.
    pub exclusion: Option<Exclusion>,
    /// Its magnetometer is disturbed and the others' are not.
    pub magnetometer_alone: bool,
}

/// What one step did.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::struct_excessive_bools, reason = "each is a fact of its own about a step")]
pub struct RigReport {
    /// The step's end.
    pub time: SensorTime,
    /// What the pose's filter did.
    pub step: StepReport,
    /// Every member's standing.
    pub members: [MemberStatus; MAX_MEMBERS],
    /// Two members disagree, and neither is known to be wrong.
    pub torn: bool,
    /// The field is bent by steel that the whole rig sees: the compass is held.
    pub field_bent: bool,
    /// A window of the gradient that ended here.
    pub gradient: Option<GradientReport>,
    /// The step rests on interpolation over lost samples.
    pub bridged: bool,
    /// A sensor that counts was at the end of its range.
    pub saturated: bool,
}

/// The rig's state; a copy of it saves and restores it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigEstimator {
    geometry: Geometry,
    parameters: RigParameters,
    virtual_imu: VirtualImu,
    voting: Voting,
    magnetism: Magnetism,
    estimator: Estimator,
    gradient: Option<GradientAid>,
    /// The field is bent by steel.
    bent: bool,
    /// The rig stands where it was aligned, and its heading has not been doubted yet.
    at_start: bool,
    /// Each member's raw increment in the step before.
    last: [Increment; MAX_MEMBERS],
}

/// Heading up to whose error a bent field has nothing to add, 1σ, rad.
const KNOWN_HEADING_RAD: f64 = 0.04;
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
            voting: Voting::new(geometry.count(), parameters.voting),
            magnetism: Magnetism::new(parameters.magnetism),
            estimator: Estimator::new(estimator),
            gradient: parameters.gradient.map(|p| GradientAid::new(&geometry, p)),
            bent: false,
            at_start: false,
            last: [Increment::ZERO; MAX_MEMBERS],
        }
    }

    /// Advances by one step of the members' common grid; nothing if no member has one that can be used.
    pub fn step(&mut self, steps: &[Option<Step>; MAX_MEMBERS]) -> Option<RigReport> {
        let first = steps.iter().flatten().next()?;
        let (time, span_s) = (first.time, first.increment.span_s);
        let (increment, admitted) = self.vote(steps, span_s)?;
        let readings = self.readings(steps);
        let angle = increment.angle;
        let odd = self.gradient.as_ref().map_or([false; MAX_MEMBERS], GradientAid::odd);
        let field = self.magnetism.step(&readings, odd, (angle, span_s), &self.geometry);
        let counting = || steps.iter().zip(admitted).filter(|(_, a)| *a).filter_map(|(s, _)| *s);
        let (bridged, saturated) = (counting().any(|s| s.bridged), counting().any(|s| s.saturated));
        let mag = field.filter(|_| !self.is_held()).map(Mag::new);
        let step = self.estimator.step(&Step { time, increment, mag, bridged, saturated });
        let gradient = self.by_gradient(&increment, &readings, step.at_rest);
        self.watch_field(&step);
        let (torn, field_bent) = (self.voting.torn, self.bent);
        let members = core::array::from_fn(|k| self.status(k));
        Some(RigReport { time, step, members, torn, field_bent, gradient, bridged, saturated })
    }

    /// Accounts for a stretch of time without any step, too long to bridge.
    pub fn cross_gap(&mut self, span: SensorSpan) {
        self.estimator.cross_gap(span);
        if let Some(aid) = &mut self.gradient {
            aid.cross_gap();
        }
    }

    /// How a member stands.
    pub const fn status(&self, member: usize) -> MemberStatus {
        MemberStatus {
            exclusion: self.voting.exclusion(member),
            magnetometer_alone: self.magnetism.is_alone(member),
        }
    }

    /// The virtual IMU's increment, and who counted in it.
    fn vote(
        &mut self,
        steps: &[Option<Step>; MAX_MEMBERS],
        span_s: f64,
    ) -> Option<(Increment, [bool; MAX_MEMBERS])> {
        let mut members = [None; MAX_MEMBERS];
        for (k, step) in steps.iter().enumerate().take(self.geometry.count()) {
            members[k] = step.as_ref().and_then(|s| Inertial::of(s, &self.geometry, k));
        }
        self.note_repeats(steps);
        let centred = self.virtual_imu.centred(&members, &self.geometry);
        let given = core::array::from_fn(|k| Given {
            centred: centred[k],
            present: steps[k].is_some(),
            saturated: steps[k].is_some_and(|s| s.saturated),
            known: self.virtual_imu.knows(k),
            arm_m: libm::sqrt(self.geometry.imu_arm_m(k).length_squared()),
        });
        let mut admitted = self.voting.hold(&given, self.virtual_imu.swing_rad_s2(), span_s);
        if !admitted.contains(&true) {
            self.voting.pardon();
            admitted = centred.map(|c| c.is_some());
        }
        let increment = self.virtual_imu.fuse(&members, admitted, &self.geometry, span_s)?;
        self.virtual_imu.learn(&members, admitted, &self.geometry, &increment);
        Some((increment, admitted))
    }

    /// A sensor that works never gives the very same twice; rounding on the grid aside.
    fn note_repeats(&mut self, steps: &[Option<Step>; MAX_MEMBERS]) {
        const ROUNDING: f64 = 1e-12;
        let repeats = core::array::from_fn(|k| {
            steps[k].is_some_and(|step| {
                let (now, last) = (step.increment, self.last[k]);
                self.last[k] = now;
                let change = (now.angle - last.angle).abs() + (now.velocity - last.velocity).abs();
                change.max_element() < ROUNDING
            })
        });
        self.voting.note_repeats(repeats);
    }

    /// Pose and motion of the filter point, once aligned.
    pub fn estimate(&self) -> Option<Estimate> {
        self.estimator.estimate()
    }

    /// Pose and motion of a point of the rig, once aligned.
    pub fn estimate_at(&self, point: &Point) -> Option<Estimate> {
        let (estimate, state) = (self.estimator.estimate()?, self.estimator.state()?);
        Some(derive::at(point, &estimate, &state.covariance, self.virtual_imu.acceleration()))
    }

    /// Takes a measurement by others, valid up to two seconds ago; levers count from the filter point.
    pub fn aid(&mut self, aid: &Aid) -> AidReport {
        self.estimator.aid(aid)
    }

    /// The pose's filter, for who says where in the world the filter point is.
    pub const fn estimator_mut(&mut self) -> &mut Estimator {
        &mut self.estimator
    }

    /// Where the members sit.
    pub const fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// The pose's filter.
    pub const fn estimator(&self) -> &Estimator {
        &self.estimator
    }

    /// Whether the compass is held: the field is bent, and the heading known without it.
    fn is_held(&self) -> bool {
        let heading = |state: &State| state.covariance.variance(ORIENTATION.0 + 2);
        let known = |state| heading(state) < KNOWN_HEADING_RAD * KNOWN_HEADING_RAD;
        self.bent && self.estimator.state().is_some_and(known)
    }

    /// Follows whether the field is bent by steel, with hysteresis. For as long as the rig has not left,
    /// it is the field that gave the heading, and a bend may take some seconds to be seen.
    fn watch_field(&mut self, report: &StepReport) {
        let (Some(aid), Some(p)) = (&self.gradient, &self.parameters.gradient) else { return };
        self.at_start |= report.just_aligned;
        let Some((size, sigma)) = aid.gradient_now() else { return };
        let limit = p.bent_ut_m.max(2.0 * sigma);
        self.bent = size > if self.bent { 0.7 * limit } else { limit };
        let bend_ut = |size: f64| size * STEEL_M / 3.0;
        self.estimator.note_bend(if self.bent { bend_ut(size) } else { 0.0 });
        if self.at_start && (self.bent || !report.at_rest) {
            self.at_start = false;
            let beyond_its_error = libm::sqrt((size * size - sigma * sigma).max(0.0));
            self.estimator.doubt_heading(bend_ut(beyond_its_error));
        }
    }

    /// Magnetometers of the members whose inertial sensors are in order.
    fn readings(&self, steps: &[Option<Step>; MAX_MEMBERS]) -> Readings {
        let mut readings = [None; MAX_MEMBERS];
        for (k, step) in steps.iter().enumerate().take(self.geometry.count()) {
            let field = step.as_ref().and_then(|s| s.mag).filter(|m| m.vector.is_finite());
            let field = field.filter(|_| self.voting.exclusion(k).is_none());
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
        let together = core::array::from_fn(|k| readings[k].filter(|_| !self.magnetism.is_far(k)));
        let mut report = aid.step(increment, &together, &carrier, &self.geometry)?;
        if report.verdict == GradientVerdict::Open {
            if at_rest {
                report.verdict = GradientVerdict::Still;
            } else {
                let (velocity, covariance) = (report.velocity_m_s, report.covariance);
                report.verdict = match self.estimator.aid_by_gradient(velocity, covariance) {
                    Held::Contradicted => GradientVerdict::Contradicted,
                    Held::Partly => GradientVerdict::Partial,
                    Held::Wholly => GradientVerdict::Open,
                };
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
        ..one
    }
}

impl Default for RigParameters {
    fn default() -> Self {
        Self {
            estimator: Parameters::default(),
            voting: VotingParameters::default(),
            magnetism: MagnetismParameters::default(),
            gradient: Some(GradientParameters::default()),
        }
    }
}
