//! The part of a rig's lane that depends on its readings alone: same readings in, same bits out.

use glam::DVec3;
use lodestone_fusion::rig::{Exclusion, MemberStatus, RigEstimator, RigReport};
use lodestone_fusion::{
    Accepted, Aid, AidRefusal, Estimate, FieldReference, Grid, ImuSample, Refusal, SensorSpan,
    SensorTime, Step, Waiting,
};

use lodestone_schema::Status;

use super::assembler::{Assembler, AssemblerCounts, Fit, Row};
use super::settings::{MemberSettings, RigSettings};
use crate::lane::{
    AidQueue, Conditioner, CoreCounts, Phase, SetBack, StepOutput, Taken, is_unlike_earth,
    recovered,
};
use crate::reading::{HostTime, Reading};
use crate::world::Membership;

/// One member on its way to the common grid.
#[derive(Clone, Debug)]
struct Member {
    conditioner: Conditioner,
    grid: Grid,
    set_back: SetBack,
    aids: AidQueue,
    epoch: Option<u32>,
    counts: CoreCounts,
}

/// What one step of the rig brought: the body's pose, and on demand each member's.
#[derive(Clone, Copy, Debug)]
pub struct RigStep<'a> {
    /// The body's own.
    pub body: StepOutput,
    /// What the rig's estimator says.
    pub report: &'a RigReport,
    estimator: &'a RigEstimator,
}

impl RigStep<'_> {
    /// A member's pose: its IMU's, carried over from the rig's.
    pub fn member(&self, member: usize) -> StepOutput {
        let point = self.estimator.geometry().member(member);
        let estimate = self.body.estimate.and_then(|_| self.estimator.estimate_at(&point));
        let alone = self.report.members[member].magnetometer_alone;
        let bent = self.report.field_bent || alone;
        let disturbed =
            |e: Estimate| Estimate { magnetic_disturbance: e.magnetic_disturbance || bent, ..e };
        let mut rig = self.body.rig;
        rig.set(Status::DISTURBANCE_LOCAL, alone);
        StepOutput { estimate: estimate.map(disturbed), rig, ..self.body }
    }

    /// Whether a member gives nothing.
    pub fn is_silent(&self, member: usize) -> bool {
        self.report.members[member].exclusion == Some(Exclusion::Silent)
    }
}

/// A rig's lane without its surroundings.
#[derive(Clone, Debug)]
pub struct RigCore {
    members: Vec<Member>,
    assembler: Assembler,
    /// A box: it is large, and begun anew now and then.
    estimator: Box<RigEstimator>,
    /// As it was made.
    fresh: Box<RigEstimator>,
    bridge_limit: SensorSpan,
    reset_after: SensorSpan,
    earth: Option<FieldReference>,
    last: Option<SensorTime>,
    membership: Membership,
    /// What others measured at the body's origin.
    body_aids: AidQueue,
    body_counts: CoreCounts,
    position_jumped: bool,
    phase: Phase,
    degraded: bool,
    resets: u32,
}

impl RigCore {
    /// A rig that waits for its first reading, in a world of its own.
    pub fn new(settings: &RigSettings) -> Self {
        Self::in_world(settings, Membership::alone(settings.place))
    }

    /// A rig that waits for its first reading, in a world that it shares.
    pub fn in_world(settings: &RigSettings, membership: Membership) -> Self {
        let estimator = Box::new(RigEstimator::new(settings.geometry, settings.rig));
        let grid = settings.members[0].grid;
        let reset_after = settings.timing.reset_after;
        let member = |m: &MemberSettings| Member {
            conditioner: m.conditioner.clone(),
            grid: Grid::new(m.grid).with_low_pass(m.low_pass),
            set_back: SetBack::new(reset_after),
            aids: AidQueue::new(m.antenna_m),
            epoch: None,
            counts: CoreCounts::default(),
        };
        Self {
            members: settings.members.iter().map(member).collect(),
            assembler: Assembler::new(settings.members.len(), grid.step),
            fresh: estimator.clone(),
            estimator,
            bridge_limit: grid.bridge_limit,
            reset_after,
            earth: settings.earth,
            last: None,
            membership,
            body_aids: AidQueue::new(DVec3::ZERO),
            body_counts: CoreCounts::default(),
            position_jumped: false,
            phase: Phase::Aligning(Waiting::Collecting),
            degraded: false,
            resets: 0,
        }
    }

