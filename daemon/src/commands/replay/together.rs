//! A whole configuration replayed: every camera with driver "replay", on one time base, rigs fused.
//!
//! The recordings' own times are the common clock. Readings are taken in order of time, whatever the
//! recordings' rates, begins and ends; so the same files give the same bytes.

use std::collections::VecDeque;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use lodestone_config::Loaded;
use lodestone_config::model::{DriverKind, Replay, Rig};

use super::relatives::{Relatives, report};
use super::{Lane, ReplayCommandError, axes_of, tell, tell_speed_unused};
use crate::cli::{ReplayArgs, WorldAxes};
use crate::driver::replay::ReplayDriver;
use crate::driver::{Driver, SourceState};
use crate::lane::{Phase, StepOutput, pose_row, status_of};
use crate::pose_axes::Axes;
use crate::poses_csv::{PosesError, PosesWriter};
use crate::reading::{HostTime, Reading};
use crate::rig::{GradientWriter, RigCore, RigSettings, RigStep};
use crate::service::signals::StopFlag;
use crate::world::{Membership, WorldFrame};

/// One camera's recording, and the readings of it that were read ahead.
struct Source {
    camera: usize,
    driver: ReplayDriver,
    ahead: VecDeque<Reading>,
    ended: bool,
}

impl Source {
    fn recording(&self, loaded: &Loaded) -> PathBuf {
        loaded.recording(&loaded.config.camera[self.camera]).unwrap_or_default()
    }
}

/// Where a camera's readings go.
#[derive(Clone, Copy, Debug)]
enum Goes {
    ToLane(usize),
    ToRig { rig: usize, member: usize },
}

/// A rig with files for publishers.
struct RigLane {
    core: RigCore,
    settings: RigSettings,
    outlets: Outlets,
    /// When the last reading came.
    last: HostTime,
}

/// The files of a rig.
struct Outlets {
    body: PosesWriter,
    members: Vec<PosesWriter>,
    gradient: GradientWriter,
    asked: WorldAxes,
    /// The world's axes, once there is a pose.
    axes: Option<Axes>,
    /// Where it is told where the body and its cameras are.
    frame: Arc<WorldFrame>,
    /// The first file that failed.
    failure: Option<PosesError>,
}

/// Replays the configuration's recordings.
///
/// # Errors
/// [`ReplayCommandError`]; without any recording [`ReplayCommandError::NoRecording`].
pub(super) fn replay(
    loaded: &Loaded,
    args: &ReplayArgs,
    stop: &StopFlag,
) -> Result<(), ReplayCommandError> {
    let mut sources = open(loaded, args)?;
    if sources.is_empty() {
        return Err(ReplayCommandError::NoRecording);
    }
    fs::create_dir_all(&args.out)
        .map_err(|source| ReplayCommandError::Directory { path: args.out.clone(), source })?;
    let first = sources.iter().map(|source| source.camera).min().unwrap_or_default();
    let file = args.out.join("relative.pairs.csv");
    let mut relatives = Relatives::create(&loaded.config, first, &file)?;
    let mut lanes = Lanes::open(loaded, args, (&sources, relatives.frame()))?;
    while let Some(next) = next_of(&mut sources) {
        if stop.is_raised() {
            return Err(ReplayCommandError::Interrupted(args.out.clone()));
        }
        let Some(reading) = sources[next].ahead.pop_front() else { continue };
        lanes.take(next, &reading, relatives.frame())?;
        relatives.write_if_due(reading.sensor_time)?;
    }
    relatives.finish()?;
    lanes.finish(loaded, &sources)?;
    broken(loaded, args, &sources)
}

/// Where the readings of all sources go.
struct Lanes {
    /// For each source.
    goes: Vec<Goes>,
    single: Vec<(usize, Lane)>,
    fused: Vec<RigLane>,
}

impl Lanes {
    fn open(
        loaded: &Loaded,
        args: &ReplayArgs,
        (sources, frame): (&[Source], &Arc<WorldFrame>),
    ) -> Result<Self, ReplayCommandError> {
        let rigs = rigs_of(loaded, sources);
        let fused = rigs.iter().map(|rig| RigLane::new(loaded, args, rig, (sources, frame)));
        let fused = fused.collect::<Result<Vec<_>, _>>()?;
        let (mut single, mut goes) = (Vec::new(), Vec::new());
        for source in sources {
            if let Some(to_rig) = destination(&rigs, source.camera) {
                goes.push(to_rig);
            } else {
                goes.push(Goes::ToLane(single.len()));
                single.push((source.camera, lane(loaded, args, source, frame)?));
            }
        }
        Ok(Self { goes, single, fused })
    }

