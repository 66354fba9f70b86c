//! A live rig: readings out of its members' rings, poses of the body and of each member into shared
//! memory, news onto their boards.

use std::sync::Arc;

use lodestone_fusion::SensorTime;
use lodestone_fusion::rig::{GradientVerdict, MAX_MEMBERS, MemberStatus, RigReport};
use lodestone_schema::{
    Aiding, AnchorRefusal, CalibratedSample, LaneState, Pose, Status, Validity,
};

use super::core::{RigCore, RigStep};
use super::gradient_csv::verdict_name;
use super::settings::RigSettings;
use crate::clock::{SensorClock, UnixOffset};
use crate::driver::SourceState;
use crate::lane::{
    Addressee, Phase, Publish, StepOutput, fill_pose, sample_message, show_counts, understood,
    wait_of,
};
use crate::publisher::blank_pose;
use crate::reading::{HostTime, Reading};
use crate::status_board::{LaneBoard, LaneStatus, SensorStatus};
use crate::world::{Motion, WorldFrame};

/// Where messages under one name go.
pub struct Outlet<P> {
    /// Sends them.
    pub publisher: P,
    /// Where it is reported.
    pub board: Arc<LaneBoard>,
}

/// What is published under one name: the body's, or a member's.
struct Published<P> {
    outlet: Outlet<P>,
    pose: Pose,
    samples: u64,
    sensor: SensorStatus,
    calibrated: bool,
}

/// One member's clock and presence.
struct Presence {
    clock: SensorClock,
    last_arrival: Option<HostTime>,
    /// Nothing has come from it for longer than a pose may wait.
    silent: bool,
    /// What the log last said.
    told: MemberStatus,
}

/// The live rig. Nothing in it waits, locks or allocates after it was made.
pub struct RigWorker<P> {
    core: RigCore,
    settings: RigSettings,
    present: Vec<Presence>,
    out: Out<P>,
    stale_after_ns: i64,
}

/// Everything that is published.
struct Out<P> {
    body: Published<P>,
    members: Vec<Published<P>>,
    unix_offset: UnixOffset,
    world: Arc<WorldFrame>,
    verdict: GradientVerdict,
}

/// When a step was taken.
#[derive(Clone, Copy)]
struct When {
    arrival: HostTime,
    in_ring: HostTime,
    started: HostTime,
}

impl<P: Publish> RigWorker<P> {
    /// A rig that waits for its first reading. Members come with the number of host seconds in a
    /// second of their sensor's clock.
    pub fn new(
        core: RigCore,
        settings: RigSettings,
        body: Outlet<P>,
        members: Vec<(Outlet<P>, f64)>,
        unix_offset: UnixOffset,
    ) -> Self {
        let stale_after = settings.timing.stale_after;
        let world = Arc::clone(core.membership().frame());
        let present = members.iter().map(|(_, host_rate)| Presence {
            clock: SensorClock::new(*host_rate),
            last_arrival: None,
            silent: false,
            told: MemberStatus::default(),
        });
        let present = present.collect();
        let all = (0..members.len()).all(|k| core.is_calibrated(k));
        let published = members.into_iter().enumerate().map(|(k, (outlet, _))| {
            Published::new(outlet, settings.members[k].camera_id, core.is_calibrated(k))
        });
        let out = Out {
            members: published.collect(),
            body: Published::new(body, settings.body_id, all),
            unix_offset,
            world,
            verdict: GradientVerdict::Collecting,
        };
        Self {
            core,
            settings,
            present,
            out,
            stale_after_ns: i64::try_from(stale_after.as_nanos()).unwrap_or(i64::MAX),
        }
    }

    /// Takes one reading of a member, which was put into the ring at a time, through to the poses.
    pub fn take(&mut self, member: usize, reading: &Reading, in_ring: HostTime) {
        let when = When { arrival: reading.arrival, in_ring, started: HostTime::now() };
        let present = &mut self.present[member];
        present.clock.observe(reading.sensor_time, reading.arrival, reading.epoch);
        let Some(host_time) = present.clock.host_time(reading.sensor_time) else { return };
        let time = SensorTime::from_nanos(host_time.as_nanos());
        let (out, settings) = (&mut self.out, &self.settings);
        let taken = self.core.take(member, reading, time, |step| out.publish(step, settings, when));
        if taken.refusal.is_none() {
            present.last_arrival = Some(reading.arrival);
            present.silent = false;
            let message = sample_message(
                &taken.sample,
                reading.temperature_c,
                self.core.is_calibrated(member),
            );
            let sensor_time_ns = reading.sensor_time.as_nanos();
            let message = CalibratedSample {
                sensor_time_ns,
                time_ns: host_time.as_nanos(),
                arrival_time_ns: reading.arrival.as_nanos(),
                ..message
            };
            let drift = present.clock.drift();
            self.out.members[member].sample(&message, reading.temperature_c, drift);
        }
        self.report();
        self.tell();
    }

