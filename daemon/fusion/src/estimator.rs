//! The estimator: alignment first, then prediction with its updates, one grid step at a time.

use glam::{DMat3, DVec3};

use crate::aid_status::AidKind;
use crate::aiding::{Aid, AidRefusal, AidReport, Aiding, Anchor, Setting};
use crate::aids::Aids;
use crate::alignment::{Alignment, Waiting};
use crate::covariance::{DEVIATION, MOUNTING, ORIENTATION, POSITION, SPEED_SCALE, VELOCITY};
use crate::drift::Drift;
use crate::grid::{Increment, Step};
use crate::history::Surroundings;
use crate::parameters::Parameters;
use crate::predict::{Pending, ProcessNoise, Strapdown, follow};
use crate::state::State;
use crate::time::{SensorSpan, SensorTime};
use crate::update::compass::CompassReport;
use crate::update::gradient::Held;
use crate::update::{Outcome, anchored, gradient};

mod estimate;
pub(crate) mod place;

pub use estimate::Estimate;

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
    /// There never was a magnetometer reading: a pose by others gave it.
    PoseFix,
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
    /// The zero-velocity update, if the camera stands and one was due: its worst axis.
    pub standstill: Option<Outcome>,
    /// The levelling update, if one was due.
    pub levelling: Option<Outcome>,
    /// The heading update, if one was due.
    pub compass: Option<CompassReport>,
    /// The vehicle's constraint, if it was due.
    pub constraint: Option<AidReport>,
}

impl StepReport {
    /// Nothing happened.
    pub(crate) const QUIET: Self = Self {
        waiting: None,
        just_aligned: false,
        world_turned: false,
        at_rest: false,
        standstill: None,
        levelling: None,
        compass: None,
        constraint: None,
    };
}

