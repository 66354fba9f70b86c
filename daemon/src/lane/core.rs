//! The part of a lane that depends on its readings alone: same readings in, same bits out.

use lodestone_fusion::{
    Accepted, Aid, AidRefusal, Anchor, Estimate, Estimator, FieldReference, Grid, ImuSample,
    Parameters, Refusal, SensorSpan, SensorTime, Waiting,
};

use lodestone_schema::{DistanceSource, Status};

use super::aiding::AidQueue;
use super::trail::Trail;
use super::{Conditioner, LaneSettings, SetBack};
use crate::reading::{HostTime, Reading};
use crate::world::{Membership, WorldStep};

/// How far the filter is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Phase {
    /// No pose yet, for this reason.
    Aligning(Waiting),
    /// Poses come.
    Running,
}

/// What one step of the grid brought.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::struct_excessive_bools, reason = "each is a fact of its own about a step")]
pub struct StepOutput {
    /// The step's end.
    pub time: SensorTime,
    /// The pose, once aligned.
    pub estimate: Option<Estimate>,
    /// How far the filter is.
    pub phase: Phase,
    /// The step rests on interpolation over lost samples.
    pub bridged: bool,
    /// A sensor was at the end of its range.
    pub saturated: bool,
    /// A long gap was crossed and the filter has not recovered from it.
    pub degraded: bool,
    /// The magnetic field is not the earth's at the configured place.
    pub field_unlike_earth: bool,
    /// A fix that was refused for long was believed after all: the position jumped.
    pub position_jumped: bool,
    /// The world that the pose is in.
    pub world: WorldStep,
    /// What the rig says beside it, if the pose is one's: on a body, a member out, disturbed alone.
    pub rig: Status,
}

/// What became of a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taken {
    /// The reading in the body frame, calibrated.
    pub sample: ImuSample,
    /// Why it was not used.
    pub refusal: Option<Refusal>,
}

/// What the core counted since it was made. Nothing decreases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CoreCounts {
    /// Readings taken or refused.
    pub readings: u64,
    /// Samples missing by their time stamps.
    pub lost: u64,
    /// Steps that rest on interpolation over lost samples.
    pub bridged: u64,
    /// Readings whose time stamp repeats.
    pub duplicates: u64,
    /// Readings whose time stamp runs backwards.
    pub out_of_order: u64,
    /// Readings with values that are not finite or not believable.
    pub invalid: u64,
    /// Times the filter began anew, or found north late: poses before and after do not compare.
    pub resets: u32,
    /// Measurements by others that corrected the filter.
    pub aiding_used: u64,
    /// Measurements by others that did not fit, or came too late.
    pub aiding_refused: u64,
    /// Measurements by others that make no sense, are of the future, or cannot be used here.
    pub aiding_invalid: u64,
}

impl CoreCounts {
    /// Counts a reading that was not used.
    pub const fn note_refusal(&mut self, refusal: Refusal) {
        match refusal {
            Refusal::Duplicate => self.duplicates += 1,
            Refusal::OutOfOrder => self.out_of_order += 1,
            Refusal::NotFinite | Refusal::OutOfRange => self.invalid += 1,
        }
    }
}

/// Standard deviations up to which a filter that crossed a gap counts as recovered.
const RECOVERED_TILT_RAD: f64 = 0.05;
const RECOVERED_HEADING_RAD: f64 = 0.2;

/// Between two looks at the camera that this one was measured against.
const FOLLOW_INTERVAL: SensorSpan = SensorSpan::from_nanos(100_000_000);

/// How far strength or vertical part of the field may be from the World Magnetic Model's, as a part of
/// its strength. Rooms differ by a tenth or two; an uncalibrated car by half and more.
const EARTH_TOLERANCE: f64 = 0.25;

/// One camera's lane without its surroundings.
#[derive(Clone, Debug)]
pub struct Core {
    conditioner: Conditioner,
    grid: Grid,
    estimator: Estimator,
    membership: Membership,
    parameters: Parameters,
    reset_after: SensorSpan,
    earth: Option<FieldReference>,
    epoch: Option<u32>,
    set_back: SetBack,
    aids: AidQueue,
    /// When this camera last looked at its anchor.
    followed: Option<SensorTime>,
    trail: Trail,
    position_jumped: bool,
    degraded: bool,
    phase: Phase,
    counts: CoreCounts,
}

impl Core {
    /// A core that waits for its first reading, in a world of its own.
    pub fn new(settings: &LaneSettings) -> Self {
        Self::in_world(settings, Membership::alone(settings.member))
    }