    fn take(
        &mut self,
        source: usize,
        reading: &Reading,
        frame: &WorldFrame,
    ) -> Result<(), PosesError> {
        match self.goes[source] {
            Goes::ToRig { rig, member } => self.fused[rig].take(member, reading),
            Goes::ToLane(index) => {
                let (camera, lane) = &mut self.single[index];
                lane.take(reading)?;
                if let Some((time, estimate, world)) = &lane.latest {
                    report(frame, *camera, (*time, estimate), *world);
                }
                Ok(())
            }
        }
    }

    fn finish(self, loaded: &Loaded, sources: &[Source]) -> Result<(), ReplayCommandError> {
        for (camera, mut lane) in self.single {
            lane.give_up()?;
            if let Some(source) = sources.iter().find(|source| source.camera == camera) {
                tell(&source.recording(loaded), &lane.summary(&source.driver, 0));
            }
            lane.writer.finish()?;
        }
        self.fused.into_iter().try_for_each(|rig| rig.finish(loaded, sources))
    }
}

fn open(loaded: &Loaded, args: &ReplayArgs) -> Result<Vec<Source>, ReplayCommandError> {
    let directory = loaded.resolve("");
    let cameras = loaded.config.camera.iter().enumerate();
    let replayed = cameras.filter(|(_, camera)| camera.driver == DriverKind::Replay);
    let source = |(camera, settings): (usize, &lodestone_config::model::Camera)| {
        let configured = settings.replay.clone().unwrap_or_default();
        let replay = Replay { speed: args.speed, repeat: false, ..configured };
        let driver = ReplayDriver::open(&replay, &directory)?;
        Ok(Source { camera, driver, ahead: VecDeque::new(), ended: false })
    };
    replayed.map(source).collect()
}

/// The rigs that have any recording.
fn rigs_of(loaded: &Loaded, sources: &[Source]) -> Vec<Rig> {
    let recorded = |rig: &Rig| rig.members.iter().any(|m| sources.iter().any(|s| s.camera == *m));
    loaded.config.rigs().into_iter().filter(recorded).collect()
}

fn destination(rigs: &[Rig], camera: usize) -> Option<Goes> {
    rigs.iter().enumerate().find_map(|(rig, r)| {
        let member = r.members.iter().position(|&m| m == camera)?;
        Some(Goes::ToRig { rig, member })
    })
}

fn lane(
    loaded: &Loaded,
    args: &ReplayArgs,
    source: &Source,
    frame: &Arc<WorldFrame>,
) -> Result<Lane, ReplayCommandError> {
    let camera = &loaded.config.camera[source.camera];
    let calibration = loaded.calibration(camera)?;
    let poses = output(args, &camera.name);
    let lane = Lane::of(loaded, args, (camera, calibration.as_ref()), &source.driver, &poses)?;
    Ok(lane.in_world(Arc::clone(frame), source.camera))
}

fn output(args: &ReplayArgs, name: &str) -> PathBuf {
    args.out.join(format!("{name}.csv"))
}

/// The source whose next reading is the earliest; of two alike, the first configured.
fn next_of(sources: &mut [Source]) -> Option<usize> {
    for source in sources.iter_mut() {
        while source.ahead.is_empty() && !source.ended {
            let mut batch = Vec::new();
            let state = source.driver.poll(Duration::from_millis(100), &mut batch);
            source.ahead.extend(batch);
            source.ended = state == SourceState::Ended;
        }
    }
    let waiting = sources.iter().enumerate();
    let times = waiting.filter_map(|(k, s)| Some((s.ahead.front()?.sensor_time, k)));
    times.min().map(|(_, k)| k)
}

/// A recording that ended in the middle is told after all files are written.
fn broken(
    loaded: &Loaded,
    args: &ReplayArgs,
    sources: &[Source],
) -> Result<(), ReplayCommandError> {
    for source in sources {
        let camera = &loaded.config.camera[source.camera];
        if let Some(what) = source.driver.failure().get() {
            return Err(ReplayCommandError::Broken {
                recording: loaded.recording(camera).unwrap_or_default(),
                poses: output(args, &camera.name),
                what: what.to_string(),
            });
        }
    }
    Ok(())
}