    /// Takes a measurement of another process, at a member, or at the body's origin.
    pub fn hear(&mut self, member: Option<usize>, message: &Aiding) {
        let pose = member.map_or(&self.out.body, |member| &self.out.members[member]).pose;
        let to = Addressee { camera_id: pose.camera_id, world_epoch: pose.world_epoch };
        if message.anchor != 0 {
            // Where a camera sits on its rig is configured; the rig as a whole is nobody's follower.
            let told = member.map_or(&self.out.body, |member| &self.out.members[member]);
            told.outlet.board.set_anchor_refusal(AnchorRefusal::OfRig);
            return self.core.count_refused_aid(member);
        }
        // The common clock is the host's.
        match understood(message, SensorTime::from_nanos(message.time_ns), to, None) {
            Some(aid) => self.core.aid(member, aid),
            None => self.core.count_invalid_aid(member),
        }
    }

    /// Looks after the sources when the rings are empty: a silent member is said to be, and silence of all
    /// makes the poses stale.
    pub fn watch(&mut self, member: usize, source: SourceState, now: HostTime) {
        let present = &mut self.present[member];
        let silent_ns = present.last_arrival.map(|at| now.as_nanos() - at.as_nanos());
        let silent = silent_ns.is_some_and(|ns| ns > self.stale_after_ns);
        let newly = silent && !present.silent;
        present.silent = silent;
        if silent || source != SourceState::Streaming {
            let known = present.last_arrival.is_some();
            let state = if known { LaneState::Lost } else { LaneState::Searching };
            self.out.members[member].outlet.board.set_state(state);
        }
        if newly && self.present.iter().all(|p| p.silent || p.last_arrival.is_none()) {
            self.out.publish_stale();
        }
    }

    fn report(&mut self) {
        let phase = self.core.phase();
        let state = match phase {
            Phase::Aligning(_) => LaneState::Aligning,
            Phase::Running if self.core.is_degraded() => LaneState::Degraded,
            Phase::Running => LaneState::Running,
        };
        self.out.body.report(state, phase, self.core.resets());
        self.out.body.outlet.board.set_members_in_use(self.members_in_use());
        let (counts, board) = (self.core.body_counts(), &self.out.body.outlet.board.counters);
        board.aiding_used.set(counts.aiding_used);
        board.aiding_refused.set(counts.aiding_refused);
        board.aiding_invalid.set(counts.aiding_invalid);
        for (k, (published, present)) in self.out.members.iter_mut().zip(&self.present).enumerate()
        {
            let counts = self.core.counts(k);
            show_counts(&counts, &published.outlet.board);
            let out = self.core.status(k).exclusion.is_some() && state == LaneState::Running;
            let own = if out { LaneState::Degraded } else { state };
            let own = if present.silent { LaneState::Lost } else { own };
            published.report(own, phase, counts.resets);
        }
    }

    /// One bit for each member that counts.
    fn members_in_use(&self) -> u32 {
        let counts = |k: &usize| self.core.status(*k).exclusion.is_none();
        (0..self.present.len()).filter(counts).fold(0, |bits, k| bits | 1 << k)
    }

    /// Says in the log who is out, and who is back.
    fn tell(&mut self) {
        for (k, present) in self.present.iter_mut().enumerate() {
            let status = self.core.status(k);
            if status == present.told {
                continue;
            }
            present.told = status;
            let (body, camera) = (&self.settings.body, &self.settings.members[k].camera);
            match (status.exclusion, status.magnetometer_alone) {
                (Some(why), _) => tracing::warn!(body, camera, ?why, "the camera does not count"),
                (None, true) => {
                    tracing::warn!(body, camera, "its magnetometer, and it alone, is disturbed");
                }
                (None, false) => tracing::info!(body, camera, "the camera counts"),
            }
        }
    }
}

