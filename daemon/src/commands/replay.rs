//! `lodestoned replay`: recordings in, poses out, through the very lane that runs live.
//!
//! Driver, ring, grid and filter are those of a running daemon; only the clock is the recording's
//! and the poses go to files.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use lodestone_config::model::{Camera, DriverKind, Replay};
use lodestone_config::{Calibration, LoadError, Loaded};
use lodestone_schema::Status;

use crate::cli::ReplayArgs;
use crate::driver::replay::{ReplayDriver, ReplayError};
use crate::driver::{Driver, SourceState};
use crate::lane::{
    Core, CoreCounts, LaneSettings, Phase, SettingsError, StepOutput, pose_row, status_of,
};
use crate::poses_csv::{PosesError, PosesWriter};
use crate::reading::Reading;
use crate::ring::ring;
use crate::service::signals::StopFlag;

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
            Self::SameOutput(_) | Self::Calibration(_) => 2,
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
    let (counts, phase) = (lane.core.counts(), lane.core.phase());
    let has_magnetometer = lane.has_magnetometer;
    lane.writer.finish()?;
    match failure.get() {
        Some(what) => Err(ReplayCommandError::Broken {
            recording: recording.into(),
            poses: poses.into(),
            what: what.to_string(),
        }),
        None => Ok(Summary {
            rows: counts.readings,
            malformed: driver.counters().malformed,
            ring_dropped: producer.monitor().counters().dropped,
            counts,
            phase,
            has_magnetometer,
        }),
    }
}

/// The lane with a file for a publisher.
struct Lane {
    core: Core,
    settings: LaneSettings,
    writer: PosesWriter,
    status: Status,
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
        let rate_hz = driver.info().nominal_rate_hz;
        let settings =
            LaneSettings::new(&loaded.config, 0, &camera, calibration.as_ref(), rate_hz)?;
        let (core, writer) = (Core::new(&settings), PosesWriter::create(poses)?);
        Ok(Self { core, settings, writer, status: Status::empty(), has_magnetometer: false })
    }

    /// One row for each reading, also for one that was refused.
    fn take(&mut self, reading: &Reading) -> Result<(), PosesError> {
        self.has_magnetometer |= reading.mag.is_some();
        let status = &mut self.status;
        let calibrated = self.core.is_calibrated();
        self.core.take(reading, |step: &StepOutput| *status = status_of(step, calibrated));
        let estimate = self.core.at_last_reading();
        let bounds = &self.settings.validity;
        self.writer.write(&pose_row(reading.sensor_time, estimate.as_ref(), self.status, bounds))
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
        "{}",
        recording.display()
    );
    if let Phase::Aligning(waiting) = s.phase {
        tracing::warn!("{}: never aligned: {waiting}", recording.display());
    } else if !s.has_magnetometer {
        tracing::warn!("{}: no magnetometer: headings count from the start", recording.display());
    }
}