impl RigLane {
    fn new(
        loaded: &Loaded,
        args: &ReplayArgs,
        rig: &Rig,
        (sources, frame): (&[Source], &Arc<WorldFrame>),
    ) -> Result<Self, ReplayCommandError> {
        let rate = |camera: usize| {
            let source = sources.iter().find(|source| source.camera == camera);
            let nominal = loaded.config.camera[camera].model.nominal_rate_hz();
            source.map_or(nominal, |s| s.driver.info().nominal_rate_hz)
        };
        let rates_hz: Vec<f64> = rig.members.iter().map(|&camera| rate(camera)).collect();
        let settings = RigSettings::new(loaded, rig, &rates_hz)?;
        let members =
            settings.members.iter().map(|m| PosesWriter::create(&output(args, &m.camera)));
        let outlets = Outlets {
            body: PosesWriter::create(&output(args, &settings.body))?,
            members: members.collect::<Result<_, _>>()?,
            gradient: GradientWriter::create(
                &args.out.join(format!("{}-gradient.csv", settings.body)),
            )?,
            asked: axes_of(loaded, args),
            axes: None,
            frame: Arc::clone(frame),
            failure: None,
        };
        let last = HostTime::default();
        // Its first camera's place in the order is its own.
        let membership = Membership::new(Arc::clone(frame), rig.members[0], settings.place);
        let core = RigCore::in_world(&settings, membership);
        Ok(Self { core, settings, outlets, last })
    }

    fn take(&mut self, member: usize, reading: &Reading) -> Result<(), PosesError> {
        let Self { core, settings, outlets, last } = self;
        *last = reading.arrival;
        core.take(member, reading, reading.sensor_time, |step| outlets.write(step, settings));
        outlets.failure.take().map_or(Ok(()), Err)
    }

    fn finish(mut self, loaded: &Loaded, sources: &[Source]) -> Result<(), ReplayCommandError> {
        let Self { core, settings, outlets, last } = &mut self;
        core.flush(*last, |step| outlets.write(step, settings));
        self.tell(loaded, sources);
        if let Some(failure) = self.outlets.failure {
            return Err(failure.into());
        }
        self.outlets.body.finish()?;
        self.outlets.gradient.finish()?;
        for writer in self.outlets.members {
            writer.finish()?;
        }
        Ok(())
    }

    fn tell(&self, loaded: &Loaded, sources: &[Source]) {
        for (member, settings) in self.settings.members.iter().enumerate() {
            let c = self.core.counts(member);
            let camera = settings.camera_id as usize;
            let source = sources.iter().find(|source| source.camera == camera);
            tracing::info!(
                rows = c.readings,
                malformed = source.map_or(0, |source| source.driver.counters().malformed),
                lost = c.lost,
                duplicates = c.duplicates,
                out_of_order = c.out_of_order,
                invalid = c.invalid,
                aiding_used = c.aiding_used,
                aiding_refused = c.aiding_refused,
                aiding_invalid = c.aiding_invalid,
                "{}: camera {}",
                self.settings.body,
                settings.camera
            );
            let with_speed = source.filter(|source| source.driver.has_speed());
            if let (Some(source), None) = (with_speed, &self.settings.rig.estimator.vehicle) {
                tell_speed_unused(&source.recording(loaded));
            }
        }
        if let Phase::Aligning(waiting) = self.core.phase() {
            tracing::warn!("{}: never aligned: {waiting}", self.settings.body);
        }
    }
}

impl Outlets {
    fn write(&mut self, step: &RigStep<'_>, settings: &RigSettings) {
        if let Err(failure) = self.try_write(step, settings) {
            self.failure.get_or_insert(failure);
        }
    }

    fn try_write(&mut self, step: &RigStep<'_>, settings: &RigSettings) -> Result<(), PosesError> {
        if let (None, Some(first)) = (self.axes, &step.body.estimate) {
            self.axes = Some(Axes::choose(self.asked, first));
        }
        let axes = self.axes.unwrap_or(Axes::EastNorthUp);
        let row = |of: &StepOutput, calibrated: bool| {
            let status = status_of(of, calibrated);
            axes.of_row(pose_row(of.time, of.estimate.as_ref(), status, &settings.validity))
        };
        let mut all_calibrated = true;
        for (k, (writer, member)) in self.members.iter_mut().zip(&settings.members).enumerate() {
            let calibrated = member.conditioner.is_calibrated();
            all_calibrated &= calibrated;
            let of = step.member(k);
            report_step(&self.frame, member.camera_id, &of);
            writer.write(&row(&of, calibrated))?;
        }
        report_step(&self.frame, settings.body_id, &step.body);
        self.body.write(&row(&step.body, all_calibrated))?;
        self.gradient.write(step.report)
    }
}

fn report_step(frame: &WorldFrame, member: u32, of: &StepOutput) {
    if let Some(estimate) = &of.estimate {
        report(frame, member as usize, (of.time, estimate), of.world);
    }
}