impl<P: Publish> Out<P> {
    fn publish(&mut self, step: &RigStep<'_>, settings: &RigSettings, when: When) {
        let unix_offset_ns = self.unix_offset.as_nanos();
        let send = |to: &mut Published<P>, of: &StepOutput, stale: bool| {
            to.send(of, settings, when, (unix_offset_ns, stale));
        };
        send(&mut self.body, &step.body, false);
        self.body.report_motion(&step.body, &self.world);
        for k in 0..self.members.len().min(MAX_MEMBERS) {
            let of = step.member(k);
            let member = &mut self.members[k];
            send(member, &of, step.is_silent(k));
            member.report_motion(&of, &self.world);
        }
        self.note_gradient(step.report, settings);
    }

    /// Says in the log whether the gradient tells the velocity, and why not.
    fn note_gradient(&mut self, report: &RigReport, settings: &RigSettings) {
        let Some(gradient) = &report.gradient else { return };
        if gradient.verdict == self.verdict {
            return;
        }
        self.verdict = gradient.verdict;
        tracing::debug!(
            body = settings.body,
            verdict = verdict_name(gradient.verdict),
            gradient_ut_m = gradient.gradient_ut_m,
            "velocity by the magnetic gradient"
        );
    }

    /// The last poses once more, with nothing claimed about them.
    fn publish_stale(&mut self) {
        self.body.send_stale();
        self.members.iter_mut().for_each(Published::send_stale);
    }
}

impl<P: Publish> Published<P> {
    fn new(outlet: Outlet<P>, camera_id: u32, calibrated: bool) -> Self {
        let pose = Pose { camera_id, ..blank_pose() };
        Self { outlet, pose, samples: 0, sensor: SensorStatus::default(), calibrated }
    }

    fn send(
        &mut self,
        step: &StepOutput,
        settings: &RigSettings,
        when: When,
        (unix_offset_ns, stale): (i64, bool),
    ) {
        fill_pose(&mut self.pose, step, &settings.validity, self.calibrated);
        if stale {
            // Its sensor is; its pose is the rig's.
            self.pose.status |= Status::SENSOR_STALE.bits();
        }
        self.pose.time_ns = step.time.as_nanos();
        self.pose.validity |= Validity::TIME.bits();
        self.pose.arrival_time_ns = when.arrival.as_nanos();
        self.pose.ring_time_ns = when.in_ring.as_nanos();
        self.pose.step_start_time_ns = when.started.as_nanos();
        self.pose.step_end_time_ns = HostTime::now().as_nanos();
        self.pose.unix_offset_ns = unix_offset_ns;
        if let Some(published) = self.outlet.publisher.pose(&self.pose) {
            self.outlet.board.latency.record(published.as_nanos() - when.arrival.as_nanos());
        }
        if let Some(field_ut) = step.estimate.as_ref().and_then(|e| e.magnetic_field_ut) {
            self.sensor.magnetic_norm_ut = field_ut.length();
        }
        self.outlet.board.latest.report(&LaneStatus::of(&self.pose, self.sensor));
        self.pose.sequence += 1;
    }

    /// Tells those who compare cameras where it is.
    fn report_motion(&self, step: &StepOutput, world: &WorldFrame) {
        if let Some(estimate) = &step.estimate {
            let motion = Motion::of(estimate, self.pose.time_ns, &step.world);
            world.report_motion(self.pose.camera_id as usize, &motion);
        }
    }

    fn send_stale(&mut self) {
        if self.pose.sequence == 0 {
            return;
        }
        let status = Status::from_bits_retain(self.pose.status) | Status::SENSOR_STALE;
        self.pose.status = (status - Status::STATIONARY).bits();
        self.pose.validity = 0;
        self.outlet.publisher.pose(&self.pose);
        self.outlet.board.latest.report(&LaneStatus::of(&self.pose, self.sensor));
        self.outlet.board.set_state(LaneState::Lost);
        self.pose.sequence += 1;
    }

    fn sample(&mut self, sample: &CalibratedSample, temperature_c: Option<f32>, drift: f64) {
        if let Some(temperature_c) = temperature_c {
            self.sensor.temperature_c = temperature_c.into();
        }
        self.sensor.clock_drift = drift;
        let message =
            CalibratedSample { sequence: self.samples, camera_id: self.pose.camera_id, ..*sample };
        self.outlet.publisher.sample(&message);
        self.samples += 1;
    }

    fn report(&mut self, state: LaneState, phase: Phase, resets: u32) {
        self.pose.reset_counter = resets;
        let board = &self.outlet.board;
        board.set_alignment_wait(wait_of(phase));
        board.set_state(state);
        board.counters.resets.set(resets.into());
        board.counters.poses.set(self.pose.sequence);
        board.counters.publish_errors.set(self.outlet.publisher.errors());
    }
}