/// The estimator's state; a copy of it saves and restores the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimator {
    parameters: Parameters,
    noise: ProcessNoise,
    alignment: Alignment,
    state: Option<State>,
    strapdown: Strapdown,
    pending: Pending,
    /// Every entry of the covariance is finite.
    covariance_is_sound: bool,
    aids: Aids,
    aiding: Aiding,
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
            strapdown: Strapdown::NEW,
            pending: Pending::NONE,
            covariance_is_sound: true,
            aids: Aids::new(&parameters),
            aiding: Aiding::NEW,
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
        let surroundings = (&self.noise, self.aids.ground(&self.parameters));
        let turn_rad =
            self.strapdown.advance(state, &mut self.pending, &step.increment, surroundings);
        let settings = (&self.parameters, &self.noise);
        let mut report = self.aids.step(state, &mut self.pending, (step, turn_rad), settings);
        if report.world_turned {
            state.cut(step.time);
        }
        if self.pending == Pending::NONE {
            self.covariance_is_sound = state.covariance.is_finite();
        }
        if self.aiding.note_motion(&step.increment, self.parameters.vehicle.as_ref()) {
            report.constraint = self.constrain();
        }
        report
    }

    /// Takes a measurement by others, valid up to two seconds ago and not after the last step.
    pub fn aid(&mut self, aid: &Aid) -> AidReport {
        let setting = self.setting();
        let Some(state) = &mut self.state else {
            let refusal = Some(AidRefusal::NotAligned);
            return AidReport { refusal, ..AidReport::of(aid.measurement.kind()) };
        };
        follow(state, &mut self.pending, &self.noise);
        let report = self.aiding.take(state, aid, &mut self.aids.ledger, &setting);
        if report.heading_found && setting.heading_is_arbitrary {
            self.aids.heading_origin = HeadingOrigin::PoseFix;
        }
        self.settle();
        report
    }

    /// The camera that this one is held to since it was measured against it; `None` once that is long ago.
    pub fn held_to(&self) -> Option<u16> {
        let tie = self.state.as_ref()?.tie.as_ref()?;
        tie.holds().then_some(tie.anchor)
    }

    /// Goes along with what the anchor, as it is now, has corrected of itself: between two measurements
    /// against it both stay as they are to each other. Nothing happens for one that this is not held to.
    pub fn follow(&mut self, anchor: &Anchor) {
        if self.held_to() != Some(anchor.id) {
            return;
        }
        let Some(state) = &mut self.state else { return };
        follow(state, &mut self.pending, &self.noise);
        anchored::follow(state, anchor);
        self.settle();
    }

    /// Counts the position from another origin: gives the camera's present position there, m, with a
    /// covariance, m², that has nothing to do with what was known before.
    ///
    /// Nothing happens before there is a state. A position of which nothing is known is one with a
    /// large covariance; ten kilometres squared is well within what f64 bears.
    pub fn place(&mut self, position_m: DVec3, covariance: DMat3) {
        let Some(state) = &mut self.state else { return };
        follow(state, &mut self.pending, &self.noise);
        state.position = position_m;
        state.covariance.set_independent(POSITION, covariance);
        state.cut(self.time);
        self.settle();
    }

    /// The covariance was corrected between two steps.
    fn settle(&mut self) {
        let Some(state) = &mut self.state else { return };
        state.covariance.restore();
        self.covariance_is_sound = state.covariance.is_finite();
    }

    /// What measurements by others are taken with.
    fn setting(&self) -> Setting {
        let gravity = DVec3::Z * -self.parameters.gravity_m_s2;
        let earth_rate = self.aids.earth_rate(&self.parameters);
        Setting {
            now: self.time,
            parameters: self.parameters,
            around: Surroundings { gravity, earth_rate },
            stands: self.aids.standstill.holds(),
            heading_is_arbitrary: self.aids.heading_origin == HeadingOrigin::Arbitrary,
        }
    }

    fn constrain(&mut self) -> Option<AidReport> {
        let setting = self.setting();
        let state = self.state.as_mut()?;
        follow(state, &mut self.pending, &self.noise);
        let report = self.aiding.constrain(state, &mut self.aids.ledger, &setting);
        self.settle();
        report
    }

    /// Takes a velocity in the world, m/s, that a rig's magnetometers tell, with its covariance. It
    /// counts as an aid of the position once it holds the velocity in all directions.
    pub(crate) fn aid_by_gradient(&mut self, velocity: DVec3, covariance: DMat3) -> Held {
        let Some(state) = &mut self.state else { return Held::Contradicted };
        follow(state, &mut self.pending, &self.noise);
        let used = gradient::update(state, velocity, covariance);
        if used != Held::Partly {
            self.aids.ledger.note(AidKind::Gradient, used == Held::Wholly);
        }
        self.settle();
        used
    }

    /// What steel nearby does to the field, 1σ, µT; 0 where there is none.
    pub(crate) const fn note_bend(&mut self, bend_ut: f64) {
        self.aids.compass.note_bend(bend_ut);
    }

    /// The field that gave the heading may be off by so much, 1σ, µT: heading and deviation are that
    /// much less known, and err by the same.
    pub(crate) fn doubt_heading(&mut self, field_ut: f64) {
        let Some(horizontal_ut) = self.aids.compass.reference().map(|r| r.horizontal_ut()) else {
            return;
        };
        let Some(state) = &mut self.state else { return };
        let angle = (field_ut / horizontal_ut.max(1.0)).min(core::f64::consts::FRAC_PI_2);
        let (heading, variance) = (ORIENTATION.0 + 2, angle * angle);
        let between = state.covariance.block(ORIENTATION, ORIENTATION).z_axis.z;
        state.covariance.set(heading, heading, between + variance);
        state.covariance.add_variance(DEVIATION, variance);
        let between = state.covariance.covariance(heading, DEVIATION) - variance;
        state.covariance.set(heading, DEVIATION, between);
        self.settle();
    }

    /// Accounts for a stretch of time without samples, too long to bridge.
    pub fn cross_gap(&mut self, span: SensorSpan) {
        let gap_s = span.as_secs_f64();
        self.aids.cross_gap();
        self.strapdown = Strapdown::NEW;
        self.aiding = Aiding::NEW;
        self.alignment = Alignment::new();
        let Some(state) = &mut self.state else { return };
        follow(state, &mut self.pending, &self.noise);
        let turn = (GAP_RATE_RAD_S * gap_s).min(GAP_TURN_LIMIT_RAD);
        let speed = (GAP_ACCELERATION_M_S2 * gap_s).min(GAP_SPEED_LIMIT_M_S);
        let way = (libm::sqrt(state.velocity.length_squared()) + 0.5 * speed) * gap_s;
        state.covariance.add_variances(ORIENTATION, DVec3::splat(turn * turn));
        state.covariance.add_variances(VELOCITY, DVec3::splat(speed * speed));
        state.covariance.add_variances(POSITION, DVec3::splat(way * way));
        state.cut(self.time);
        self.settle();
    }

    /// From here on standstills correct nothing, as with [`crate::RestParameters::enabled`] false from the beginning:
    /// to see what the filter does by itself with what it knows now.
    pub const fn ignore_standstills(&mut self) {
        self.parameters.rest.enabled = false;
    }

    /// An estimator that goes back in time from here, once aligned: what its steps bring is the past,
    /// the latest first, with angles negated and time stamps that run on (`−t`). Velocity, rates and time of
    /// its estimates are negated in turn. It begins with what is known now, and finds standstills as any
    /// other; a magnetometer must not be shown to it.
    pub fn reversed(&self) -> Option<Self> {
        let p = &self.parameters;
        let parameters = Parameters {
            earth_rate_rad_s: -p.earth_rate_rad_s,
            lead_s: -p.lead_s,
            gyro_lag_s: 0.0,
            vehicle: None,
            ..*p
        };
        let mut reversed = Self::new(parameters);
        reversed.state = Some(self.state.as_ref()?.reversed());
        reversed.settle();
        reversed.aids.heading_origin = self.aids.heading_origin;
        Some(reversed)
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

    fn begin_aiding(&mut self) {
        self.aiding = Aiding::NEW;
        let (Some(state), Some(vehicle)) = (&mut self.state, &self.parameters.vehicle) else {
            return;
        };
        let square = |x: f64| x * x;
        state.covariance.forget(MOUNTING, square(vehicle.mounting_sigma_rad));
        state.covariance.forget(MOUNTING + 1, square(vehicle.mounting_sigma_rad));
        state.covariance.forget(SPEED_SCALE, square(vehicle.speed_scale_sigma));
    }

    fn align(&mut self, step: &Step) -> StepReport {
        let Some(aligned) = self.alignment.push(step, &self.parameters) else {
            return StepReport { waiting: Some(self.alignment.waiting()), ..StepReport::QUIET };
        };
        let mag_delay_s = self.parameters.compass.delay_s;
        self.state = Some(State { mag_delay_s, drift: Drift::new(self.time), ..aligned.state });
        self.begin_aiding();
        self.settle();
        self.aids.begin(&aligned);
        if let Some(field) = aligned.field {
            self.aids.begin_with(field, aligned.field_span_s, self.parameters.heading);
        }
        StepReport { just_aligned: true, at_rest: aligned.at_rest, ..StepReport::QUIET }
    }
}