    /// A core that waits for its first reading, in a world that it shares.
    pub fn in_world(settings: &LaneSettings, membership: Membership) -> Self {
        Self {
            membership,
            conditioner: settings.conditioner.clone(),
            grid: Grid::new(settings.grid).with_low_pass(settings.low_pass),
            estimator: Estimator::new(settings.estimator),
            parameters: settings.estimator,
            reset_after: settings.timing.reset_after,
            earth: settings.earth,
            epoch: None,
            set_back: SetBack::new(settings.timing.reset_after),
            aids: AidQueue::new(settings.antenna_m),
            followed: None,
            trail: Trail::NONE,
            position_jumped: false,
            degraded: false,
            phase: Phase::Aligning(Waiting::Collecting),
            counts: CoreCounts::default(),
        }
    }

    /// Takes one reading and hands each grid step that it completes to `on_step`, in order.
    pub fn take(&mut self, reading: &Reading, mut on_step: impl FnMut(&StepOutput)) -> Taken {
        self.counts.readings += 1;
        self.follow_epoch(reading.epoch);
        let sample = self.conditioner.condition(reading);
        match self.push(sample) {
            Ok(accepted) => self.account(accepted),
            Err(refusal) => {
                self.counts.note_refusal(refusal);
                return Taken { sample, refusal: Some(refusal) };
            }
        }
        for aid in self.aids.recorded(reading).into_iter().flatten() {
            self.aid(aid);
        }
        while let Some(step) = self.grid.next_step() {
            self.counts.bridged += u64::from(step.bridged);
            let report = self.estimator.step(&step);
            let arrival = reading.arrival;
            let began_anew =
                self.membership.follow(&mut self.estimator, report.just_aligned, arrival);
            self.counts.resets += u32::from(report.world_turned || began_anew);
            self.phase = report.waiting.map_or(Phase::Running, Phase::Aligning);
            self.offer_due(step.time);
            self.follow_anchor(step.time, arrival);
            let estimate = self.estimator.estimate();
            if report.waiting.is_none() && estimate.is_none() {
                // A state that is not finite has no way back.
                self.reset();
            }
            let world = self.membership.note(estimate.as_ref(), arrival);
            self.degraded = self.degraded && !estimate.as_ref().is_some_and(recovered);
            on_step(&StepOutput {
                time: step.time,
                estimate,
                phase: self.phase,
                bridged: step.bridged,
                saturated: step.saturated,
                degraded: self.degraded,
                field_unlike_earth: is_unlike_earth(self.earth, estimate.as_ref()),
                position_jumped: std::mem::take(&mut self.position_jumped),
                world,
                rig: Status::empty(),
            });
        }
        Taken { sample, refusal: None }
    }

    /// Takes a measurement by others, on the sensor's clock; it waits until the grid has come there.
    pub fn aid(&mut self, aid: Aid) {
        let newest = self.grid.last_sample().map_or(aid.time, |sample| sample.time);
        if self.aids.push(aid, newest).is_err() {
            self.counts.aiding_invalid += 1;
        }
    }

    /// What a position or pose among the measurements by others was made with.
    pub const fn hear_fix(&mut self, source: DistanceSource) {
        self.membership.hear_fix(source);
    }

    /// A measurement by others could not even be read.
    pub const fn count_invalid_aid(&mut self) {
        self.counts.aiding_invalid += 1;
    }

    /// A measurement against another camera that cannot be its anchor now.
    pub const fn count_refused_aid(&mut self) {
        self.counts.aiding_refused += 1;
    }

    /// Hands the estimator what is valid up to the end of its last step.
    fn offer_due(&mut self, now: SensorTime) {
        while let Some(aid) = self.aids.next_due(now) {
            let report = self.estimator.aid(&aid);
            self.position_jumped |= report.position_jumped;
            self.counts.resets += u32::from(report.heading_found);
            match report.refusal {
                None => self.counts.aiding_used += 1,
                Some(AidRefusal::Invalid | AidRefusal::NoVehicle | AidRefusal::Future) => {
                    self.counts.aiding_invalid += 1;
                }
                Some(AidRefusal::NotAligned | AidRefusal::TooOld | AidRefusal::Innovation) => {
                    self.counts.aiding_refused += 1;
                }
            }
        }
    }

