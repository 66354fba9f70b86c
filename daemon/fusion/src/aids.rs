//! What keeps the inertial state from drifting, and when each of it is due.

use crate::aid_status::{AidKind, AidLedger};
use crate::alignment::Aligned;
use crate::covariance::ORIENTATION;
use crate::estimator::{HeadingOrigin, StepReport};
use crate::grid::Step;
use crate::hard_iron::HardIron;
use crate::parameters::{HeadingMode, Parameters};
use crate::predict::{FOLLOW_S, Ground, Pending, ProcessNoise, follow};
use crate::state::State;
use crate::update::compass::{Compass, CompassReport, FieldAverage};
use crate::update::levelling::Levelling;
use crate::update::standstill::{Around, Standstill, Windows};
use glam::DVec3;

/// Readings refused for this long make the heading "held".
const HELD_AFTER_S: f64 = 1.0;

/// Standstill, levelling and compass, with the clocks that say when each is due.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Aids {
    pub(crate) standstill: Standstill,
    since_levelling_s: f64,
    levelling: Levelling,
    pub(crate) compass: Compass,
    hard_iron: HardIron,
    pub(crate) heading_origin: HeadingOrigin,
    since_compass_s: f64,
    pub(crate) ledger: AidLedger,
}

/// What is due after a step.
struct Due {
    windows: Windows,
    levelling: bool,
    field: Option<FieldAverage>,
}

impl Aids {
    pub(crate) fn new(p: &Parameters) -> Self {
        Self {
            standstill: Standstill::UNKNOWN,
            since_levelling_s: 0.0,
            levelling: Levelling::new(),
            compass: Compass::new(),
            hard_iron: HardIron::new(&p.hard_iron),
            heading_origin: HeadingOrigin::Arbitrary,
            since_compass_s: 0.0,
            ledger: AidLedger::EMPTY,
        }
    }

    /// The alignment is done.
    pub(crate) fn begin(&mut self, aligned: &Aligned) {
        self.standstill = Standstill::begin(aligned);
        if aligned.at_rest {
            self.ledger.note(AidKind::Standstill, true);
        }
    }

    /// The camera may have turned and moved unseen: standstill must be found anew, and the field in
    /// the world that goes with the hard iron.
    pub(crate) fn cross_gap(&mut self) {
        self.hard_iron.forget_field();
        self.standstill = Standstill::UNKNOWN;
        self.ledger = AidLedger::EMPTY;
    }

    /// The earth's rate in the world, rad/s, as far as it is known there: without a north only how it
    /// turns about up.
    pub(crate) fn earth_rate(&self, p: &Parameters) -> DVec3 {
        p.earth_rate_where(self.heading_origin != HeadingOrigin::Arbitrary)
    }

    /// What is known of the ground that the camera moves above.
    pub(crate) fn ground(&self, p: &Parameters) -> Ground {
        Ground { earth_rate: self.earth_rate(p), stands: self.standstill.holds() }
    }

    /// The alignment used a field, in the world.
    pub(crate) fn begin_with(&mut self, field: DVec3, averaged_s: f64, mode: HeadingMode) {
        self.compass.expect(field, averaged_s);
        self.heading_origin = origin_when_used(mode);
    }

    /// Watches a step that the nominal state has made, turning by an angle, rad, and corrects the
    /// state with what has become due. The covariance follows when that or its own lag demands it.
    pub(crate) fn step(
        &mut self,
        state: &mut State,
        pending: &mut Pending,
        (step, turn_rad): (&Step, f64),
        (p, noise): (&Parameters, &ProcessNoise),
    ) -> StepReport {
        let due = self.watch(state, step, turn_rad, p);
        let mut report = StepReport { at_rest: self.standstill.stands(), ..StepReport::QUIET };
        if due.windows.is_empty() && !due.levelling && due.field.is_none() {
            if pending.span_s >= FOLLOW_S {
                follow(state, pending, noise);
            }
            return report;
        }
        follow(state, pending, noise);
        let around = Around {
            earth_rate: self.earth_rate(p),
            velocity_is_measured: self.ledger.status().holds_velocity(),
        };
        report.standstill = self.standstill.update(state, &due.windows, around, p);
        self.note_standstill();
        report.levelling = due.levelling.then(|| self.levelling.update(state, &p.levelling));
        if let Some(field) = &due.field {
            report.world_turned =
                self.compass.reference().is_none() && self.find_north(state, field, p);
            if !report.world_turned {
                report.compass = self.steer(state, field, p);
            }
        }
        state.covariance.restore();
        report.at_rest = self.standstill.stands();
        report
    }