    /// Takes one reading of a member, at its time on the members' common clock, and hands each step that
    /// is complete to `on_step`, in order.
    pub fn take(
        &mut self,
        member: usize,
        reading: &Reading,
        time: SensorTime,
        mut on_step: impl FnMut(&RigStep<'_>),
    ) -> Taken {
        let from = &mut self.members[member];
        let (sample, pushed) = from.take(reading, time);
        if let Err(refusal) = pushed {
            return Taken { sample, refusal: Some(refusal) };
        }
        self.queue_aids(member, reading, time);
        let arrival = reading.arrival;
        while let Some(step) = self.members[member].grid.next_step() {
            self.members[member].counts.bridged += u64::from(step.bridged);
            if self.assembler.insert(member, step) == Fit::AllFar {
                self.flush(arrival, &mut on_step);
                self.assembler.skip_to(member, step);
            }
            while let Some(row) = self.assembler.next_row() {
                self.step(&row, arrival, &mut on_step);
            }
        }
        Taken { sample, refusal: None }
    }

    /// Hands on what still waits for members that give no more.
    pub fn flush(&mut self, arrival: HostTime, mut on_step: impl FnMut(&RigStep<'_>)) {
        while let Some(row) = self.assembler.flush() {
            self.step(&row, arrival, &mut on_step);
        }
    }

    /// How far the filter is.
    pub const fn phase(&self) -> Phase {
        self.phase
    }

    /// Whether a long gap was crossed and the filter has not recovered from it.
    pub const fn is_degraded(&self) -> bool {
        self.degraded
    }

    /// Times the filter began anew, or found north late.
    pub const fn resets(&self) -> u32 {
        self.resets
    }

    /// What a member's readings came to.
    pub fn counts(&self, member: usize) -> CoreCounts {
        CoreCounts { resets: self.resets, ..self.members[member].counts }
    }

    /// What measurements at the body's origin came to.
    pub const fn body_counts(&self) -> CoreCounts {
        CoreCounts { resets: self.resets, ..self.body_counts }
    }

    /// What was counted where the members come together.
    pub const fn assembler_counts(&self) -> AssemblerCounts {
        self.assembler.counts()
    }

    /// Whether a calibration of a member is applied.
    pub fn is_calibrated(&self, member: usize) -> bool {
        self.members[member].conditioner.is_calibrated()
    }

    /// How a member stands.
    pub fn status(&self, member: usize) -> MemberStatus {
        self.estimator.status(member)
    }

    /// The rig's part in the world.
    pub const fn membership(&self) -> &Membership {
        &self.membership
    }

    /// Takes what others measured at a member, from its recording.
    fn queue_aids(&mut self, member: usize, reading: &Reading, time: SensorTime) {
        let point = self.estimator.geometry().member(member);
        let from = &mut self.members[member];
        // The recording's clock and the members' common one differ by the reading's own times.
        let shift = time - reading.sensor_time;
        for aid in from.aids.recorded(reading).into_iter().flatten() {
            let measurement = point.measured(aid.measurement);
            let aid = Aid { time: aid.time + shift, measurement, ..aid };
            from.counts.aiding_invalid += u64::from(from.aids.push(aid, time).is_err());
        }
    }

    /// Takes a measurement by others at a member, or at the body's origin, on the common clock; it waits
    /// until the grid has come there.
    pub fn aid(&mut self, member: Option<usize>, aid: Aid) {
        let geometry = self.estimator.geometry();
        let point = member.map_or_else(|| geometry.origin(), |member| geometry.member(member));
        let aid = Aid { measurement: point.measured(aid.measurement), ..aid };
        let newest = self.last.unwrap_or(aid.time);
        let (queue, counts) = self.queue_of(member);
        counts.aiding_invalid += u64::from(queue.push(aid, newest).is_err());
    }

    /// A measurement by others could not even be read.
    pub fn count_invalid_aid(&mut self, member: Option<usize>) {
        self.queue_of(member).1.aiding_invalid += 1;
    }

    /// A measurement against another camera, which a rig is not taken to.
    pub fn count_refused_aid(&mut self, member: Option<usize>) {
        self.queue_of(member).1.aiding_refused += 1;
    }

    fn queue_of(&mut self, member: Option<usize>) -> (&mut AidQueue, &mut CoreCounts) {
        match member {
            Some(member) => {
                let member = &mut self.members[member];
                (&mut member.aids, &mut member.counts)
            }
            None => (&mut self.body_aids, &mut self.body_counts),
        }
    }

    /// Hands the estimator what is valid up to the end of its last step.
    fn offer_due(&mut self, now: SensorTime) {
        let members = self.members.iter_mut().map(|m| (&mut m.aids, &mut m.counts));
        let body = core::iter::once((&mut self.body_aids, &mut self.body_counts));
        for (aids, counts) in members.chain(body) {
            while let Some(aid) = aids.next_due(now) {
                let report = self.estimator.aid(&aid);
                self.position_jumped |= report.position_jumped;
                match report.refusal {
                    None => counts.aiding_used += 1,
                    Some(AidRefusal::Invalid | AidRefusal::NoVehicle | AidRefusal::Future) => {
                        counts.aiding_invalid += 1;
                    }
                    Some(_) => counts.aiding_refused += 1,
                }
            }
        }
    }

    fn step(&mut self, row: &Row, arrival: HostTime, on_step: &mut impl FnMut(&RigStep<'_>)) {
        let Some(first) = row.iter().flatten().next() else { return };
        self.account(first);
        let Some(report) = self.estimator.step(row) else { return };
        let (filter, aligned) = (self.estimator.estimator_mut(), report.step.just_aligned);
        let began_anew = self.membership.follow(filter, aligned, arrival);
        self.resets += u32::from(report.step.world_turned || began_anew);
        self.phase = report.step.waiting.map_or(Phase::Running, Phase::Aligning);
        self.offer_due(report.time);
        let world = self.membership.note(self.estimator.estimate().as_ref(), arrival);
        let origin = self.estimator.geometry().origin();
        let estimate = self.estimator.estimate_at(&origin);
        self.degraded = self.degraded && !estimate.as_ref().is_some_and(recovered);
        let body = StepOutput {
            time: report.time,
            estimate: estimate.map(|e| Estimate {
                magnetic_disturbance: e.magnetic_disturbance || report.field_bent,
                ..e
            }),
            phase: self.phase,
            bridged: report.bridged,
            saturated: report.saturated,
            degraded: self.degraded,
            field_unlike_earth: is_unlike_earth(self.earth, estimate.as_ref()),
            position_jumped: std::mem::take(&mut self.position_jumped),
            world,
            rig: standing_of(&report, self.members.len()),
        };
        on_step(&RigStep { body, report: &report, estimator: &self.estimator });
        if report.step.waiting.is_none() && estimate.is_none() {
            // A state that is not finite has no way back.
            self.reset();
        }
    }

    /// Accounts for time in which no member gave anything.
    fn account(&mut self, step: &Step) {
        let span = SensorSpan::from_secs_f64(step.increment.span_s);
        let Some(last) = self.last.replace(step.time) else { return };
        let gap = SensorSpan::from_nanos((step.time - last).as_nanos() - span.as_nanos());
        if gap > self.reset_after {
            self.reset();
        } else if gap > self.bridge_limit {
            self.estimator.cross_gap(gap);
            self.degraded = true;
        }
    }

    fn reset(&mut self) {
        self.estimator.clone_from(&self.fresh);
        for member in &mut self.members {
            member.counts.aiding_refused += member.aids.clear();
        }
        self.body_counts.aiding_refused += self.body_aids.clear();
        self.phase = Phase::Aligning(Waiting::Collecting);
        self.degraded = false;
        self.resets += 1;
    }
}

/// What every pose of the rig says of it.
fn standing_of(report: &RigReport, members: usize) -> Status {
    let out = report.members.iter().take(members).any(|member| member.exclusion.is_some());
    let mut standing = Status::ON_BODY;
    standing.set(Status::MEMBER_OUT, out);
    standing
}

impl Member {
    fn take(
        &mut self,
        reading: &Reading,
        time: SensorTime,
    ) -> (ImuSample, Result<Accepted, Refusal>) {
        self.counts.readings += 1;
        let before = self.epoch.replace(reading.epoch);
        if before.is_some_and(|before| before != reading.epoch) {
            self.grid.reset();
        }
        let sample = ImuSample { time, ..self.conditioner.condition(reading) };
        let result = self.push(sample);
        match result {
            Ok(Accepted::Continued { lost } | Accepted::Gap { lost, .. }) => {
                self.counts.lost += lost;
            }
            Ok(Accepted::First) => {}
            Err(refusal) => self.counts.note_refusal(refusal),
        }
        (sample, result)
    }

    fn push(&mut self, sample: ImuSample) -> Result<Accepted, Refusal> {
        let result = self.grid.push(sample);
        match result {
            Ok(_) => self.set_back.note_taken(),
            Err(Refusal::OutOfOrder) if self.set_back.was_set_back(sample.time) => {
                self.grid.reset();
                return self.grid.push(sample);
            }
            Err(_) => {}
        }
        result
    }
}