    /// An anchor as it was at a time of `CLOCK_MONOTONIC`, ns, as far as this camera has looked at it.
    pub fn anchor_at(&self, anchor: Anchor, time_ns: i64) -> Anchor {
        Anchor { drift: self.trail.at(anchor.id, time_ns).unwrap_or(anchor.drift), ..anchor }
    }

    /// Goes along with what the camera corrects against which this one was measured.
    fn follow_anchor(&mut self, now: SensorTime, arrival: HostTime) {
        let Some(anchor) = self.estimator.held_to() else { return };
        if self.followed.is_some_and(|last| now - last < FOLLOW_INTERVAL) {
            return;
        }
        self.followed = Some(now);
        if let Some((anchor, time_ns)) = self.membership.anchor(anchor, arrival) {
            self.trail.note(&anchor, time_ns);
            self.estimator.follow(&anchor);
        }
    }

    /// The pose at the last reading taken: the last step's, carried on over the remainder.
    pub fn at_last_reading(&self) -> Option<Estimate> {
        self.estimator.estimate_ahead(&self.grid.remainder())
    }

    /// From here on the filter learns nothing from standstills: for comparisons.
    pub const fn ignore_standstills(&mut self) {
        self.parameters.rest.enabled = false;
        self.estimator.ignore_standstills();
    }

    /// An estimator that goes back in time from the last step, and that step's time, once aligned.
    pub fn reversed(&self) -> Option<(Estimator, SensorTime)> {
        let time = self.estimator.estimate()?.time;
        Some((self.estimator.reversed()?, time))
    }

    /// The lane's part in the world.
    pub const fn membership(&self) -> &Membership {
        &self.membership
    }

    /// How far the filter is.
    pub const fn phase(&self) -> Phase {
        self.phase
    }

    /// Whether a long gap was crossed and the filter has not recovered from it.
    pub const fn is_degraded(&self) -> bool {
        self.degraded
    }

    /// Whether a calibration of this camera is applied.
    pub const fn is_calibrated(&self) -> bool {
        self.conditioner.is_calibrated()
    }

    /// What was counted so far.
    pub const fn counts(&self) -> CoreCounts {
        self.counts
    }

    /// A source that was opened again has a new clock: how long it was away is not known here, so
    /// the filter starts anew.
    fn follow_epoch(&mut self, epoch: u32) {
        let before = self.epoch.replace(epoch);
        if before.is_some_and(|before| before != epoch) {
            self.grid.reset();
            self.reset();
        }
    }

    /// Hands a sample to the grid. Where the source's clock was set back, or its newest time stamp was
    /// wrong, the filter starts anew: the grid alone would wait until the old time is reached again.
    fn push(&mut self, sample: ImuSample) -> Result<Accepted, Refusal> {
        let result = self.grid.push(sample);
        match result {
            Ok(_) => self.set_back.note_taken(),
            Err(Refusal::OutOfOrder) if self.set_back.was_set_back(sample.time) => {
                self.grid.reset();
                self.reset();
                return self.grid.push(sample);
            }
            Err(_) => {}
        }
        result
    }

    fn account(&mut self, accepted: Accepted) {
        match accepted {
            Accepted::First => {}
            Accepted::Continued { lost } => self.counts.lost += lost,
            Accepted::Gap { span, lost } => {
                self.counts.lost += lost;
                if span > self.reset_after {
                    self.reset();
                } else {
                    self.estimator.cross_gap(span);
                    self.degraded = true;
                }
            }
        }
    }

    fn reset(&mut self) {
        self.estimator = Estimator::new(self.parameters);
        self.counts.aiding_refused += self.aids.clear();
        self.phase = Phase::Aligning(Waiting::Collecting);
        self.degraded = false;
        self.counts.resets += 1;
    }
}

/// Whether the field is known not to be the earth's at the configured place.
pub fn is_unlike_earth(earth: Option<FieldReference>, estimate: Option<&Estimate>) -> bool {
    let seen = estimate.and_then(|e| e.magnetic_field_ut).map(FieldReference::of);
    seen.zip(earth)
        .is_some_and(|(seen, earth)| seen.distance_ut(&earth) > EARTH_TOLERANCE * earth.norm_ut)
}

/// Whether a filter that crossed a gap knows its attitude again.
pub fn recovered(estimate: &Estimate) -> bool {
    let variance = estimate.orientation_covariance;
    let tilt = variance.x_axis.x.max(variance.y_axis.y).sqrt();
    tilt < RECOVERED_TILT_RAD && variance.z_axis.z.sqrt() < RECOVERED_HEADING_RAD
}
