//! `lodestoned replay`: recordings in, poses out, through the very lane that runs live.
//!
//! Driver, ring, grid and filter are those of a running daemon; only the clock is the recording's
//! and the poses go to files.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use lodestone_config::model::{Camera, Config, DriverKind, Preset, Replay};
use lodestone_config::{Calibration, LoadError, Loaded};
use lodestone_fusion::{Estimate, SensorTime};
use lodestone_schema::Status;

use crate::cli::{PresetArg, ReplayArgs, WorldAxes};
use crate::driver::replay::{ReplayDriver, ReplayError};
use crate::driver::{Driver, SourceState};
use crate::hindsight::{HeldRow, Hindsight};
use crate::lane::{
    Core, CoreCounts, LaneSettings, Phase, SettingsError, StepOutput, Taken, pose_row, status_of,
};
use crate::pose_axes::Axes;
use crate::poses_csv::{PosesError, PosesWriter};
use crate::reading::Reading;
use crate::rig::RigError;
use crate::ring::ring;
use crate::service::signals::StopFlag;
use crate::world::{Membership, WorldFrame, WorldStep};

mod relatives;
mod together;

/// Why a replay failed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayCommandError {
    /// Two recordings would write the same file, or one would overwrite itself.
    #[error("{}: would be written twice; allowed: recordings with different names", .0.display())]
    SameOutput(PathBuf),
    /// The directory for the poses cannot be made.
    #[error("{}: cannot make the directory: {source}", path.display())]
    Directory {
        /// The directory.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A recording cannot be read.
    #[error(transparent)]
    Open(#[from] ReplayError),
    /// The replayed camera's calibration cannot be used.
    #[error(transparent)]
    Calibration(#[from] LoadError),
    /// A recording ends in the middle.
    #[error("{}: {what}; the poses up to there are in {}", recording.display(), poses.display())]
    Broken {
        /// The recording.
        recording: PathBuf,
        /// The poses.
        poses: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// True north is not known.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Poses cannot be written.
    #[error(transparent)]
    Write(#[from] PosesError),
    /// There is nothing to replay.
    #[error(
        "no recording: name FILE, or a configuration (--config) with at least one camera with \
         driver = \"replay\""
    )]
    NoRecording,
    /// A rig cannot be made.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// Signals cannot be handled.
    #[error("cannot handle signals: {0}")]
    Signals(io::Error),
    /// SIGINT or SIGTERM.
    #[error("interrupted; {} is not complete", .0.display())]
    Interrupted(PathBuf),
}

impl ReplayCommandError {
    /// 2 where the command line or the configuration is to blame, else 1.
    pub const fn exit_code(&self) -> u8 {
        match self {
            Self::SameOutput(_) | Self::Calibration(_) | Self::NoRecording | Self::Rig(_) => 2,
            _ => 1,
        }
    }
}

/// Replays every recording through a lane of its own.
///
/// # Errors
/// [`ReplayCommandError`]; recordings before the failed one are complete.
pub fn replay(loaded: &Loaded, args: &ReplayArgs) -> Result<(), ReplayCommandError> {
    let stop = StopFlag::new();
    stop.raise_on_signals().map_err(ReplayCommandError::Signals)?;
    let outputs = outputs(args)?;
    if args.files.is_empty() {
        return together::replay(loaded, args, &stop);
    }
    fs::create_dir_all(&args.out)
        .map_err(|source| ReplayCommandError::Directory { path: args.out.clone(), source })?;
    for (recording, poses) in args.files.iter().zip(&outputs) {
        let summary = replay_one(loaded, recording, poses, args, &stop)?;
        tell(recording, &summary);
    }
    Ok(())
}

/// `NAME.csv` in the directory for each `NAME.csv` or `NAME.csv.zst`.
fn outputs(args: &ReplayArgs) -> Result<Vec<PathBuf>, ReplayCommandError> {
    let mut outputs: Vec<PathBuf> = Vec::new();
    for recording in &args.files {
        let name = recording.file_name().unwrap_or_default().to_string_lossy();
        let name = name.strip_suffix(".zst").unwrap_or(&name);
        let output = args.out.join(format!("{}.csv", name.strip_suffix(".csv").unwrap_or(name)));
        let same = |other: &Path| match (fs::canonicalize(other), fs::canonicalize(&output)) {
            (Ok(a), Ok(b)) => a == b,
            _ => false,
        };
        if outputs.contains(&output) || args.files.iter().any(|file| same(file)) {
            return Err(ReplayCommandError::SameOutput(output));
        }
        outputs.push(output);
    }
    Ok(outputs)
}

/// What a replay found.
struct Summary {
    rows: u64,
    malformed: u64,
    ring_dropped: u64,
    counts: CoreCounts,
    phase: Phase,
    has_magnetometer: bool,
    /// There are speeds, and no vehicle that has them.
    speed_unused: bool,
}

fn replay_one(
    loaded: &Loaded,
    recording: &Path,
    poses: &Path,
    args: &ReplayArgs,
    stop: &StopFlag,
) -> Result<Summary, ReplayCommandError> {
    let file = recording.to_string_lossy().into_owned();
    let settings = Replay { file, speed: args.speed, repeat: false };
    let mut driver = ReplayDriver::open(&settings, Path::new(""))?;
    let failure = driver.failure();
    let mut lane = Lane::new(loaded, args, &driver, poses)?;
    let (mut producer, mut consumer) = ring(loaded.config.lane.ring_capacity);
    loop {
        let state = driver.poll(Duration::from_millis(100), &mut producer);
        while let Some(reading) = consumer.pop() {
            lane.take(&reading)?;
        }
        if stop.is_raised() {
            return Err(ReplayCommandError::Interrupted(poses.into()));
        }
        if state == SourceState::Ended {
            break;
        }
    }
    lane.give_up()?;
    let summary = lane.summary(&driver, producer.monitor().counters().dropped);
    lane.writer.finish()?;
    match failure.get() {
        Some(what) => Err(ReplayCommandError::Broken {
            recording: recording.into(),
            poses: poses.into(),
            what: what.to_string(),
        }),
        None => Ok(summary),
    }
}

/// The lane with a file for a publisher.
struct Lane {
    core: Core,
    settings: LaneSettings,
    writer: PosesWriter,
    hindsight: Hindsight,
    asked: WorldAxes,
    /// The world's axes, once there is a pose.
    axes: Option<Axes>,
    status: Status,
    /// The latest step that had a pose, and the world it is in.
    latest: Option<(SensorTime, Estimate, WorldStep)>,
    /// A reading of a magnetometer has come; its columns may be there and stay empty.
    has_magnetometer: bool,
}

impl Lane {
    fn new(
        loaded: &Loaded,
        args: &ReplayArgs,
        driver: &ReplayDriver,
        poses: &Path,
    ) -> Result<Self, ReplayCommandError> {
        let camera = recorded_camera(loaded);
        let calibration = calibration(loaded, &camera, args)?;
        Self::of(loaded, args, (&camera, calibration.as_ref()), driver, poses)
    }

    fn of(
        loaded: &Loaded,
        args: &ReplayArgs,
        (camera, calibration): (&Camera, Option<&Calibration>),
        driver: &ReplayDriver,
        poses: &Path,
    ) -> Result<Self, ReplayCommandError> {
        let rate_hz = driver.info().nominal_rate_hz;
        let config = with_preset(&loaded.config, args.preset);
        let settings = LaneSettings::new(&config, 0, camera, calibration, rate_hz)?;
        Ok(Self {
            core: Core::new(&settings),
            writer: PosesWriter::create(poses)?,
            hindsight: Hindsight::default(),
            asked: axes_of(loaded, args),
            axes: None,
            settings,
            status: Status::empty(),
            latest: None,
            has_magnetometer: false,
        })
    }

    /// The same as one of several cameras in a world.
    fn in_world(self, frame: Arc<WorldFrame>, camera: usize) -> Self {
        let membership = Membership::new(frame, camera, self.settings.member);
        Self { core: Core::in_world(&self.settings, membership), ..self }
    }

    /// What was found up to here.
    fn summary(&self, driver: &ReplayDriver, ring_dropped: u64) -> Summary {
        let counts = self.core.counts();
        Summary {
            rows: counts.readings,
            malformed: driver.counters().malformed,
            ring_dropped,
            counts,
            phase: self.core.phase(),
            has_magnetometer: self.has_magnetometer,
            speed_unused: driver.has_speed() && self.settings.estimator.vehicle.is_none(),
        }
    }

    /// One row for each reading, also for one that was refused; held back while there is no pose.
    fn take(&mut self, reading: &Reading) -> Result<(), PosesError> {
        self.has_magnetometer |= reading.mag.is_some();
        let (calibrated, resets) = (self.core.is_calibrated(), self.core.counts().resets);
        let (status, latest) = (&mut self.status, &mut self.latest);
        let taken = self.core.take(reading, |step: &StepOutput| {
            *status = status_of(step, calibrated);
            *latest = step.estimate.map(|estimate| (step.time, estimate, step.world));
        });
        let time = reading.sensor_time;
        let Some(estimate) = self.core.at_last_reading() else {
            if self.core.counts().resets != resets {
                self.give_up()?;
            }
            let sample = taken.refusal.is_none().then_some(taken.sample);
            let row = HeldRow { time, status: self.status, sample };
            return self.hindsight.hold(row).map_or(Ok(()), |row| self.write_held(row, None));
        };
        self.axes.get_or_insert_with(|| Axes::choose(self.asked, &estimate));
        self.look_back(&taken)?;
        self.write(time, Some(&estimate), self.status)
    }

    /// Writes the rows before the alignment.
    fn look_back(&mut self, taken: &Taken) -> Result<(), PosesError> {
        if self.hindsight.is_empty() {
            return Ok(());
        }
        let Some(back) = self.core.reversed() else { return self.give_up() };
        let rows = self.hindsight.look_back(back, &taken.sample, self.settings.grid);
        rows.into_iter().try_for_each(|(row, pose)| self.write_held(row, pose))
    }

    /// Writes the rows that no pose will come for.
    fn give_up(&mut self) -> Result<(), PosesError> {
        let rows: Vec<HeldRow> = self.hindsight.give_up().collect();
        rows.into_iter().try_for_each(|row| self.write_held(row, None))
    }

    fn write_held(&mut self, row: HeldRow, pose: Option<Estimate>) -> Result<(), PosesError> {
        let mut status = row.status;
        status.set(Status::INITIALISED, pose.is_some());
        status.set(Status::STATIONARY, pose.is_some_and(|pose| pose.at_rest));
        self.write(row.time, pose.as_ref(), status)
    }

    fn write(
        &mut self,
        time: SensorTime,
        pose: Option<&Estimate>,
        status: Status,
    ) -> Result<(), PosesError> {
        let row = pose_row(time, pose, status, &self.settings.validity);
        self.writer.write(&self.axes.map_or(row, |axes| axes.of_row(row)))
    }
}

/// The configuration with the preset that the command line asks for.
fn with_preset(config: &Config, asked: Option<PresetArg>) -> Config {
    let mut config = config.clone();
    config.estimator.preset = match asked {
        Some(PresetArg::Carried) => Preset::Carried,
        Some(PresetArg::Foot) => Preset::Foot,
        None => config.estimator.preset,
    };
    config
}

/// The world's axes that were asked for, or the preset's usual ones.
fn axes_of(loaded: &Loaded, args: &ReplayArgs) -> WorldAxes {
    let preset = with_preset(&loaded.config, args.preset).estimator.preset;
    args.frame.unwrap_or_else(|| usual_axes(preset))
}

/// Recordings of feet come in aerospace axes as often as not.
const fn usual_axes(preset: Preset) -> WorldAxes {
    match preset {
        Preset::Carried => WorldAxes::Enu,
        Preset::Foot => WorldAxes::Auto,
    }
}

/// The configuration's first replayed camera, whose axes, calibration and noise figures apply, or a
/// default one.
fn recorded_camera(loaded: &Loaded) -> Camera {
    let cameras = &loaded.config.camera;
    let configured = cameras.iter().find(|camera| camera.driver == DriverKind::Replay);
    configured
        .cloned()
        .unwrap_or_else(|| Camera { driver: DriverKind::Replay, ..Camera::default() })
}

/// The calibration that was asked for, else the configured one. A recording does not say which camera
/// made it: where neither the command line nor the configuration does, the file's word stands.
fn calibration(
    loaded: &Loaded,
    camera: &Camera,
    args: &ReplayArgs,
) -> Result<Option<Calibration>, LoadError> {
    let configured = (camera.serial != 0).then_some(camera.serial);
    let Some(file) = &args.calibration else {
        let camera = Camera { serial: args.serial.unwrap_or(camera.serial), ..camera.clone() };
        return loaded.calibration(&camera);
    };
    match args.serial.or(configured) {
        Some(serial) => Calibration::load(file, serial).map(Some),
        None => Calibration::load_any(file).map(Some),
    }
}

fn tell_speed_unused(recording: &Path) {
    tracing::warn!(
        "{}: its speed is not used: the configuration's replayed camera is on no vehicle \
         (camera.body, body.vehicle)",
        recording.display()
    );
}

fn tell(recording: &Path, s: &Summary) {
    let c = &s.counts;
    tracing::info!(
        rows = s.rows,
        malformed = s.malformed,
        dropped = s.ring_dropped,
        lost = c.lost,
        duplicates = c.duplicates,
        out_of_order = c.out_of_order,
        invalid = c.invalid,
        resets = c.resets,
        aiding_used = c.aiding_used,
        aiding_refused = c.aiding_refused,
        aiding_invalid = c.aiding_invalid,
        "{}",
        recording.display()
    );
    if s.speed_unused {
        tell_speed_unused(recording);
    }
    if let Phase::Aligning(waiting) = s.phase {
        tracing::warn!("{}: never aligned: {waiting}", recording.display());
    } else if !s.has_magnetometer {
        tracing::warn!("{}: no magnetometer: headings count from the start", recording.display());
    }
}
