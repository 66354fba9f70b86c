//! `lodestoned calibrate`: movement in, calibration file out.
//!
//! ```text
//! camera ──> Collector ─┐  guidance each second
//! recording ────────────┴> samples ─> lodestone_calibration ─> Outcome ─> file, or Refusal
//! ```

mod file;
mod guidance;
mod live;
mod recorded;
mod settings;

use std::io::{self, Write};
use std::path::Path;

use lodestone_calibration::{Outcome, Refusal, Sample, calibrate as fit};
use lodestone_config::Loaded;

use crate::cli::CalibrateArgs;
use crate::recording::RecordingError;
use crate::service::instance::InstanceError;
use crate::source::SourceError;
pub use file::WriteError;
pub use guidance::Guidance;
// What is evaluated and shown is this command's calibration, not one that resembles it.
pub(crate) use file::calibration_of;
pub(crate) use live::sample;
pub(crate) use settings::of as settings_of;

/// Why there is no calibration.
#[derive(Debug, thiserror::Error)]
pub enum CalibrateError {
    /// The camera to calibrate is not configured.
    #[error("--camera {serial}: no camera of the configuration has this serial; it has: {known}")]
    UnknownCamera {
        /// As given.
        serial: u64,
        /// Serials of the configuration.
        known: String,
    },
    /// A recording does not say which camera made it.
    #[error(
        "--serial is missing: a calibration is bound to one camera; allowed: a whole number from 1"
    )]
    NoSerial,
    /// A daemon has the cameras.
    #[error("the cameras are taken: {0}")]
    Taken(InstanceError),
    /// The camera cannot be opened.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The recording ends in the middle.
    #[error("{what}; {rows} rows were read")]
    Broken {
        /// Rows before.
        rows: usize,
        /// What is wrong.
        what: String,
    },
    /// Signals cannot be handled.
    #[error("cannot handle signals: {0}")]
    Signals(io::Error),
    /// The thread that reads the camera did not start, or panicked.
    #[error("cannot read the camera: {0}")]
    Collector(String),
    /// The movement does not tell.
    #[error("no calibration: {0}")]
    Refused(Box<Refusal>),
    /// The file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl CalibrateError {
    /// 2 where the command line is to blame, else 1.
    pub const fn exit_code(&self) -> u8 {
        match self {
            Self::UnknownCamera { .. } | Self::NoSerial => 2,
            Self::Write(e) => e.exit_code(),
            _ => 1,
        }
    }
}

/// What was collected, and of which camera.
struct Movement {
    serial: u64,
    samples: Vec<Sample>,
    settings: lodestone_calibration::Settings,
}

/// Calibrates a camera live, or from a recording.
///
/// `configured` says whether the configuration is the user's: the embedded one knows nothing of the
/// place.
///
/// # Errors
/// [`CalibrateError`]; no file is written then.
pub fn calibrate(
    loaded: &Loaded,
    configured: bool,
    args: &CalibrateArgs,
    guidance: Guidance,
) -> Result<(), CalibrateError> {
    let serial = match (&args.recording, args.camera) {
        (None, Some(serial)) => serial,
        _ => recorded::serial(loaded, args.serial).ok_or(CalibrateError::NoSerial)?,
    };
    let out = args.out.clone().unwrap_or_else(|| format!("calibration-{serial}.toml").into());
    // Before anybody turns a camera for two minutes.
    file::ensure_free(&out, args.force)?;
    let movement = match &args.recording {
        Some(recording) => recorded::movement(loaded, configured, recording, serial)?,
        None => live::movement(loaded, configured, serial, args, guidance)?,
    };
    let attempt = fit(&movement.samples, &movement.settings);
    if args.json {
        say(&format!("{}\n", file::json(movement.serial, &attempt)));
    }
    let outcome = attempt.map_err(|refusal| CalibrateError::Refused(Box::new(refusal)))?;
    file::write(&out, args, movement.serial, &outcome)?;
    tell(&out, &outcome);
    Ok(())
}

fn tell(out: &Path, outcome: &Outcome) {
    let m = &outcome.magnetometer;
    tracing::info!(
        "{}: heading σ {:.2}° over the tilts seen, {:.2}° level; {:.1} turns, tilt {:.1}°",
        out.display(),
        m.heading_sigma_deg,
        m.level_heading_sigma_deg,
        outcome.coverage.turns,
        outcome.coverage.tilt_deg,
    );
}

fn say(text: &str) {
    // A reader that went away does not make the calibration worse.
    let _ = io::stdout().write_all(text.as_bytes());
}
