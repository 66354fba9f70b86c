//! A live lane: readings out of the ring, poses into shared memory, news onto the board.

use std::sync::Arc;

use lodestone_fusion::{Anchor, SensorTime};
use lodestone_schema::{
    Aiding, AnchorRefusal, CalibratedSample, LaneState, Pose, Status, Validity,
};

use super::core::{Core, CoreCounts, Phase, StepOutput};
use super::heard::{Addressee, anchor_index, fix_source, understood};
use super::message::{fill_pose, sample_message, wait_of};
use super::settings::LaneSettings;
use crate::clock::{SensorClock, UnixOffset};
use crate::driver::SourceState;
use crate::publisher::blank_pose;
use crate::reading::{HostTime, Reading};
use crate::status_board::{LaneBoard, LaneStatus, SensorStatus};
use crate::world::{Motion, WorldFrame, anchor_for};

/// Where a live lane's messages go.
pub trait Publish {
    /// Sends a pose; gives the time at which it was sent, or nothing if it could not be.
    fn pose(&mut self, pose: &Pose) -> Option<HostTime>;

    /// Sends a calibrated sample.
    fn sample(&mut self, sample: &CalibratedSample);

    /// Messages that could not be sent so far.
    fn errors(&self) -> u64;
}

/// The live lane. Nothing in it waits, locks or allocates after it was made.
pub struct Worker<P> {
    core: Core,
    outlet: Outlet<P>,
    stale_after_ns: i64,
    /// When the last reading came that could be used.
    last_arrival: Option<HostTime>,
    silent: bool,
    epoch: Option<u32>,
}

/// What turns steps into messages: clocks, sequence numbers, the publisher and the board.
struct Outlet<P> {
    settings: LaneSettings,
    publisher: P,
    board: Arc<LaneBoard>,
    clock: SensorClock,
    unix_offset: UnixOffset,
    pose: Pose,
    samples: u64,
    sensor: SensorStatus,
    /// Where those who compare cameras look.
    world: Arc<WorldFrame>,
}

impl<P: Publish> Worker<P> {
    /// A lane that waits for its first reading.
    ///
    /// `host_rate` is the number of host seconds in a sensor second: 1 for a device.
    pub fn new(
        core: Core,
        settings: LaneSettings,
        publisher: P,
        board: Arc<LaneBoard>,
        unix_offset: UnixOffset,
        host_rate: f64,
    ) -> Self {
        let stale_after = settings.timing.stale_after;
        let world = Arc::clone(core.membership().frame());
        Self {
            core,
            stale_after_ns: i64::try_from(stale_after.as_nanos()).unwrap_or(i64::MAX),
            last_arrival: None,
            silent: false,
            epoch: None,
            outlet: Outlet {
                pose: Pose { camera_id: settings.camera_id, ..blank_pose() },
                settings,
                publisher,
                board,
                clock: SensorClock::new(host_rate),
                unix_offset,
                samples: 0,
                sensor: SensorStatus::default(),
                world,
            },
        }
    }

    /// Takes one reading through to its poses.
    pub fn take(&mut self, reading: &Reading) {
        let started = HostTime::now();
        if self.epoch.replace(reading.epoch).is_some_and(|e| e != reading.epoch) {
            tracing::warn!(camera = self.outlet.settings.camera, "the source began anew");
        }
        let outlet = &mut self.outlet;
        outlet.clock.observe(reading.sensor_time, reading.arrival, reading.epoch);
        let calibrated = self.core.is_calibrated();
        let taken = self.core.take(reading, |step| {
            outlet.publish(step, reading.arrival, started, calibrated);
        });
        if taken.refusal.is_none() {
            // A source that sends only what cannot be used is as good as silent.
            self.last_arrival = Some(reading.arrival);
            self.silent = false;
            outlet.note_sensor(reading);
            outlet.publish_sample(
                &sample_message(&taken.sample, reading.temperature_c, calibrated),
                reading,
            );
            outlet.report_state(&self.core);
        }
        self.count();
    }

    /// Takes a measurement of another process.
    pub fn hear(&mut self, message: &Aiding) {
        let outlet = &self.outlet;
        let to = Addressee {
            camera_id: outlet.settings.camera_id,
            world_epoch: outlet.pose.world_epoch,
        };
        let anchor = match outlet.anchor_of(message) {
            Ok(anchor) => anchor.map(|anchor| self.core.anchor_at(anchor, message.time_ns)),
            Err(why) => return self.refuse_anchor(why),
        };
        let valid_at = outlet.clock.sensor_time(HostTime::from_nanos(message.time_ns));
        match valid_at.and_then(|time| understood(message, time, to, anchor)) {
            Some(aid) => {
                if anchor.is_some() {
                    outlet.board.set_anchor_refusal(AnchorRefusal::None);
                }
                if let Some(source) = fix_source(message) {
                    self.core.hear_fix(source);
                }
                self.core.aid(aid);
            }
            None => self.core.count_invalid_aid(),
        }
    }

    /// Counts a measurement against a camera that cannot be its anchor, and says why, once.
    fn refuse_anchor(&mut self, why: AnchorRefusal) {
        self.core.count_refused_aid();
        let board = &self.outlet.board;
        if board.anchor_refusal() != why {
            let camera = &self.outlet.settings.camera;
            tracing::warn!(
                camera,
                "a measurement against another camera is refused: {}",
                why.advice()
            );
        }
        board.set_anchor_refusal(why);
        self.count();
    }

