//! Lodestone's own lane, fed with the same readings.

use lodestone_config::model::Config;
use lodestone_fusion::Estimate;

use super::run::Heard;
use super::track::{Track, TrackPoint};
use crate::lane::{Core, LaneSettings, Phase, SettingsError};

/// How the lane is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variant {
    /// Standstills count in the rest before the way; from there on the filter is on its own.
    Unaided,
    /// As shipped, without a calibration of the unit: a camera that stands has no velocity and no rate.
    AsShipped,
    /// As shipped, with the unit's calibration.
    Calibrated,
}

/// Why there are no poses.
#[derive(Debug, thiserror::Error)]
pub enum FilterError {
    /// The lane cannot be made.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The unit has no calibration.
    #[error("the unit's calibration was refused: {0}")]
    NotCalibrated(String),
    /// The filter was not aligned when the way began, or later.
    #[error("no pose {time_s:.1} s after the rest: {why}")]
    NoPose {
        /// Time since the end of the rest, s.
        time_s: f64,
        /// What it waits for.
        why: String,
    },
}

/// Poses of the lane at the instants, with the defaults of a configuration.
///
/// # Errors
/// [`FilterError`].
pub fn follow(heard: &Heard, variant: Variant) -> Result<Track, FilterError> {
    let mut core = Core::new(&settings(heard, variant)?);
    let mut asked = heard.instants.iter().copied().peekable();
    let mut track = Vec::with_capacity(heard.instants.len());
    for (k, reading) in heard.readings.iter().enumerate() {
        if k == heard.begin && variant == Variant::Unaided {
            core.ignore_standstills();
        }
        core.take(reading, |_| {});
        if asked.next_if_eq(&k).is_some() {
            let time_s = heard.time_s(k);
            let pose = core.at_last_reading().ok_or_else(|| no_pose(core.phase(), time_s))?;
            track.push(point(time_s, &pose));
        }
    }
    Ok(Track(track).from_its_start())
}

fn settings(heard: &Heard, variant: Variant) -> Result<LaneSettings, FilterError> {
    let config = Config {
        world: heard.world.clone(),
        camera: vec![heard.camera.clone()],
        ..Config::default()
    };
    let calibration = match (variant, &heard.calibration) {
        (Variant::Calibrated, Err(why)) => return Err(FilterError::NotCalibrated(why.clone())),
        (Variant::Calibrated, Ok(calibration)) => Some(calibration),
        _ => None,
    };
    Ok(LaneSettings::new(&config, 0, &heard.camera, calibration, heard.rate_hz)?)
}

fn no_pose(phase: Phase, time_s: f64) -> FilterError {
    let why = match phase {
        Phase::Aligning(waiting) => waiting.to_string(),
        Phase::Running => "the state is not finite".into(),
    };
    FilterError::NoPose { time_s, why }
}

const fn point(time_s: f64, pose: &Estimate) -> TrackPoint {
    TrackPoint { time_s, position_m: pose.position, orientation: pose.orientation }
}
