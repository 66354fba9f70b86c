//! Real recordings with a truth: orientation as BROAD scores it, position in the plane as walks with
//! motion capture are scored.
//!
//! The lane sees the recording's samples; what was measured beside them is read for the score alone.

use std::path::{Path, PathBuf};
use std::time::Duration;

use glam::{DQuat, DVec2};
use lodestone_config::model::{Camera, Config, DriverKind, Preset, Replay};
use lodestone_fusion::{Estimate, SensorTime};
use serde::Serialize;

use super::track::wrapped_deg;
use crate::cli::WorldAxes;
use crate::driver::replay::{ReplayDriver, ReplayError};
use crate::driver::{Driver, SourceState};
use crate::evaluation::statistics::root_mean_square;
use crate::lane::{Core, LaneSettings, SettingsError};
use crate::pose_axes::Axes;
use crate::reading::Reading;
use crate::recording::RecordingError;
use crate::recording::truth::{self, TruthRow};
use crate::service::signals::StopFlag;

/// Why a recording cannot be evaluated.
#[derive(Debug, thiserror::Error)]
pub enum RecordedError {
    /// It cannot be opened.
    #[error(transparent)]
    Open(#[from] ReplayError),
    /// Its truth cannot be read.
    #[error(transparent)]
    Truth(#[from] RecordingError),
    /// The lane cannot be made.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// It ends in the middle.
    #[error("{}: {what}", path.display())]
    Broken {
        /// The recording.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// There is nothing to compare with.
    #[error(
        "{}: no row with a truth and a pose; allowed: recordings with columns qw qx qy qz, or px py, in \
         which the camera is aligned", .0.display()
    )]
    NothingToScore(PathBuf),
    /// SIGINT or SIGTERM.
    #[error("interrupted; nothing was written")]
    Interrupted,
}

/// How right the poses of a recording are.
#[derive(Clone, Debug, Serialize)]
pub struct Recorded {
    /// The file's name.
    pub name: String,
    /// Its length, s.
    pub duration_s: f64,
    /// Orientation, where the recording has a true one.
    pub orientation: Option<OrientationScore>,
    /// Position, where it has no true orientation.
    pub position: Option<PositionScore>,
}

/// Root mean square errors over the scored rows (Laidig et al. 2021, BROAD).
#[derive(Clone, Debug, Serialize)]
pub struct OrientationScore {
    /// Angle of the whole error, degrees.
    pub total_deg: f64,
    /// Its part about the vertical, degrees.
    pub heading_deg: f64,
    /// The rest: roll and pitch, degrees.
    pub inclination_deg: f64,
    /// For the figure: time, s, heading and inclination, degrees.
    #[serde(skip)]
    pub drawn: Vec<(f64, f64, f64)>,
}

/// Errors in the plane after start and direction are laid on the truth's.
#[derive(Clone, Debug, Serialize)]
pub struct PositionScore {
    /// Root mean square over the walk, m.
    pub rms_m: f64,
    /// At the end, m.
    pub end_m: f64,
    /// Length of the true way, m.
    pub way_m: f64,
    /// For the figure: calculated and true position, m.
    #[serde(skip)]
    pub drawn: Vec<(DVec2, DVec2)>,
}

/// A pose with the truth of its row.
struct Pair {
    time_s: f64,
    estimate: Estimate,
    truth: TruthRow,
}

/// Replays a recording through the lane and scores its poses.
///
/// # Errors
/// [`RecordedError`].
pub fn evaluate(path: &Path, preset: Preset, stop: &StopFlag) -> Result<Recorded, RecordedError> {
    let truth = truth::read(path)?;
    let (readings, rate_hz) = readings(path, stop)?;
    let poses = poses(&readings, preset, rate_hz)?;
    let pairs = pairs(&poses, &truth);
    let orientation = orientation(&pairs);
    let position = if orientation.is_none() { position(&pairs) } else { None };
    if orientation.is_none() && position.is_none() {
        return Err(RecordedError::NothingToScore(path.to_path_buf()));
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let name = name.trim_end_matches(".zst").trim_end_matches(".csv").to_owned();
    let ends = readings.first().zip(readings.last());
    let duration_s = ends.map_or(0.0, |(a, b)| (b.sensor_time - a.sensor_time).as_secs_f64());
    Ok(Recorded { name, duration_s, orientation, position })
}

fn readings(path: &Path, stop: &StopFlag) -> Result<(Vec<Reading>, f64), RecordedError> {
    let file = path.to_string_lossy().into_owned();
    let mut driver =
        ReplayDriver::open(&Replay { file, speed: 0.0, repeat: false }, Path::new(""))?;
    let failure = driver.failure();
    let mut readings: Vec<Reading> = Vec::new();
    while driver.poll(Duration::ZERO, &mut readings) != SourceState::Ended {
        if stop.is_raised() {
            return Err(RecordedError::Interrupted);
        }
    }
    match failure.get() {
        Some(what) => {
            Err(RecordedError::Broken { path: path.to_path_buf(), what: what.to_string() })
        }
        None => Ok((readings, driver.info().nominal_rate_hz)),
    }
}

/// The lane's poses, each at its reading; none before the alignment.
fn poses(
    readings: &[Reading],
    preset: Preset,
    rate_hz: f64,
) -> Result<Vec<(SensorTime, Estimate)>, SettingsError> {
    let camera = Camera { driver: DriverKind::Replay, ..Camera::default() };
    let mut config = Config { camera: vec![camera.clone()], ..Config::default() };
    config.estimator.preset = preset;
    let mut core = Core::new(&LaneSettings::new(&config, 0, &camera, None, rate_hz)?);
    let pose = |reading: &Reading| {
        core.take(reading, |_| {});
        Some((reading.sensor_time, core.at_last_reading()?))
    };
    Ok(readings.iter().filter_map(pose).collect())
}

/// Poses and truths of one time stamp; both come in its order.
fn pairs(poses: &[(SensorTime, Estimate)], truth: &[TruthRow]) -> Vec<Pair> {
    let Some(start) = truth.first().map(|row| row.time) else { return Vec::new() };
    let pair = |row: &TruthRow| {
        let found = poses.binary_search_by_key(&row.time, |(time, _)| *time).ok()?;
        let time_s = (row.time - start).as_secs_f64();
        Some(Pair { time_s, estimate: poses[found].1, truth: *row })
    };
    truth.iter().filter_map(pair).collect()
}

fn orientation(pairs: &[Pair]) -> Option<OrientationScore> {
    let scored = pairs.iter().filter(|pair| pair.truth.is_scored);
    let errors: Vec<(f64, [f64; 3])> = scored
        .filter_map(|pair| {
            let error =
                pair.estimate.orientation.quaternion() * pair.truth.orientation?.conjugate();
            Some((pair.time_s, parts_deg(error)))
        })
        .collect();
    let rms =
        |k: usize| root_mean_square(&errors.iter().map(|(_, parts)| parts[k]).collect::<Vec<_>>());
    Some(OrientationScore {
        total_deg: rms(0)?,
        heading_deg: rms(1)?,
        inclination_deg: rms(2)?,
        drawn: errors
            .iter()
            .map(|(time_s, [_, heading, level])| (*time_s, *heading, *level))
            .collect(),
    })
}

/// Angle, signed part about the vertical, and the rest of an error in the world, degrees.
fn parts_deg(error: DQuat) -> [f64; 3] {
    let total = 2.0 * error.w.abs().min(1.0).acos();
    let heading = 2.0 * error.z.atan2(error.w);
    let inclination = 2.0 * error.w.hypot(error.z).min(1.0).acos();
    [total.to_degrees(), wrapped_deg(heading.to_degrees()), inclination.to_degrees()]
}

fn position(pairs: &[Pair]) -> Option<PositionScore> {
    let axes = Axes::choose(WorldAxes::Auto, &pairs.first()?.estimate);
    let ways: Vec<(DVec2, DVec2)> = pairs
        .iter()
        .filter_map(|pair| {
            let p = pair.estimate.position.truncate();
            let p = if axes == Axes::EastNorthUp { p } else { DVec2::new(p.y, p.x) };
            Some((p, pair.truth.position_m?))
        })
        .collect();
    let (first_ours, first_true) = *ways.first()?;
    let ways: Vec<_> = ways.iter().map(|(a, b)| (*a - first_ours, *b - first_true)).collect();
    // The turn that lays one way on the other with the least squares.
    let sine: f64 = ways.iter().map(|(a, b)| a.perp_dot(*b)).sum();
    let cosine: f64 = ways.iter().map(|(a, b)| a.dot(*b)).sum();
    let turn = DVec2::from_angle(sine.atan2(cosine));
    let drawn: Vec<_> = ways.iter().map(|(a, b)| (turn.rotate(*a), *b)).collect();
    let errors: Vec<f64> = drawn.iter().map(|(a, b)| a.distance(*b)).collect();
    Some(PositionScore {
        rms_m: root_mean_square(&errors)?,
        end_m: *errors.last()?,
        way_m: drawn.windows(2).map(|w| w[0].1.distance(w[1].1)).sum(),
        drawn,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_split_as_broad_does() {
        let [total, heading, level] = parts_deg(DQuat::from_rotation_z(0.2));
        assert!((total - 0.2_f64.to_degrees()).abs() < 1e-6, "{total}");
        assert!((heading - 0.2_f64.to_degrees()).abs() < 1e-9 && level < 1e-5);
        let [total, heading, level] = parts_deg(-DQuat::from_rotation_x(-0.3));
        assert!((total - level).abs() < 1e-9 && heading.abs() < 1e-9);
        assert!((level - 0.3_f64.to_degrees()).abs() < 1e-6, "{level}");
    }
}