    /// Looks after the source when the ring is empty: silence makes the pose stale.
    pub fn watch(&mut self, source: SourceState, now: HostTime) {
        let silent_ns = self.last_arrival.map(|at| now.as_nanos() - at.as_nanos());
        let lost = source != SourceState::Streaming;
        let silent = silent_ns.is_some_and(|ns| ns > self.stale_after_ns);
        if silent && !self.silent {
            self.silent = true;
            self.outlet.publish_stale();
            self.count();
        }
        if lost || silent {
            let state =
                if self.last_arrival.is_some() { LaneState::Lost } else { LaneState::Searching };
            self.outlet.board.set_state(state);
        }
    }

    fn count(&self) {
        show_counts(&self.core.counts(), &self.outlet.board);
        let board = &self.outlet.board.counters;
        board.poses.set(self.outlet.pose.sequence);
        board.publish_errors.set(self.outlet.publisher.errors());
    }
}

/// Shows on a board what a core counted of one camera.
pub(crate) fn show_counts(counts: &CoreCounts, board: &LaneBoard) {
    let board = &board.counters;
    board.samples.set(counts.readings);
    board.samples_lost.set(counts.lost);
    board.steps_bridged.set(counts.bridged);
    board.duplicates.set(counts.duplicates);
    board.out_of_order.set(counts.out_of_order);
    board.invalid.set(counts.invalid);
    board.resets.set(counts.resets.into());
    board.aiding_used.set(counts.aiding_used);
    board.aiding_refused.set(counts.aiding_refused);
    board.aiding_invalid.set(counts.aiding_invalid);
}

impl<P: Publish> Outlet<P> {
    fn publish(
        &mut self,
        step: &StepOutput,
        arrival: HostTime,
        started: HostTime,
        calibrated: bool,
    ) {
        fill_pose(&mut self.pose, step, &self.settings.validity, calibrated);
        self.pose.time_ns = self.host_time_ns(step.time);
        self.pose.validity |= Validity::TIME.bits();
        self.pose.arrival_time_ns = arrival.as_nanos();
        self.pose.step_start_time_ns = started.as_nanos();
        self.pose.step_end_time_ns = HostTime::now().as_nanos();
        self.pose.unix_offset_ns = self.unix_offset.as_nanos();
        if let Some(published) = self.publisher.pose(&self.pose) {
            self.board.latency.record(published.as_nanos() - arrival.as_nanos());
        }
        if let Some(field_ut) = step.estimate.as_ref().and_then(|e| e.magnetic_field_ut) {
            self.sensor.magnetic_norm_ut = field_ut.length();
        }
        self.board.latest.report(&LaneStatus::of(&self.pose, self.sensor));
        self.pose.sequence += 1;
        if let Some(estimate) = &step.estimate {
            let motion = Motion::of(estimate, self.pose.time_ns, &step.world);
            let member = self.settings.camera_id as usize;
            self.world.report_motion(member, &motion);
            self.world.report_tie(member, &motion, estimate.tie.as_ref());
        }
    }

    /// The camera against which a message's pose was measured, if it says that it was.
    fn anchor_of(&self, message: &Aiding) -> Result<Option<Anchor>, AnchorRefusal> {
        let Some(anchor) = anchor_index(message)? else { return Ok(None) };
        let times = (HostTime::from_nanos(message.time_ns), HostTime::now());
        anchor_for(&self.world, self.settings.camera_id as usize, anchor, times).map(Some)
    }

    /// The last pose once more, with nothing claimed about it.
    fn publish_stale(&mut self) {
        if self.pose.sequence == 0 {
            return;
        }
        let status = Status::from_bits_retain(self.pose.status) | Status::SENSOR_STALE;
        self.pose.status = (status - Status::STATIONARY).bits();
        self.pose.validity = 0;
        self.publisher.pose(&self.pose);
        self.board.latest.report(&LaneStatus::of(&self.pose, self.sensor));
        self.pose.sequence += 1;
    }

    fn publish_sample(&mut self, sample: &CalibratedSample, reading: &Reading) {
        let message = CalibratedSample {
            sequence: self.samples,
            camera_id: self.settings.camera_id,
            time_ns: self.host_time_ns(reading.sensor_time),
            arrival_time_ns: reading.arrival.as_nanos(),
            ..*sample
        };
        self.publisher.sample(&message);
        self.samples += 1;
    }

    fn note_sensor(&mut self, reading: &Reading) {
        if let Some(temperature_c) = reading.temperature_c {
            self.sensor.temperature_c = temperature_c.into();
        }
        self.sensor.clock_drift = self.clock.drift();
    }

    fn report_state(&mut self, core: &Core) {
        self.pose.reset_counter = core.counts().resets;
        self.board.set_alignment_wait(wait_of(core.phase()));
        self.board.set_state(match core.phase() {
            Phase::Aligning(_) => LaneState::Aligning,
            Phase::Running if core.is_degraded() => LaneState::Degraded,
            Phase::Running => LaneState::Running,
        });
    }

    fn host_time_ns(&mut self, taken: SensorTime) -> i64 {
        // There is an arrival before there is a step.
        self.clock.host_time(taken).map_or(0, HostTime::as_nanos)
    }
}