    fn note_standstill(&mut self) {
        if self.standstill.stands() {
            self.ledger.note(AidKind::Standstill, true);
        } else {
            self.ledger.end(AidKind::Standstill);
        }
    }

    /// Collects what the step brings.
    fn watch(&mut self, state: &State, step: &Step, turn_rad: f64, p: &Parameters) -> Due {
        let span_s = step.increment.span_s;
        self.ledger.pass(span_s);
        self.since_levelling_s += span_s;
        let mut levelling = self.since_levelling_s >= p.levelling.interval_s;
        if levelling {
            self.since_levelling_s = 0.0;
            // Where the velocity is measured, it levels, and knows what accelerations there are.
            levelling = !self.ledger.status().holds_velocity();
        }
        self.since_compass_s += span_s;
        let speed = libm::sqrt(state.leaky_velocity.length_squared());
        self.compass.note_motion(span_s, turn_rad, speed);
        self.hard_iron.note_motion(turn_rad, speed * span_s, &p.hard_iron);
        let reading = step.mag.map(|mag| {
            let rate = step.increment.angle * span_s.recip() - state.gyro_bias;
            if self.compass.reference().is_some() {
                let rate_rad_s = turn_rad / span_s;
                self.hard_iron.take(mag.vector, state.orientation, rate_rad_s, &p.hard_iron);
            }
            let field = mag.vector - self.hard_iron.correction();
            (state.orientation * field, state.orientation * rate)
        });
        let field = self.compass.average(reading, state.mag_delay_s, span_s, &p.compass);
        if self.compass.reference().is_some() {
            self.heading_origin = self.origin_now(p.heading);
        }
        Due { windows: self.standstill.watch(&step.increment, p), levelling, field }
    }

    fn steer(
        &mut self,
        state: &mut State,
        field: &FieldAverage,
        p: &Parameters,
    ) -> Option<CompassReport> {
        let report = self.compass.update(state, field, p)?;
        if report.outcome.used {
            self.since_compass_s = 0.0;
        }
        self.heading_origin = self.origin_now(p.heading);
        Some(report)
    }

    /// The magnetometer speaks for the first time after an alignment without it: whether north was
    /// found, and the world turned for it.
    fn find_north(&mut self, state: &mut State, average: &FieldAverage, p: &Parameters) -> bool {
        let field = average.field;
        let Some(angle) = self.compass.adopt(field, p.field_bearing_rad) else { return false };
        let square = |x: f64| x * x;
        let horizontal_ut2 = square(field.x) + square(field.y);
        let noise = square(p.noise.mag_sigma_ut) / (average.count * horizontal_ut2);
        let tilt = state.covariance.variances(ORIENTATION).truncate().max_element();
        let deviation = square(p.compass.deviation_sigma_rad);
        let by_tilt = square(field.z) / horizontal_ut2 * tilt;
        state.turn_world(angle, noise + by_tilt + deviation, deviation);
        // The world has turned, and the field in it.
        self.hard_iron = HardIron::new(&p.hard_iron);
        self.heading_origin = origin_when_used(p.heading);
        self.since_compass_s = 0.0;
        true
    }

    /// Where the heading comes from, silence of the magnetometer included.
    fn origin_now(&self, mode: HeadingMode) -> HeadingOrigin {
        match mode {
            HeadingMode::InitialOnly => HeadingOrigin::InitialOnly,
            _ if self.since_compass_s > HELD_AFTER_S || self.compass.is_disturbed() => {
                HeadingOrigin::Held
            }
            _ => HeadingOrigin::Magnetometer,
        }
    }
}

const fn origin_when_used(mode: HeadingMode) -> HeadingOrigin {
    match mode {
        HeadingMode::InitialOnly => HeadingOrigin::InitialOnly,
        HeadingMode::Continuous | HeadingMode::Adaptive => HeadingOrigin::Magnetometer,
    }
}
