//! Each camera is calibrated before the run, as `lodestoned calibrate` does it: from a recording in which it is
//! turned by hand, with the same sensors and the same steel beside them.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use lodestone_calibration::{Outcome, Refusal, Sample, calibrate as fit};
use lodestone_config::model::{Config, Synthetic, TrajectoryKind};
use serde::Serialize;

use super::setup::is_silent;
use crate::commands::calibrate::{calibration_of, sample, settings_of};
use crate::evaluation::place::Place;
use crate::evaluation::recording::{Purpose, RecordingError, record};
use crate::reading::Reading;
use crate::service::signals::StopFlag;

/// How long each camera is turned, s.
const TURNED_S: f64 = 60.0;

/// The hands turn it about itself, not at the end of an arm: there, what presses it outward passes for a bias
/// of the accelerometer, m.
const ARM_M: f64 = 0.05;

/// Why a camera is not calibrated.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationError {
    /// The recording cannot be made, or somebody asked to stop.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The movement does not tell.
    #[error("camera {camera:?} cannot be calibrated: {refusal}")]
    Refused {
        /// The camera.
        camera: String,
        /// What is missing.
        refusal: Box<Refusal>,
    },
    /// The file cannot be written.
    #[error("{}: cannot be written: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}

/// What a calibration expects of itself.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Expected {
    /// The camera.
    pub camera: String,
    /// Standard deviation of the heading while the camera stands level, degrees.
    pub heading_sigma_deg: f64,
}

/// Calibrates the cameras, writes a file for each into the directory, and names it in the configuration.
///
/// # Errors
/// [`CalibrationError`].
pub fn calibrate_all(
    config: &mut Config,
    (seed, directory): (u64, &Path),
    stop: &StopFlag,
    mut begin: impl FnMut(&str),
) -> Result<Vec<Expected>, CalibrationError> {
    let mut expected = Vec::new();
    let mut known: Vec<(u64, Outcome)> = Vec::new();
    for index in 0..config.camera.len() {
        let place = place(config, index);
        let device = place.synthetic().seed;
        let found = known.iter().find(|(other, _)| *other == device).map(|(_, outcome)| outcome);
        let outcome = if let Some(outcome) = found {
            outcome.clone()
        } else {
            begin(&place.name);
            let outcome = calibrated(&place, seed, stop)?;
            known.push((device, outcome.clone()));
            expected.push(Expected {
                camera: place.name.clone(),
                heading_sigma_deg: outcome.magnetometer.level_heading_sigma_deg,
            });
            outcome
        };
        config.camera[index].calibration = Some(write(&place, &outcome, directory)?);
    }
    Ok(expected)
}

fn place(config: &Config, index: usize) -> Place {
    let camera = config.camera[index].clone();
    Place { name: camera.name.clone(), source: "demo".into(), camera, world: config.world.clone() }
}

fn calibrated(place: &Place, seed: u64, stop: &StopFlag) -> Result<Outcome, CalibrationError> {
    let turned = |synthetic: &mut Synthetic| {
        synthetic.trajectory = TrajectoryKind::Tumble;
        synthetic.duration_s = TURNED_S;
        synthetic.arm_m = ARM_M;
    };
    let mut readings: Vec<Reading> = Vec::new();
    record(place, (Purpose::Calibration, seed), turned, &mut readings, stop)?;
    let samples: Vec<Sample> = readings.iter().map(sample).collect();
    fit(&samples, &settings_of(&place.camera, Some(&place.world))).map_err(|refusal| {
        CalibrationError::Refused { camera: place.name.clone(), refusal: Box::new(refusal) }
    })
}

/// Writes the file; its name in the directory.
fn write(place: &Place, outcome: &Outcome, directory: &Path) -> Result<String, CalibrationError> {
    let mut calibration = calibration_of(place.camera.serial, None, outcome);
    if is_silent(&place.camera) {
        // What comes without a magnetometer has none that could be calibrated.
        calibration.magnetometer = None;
    }
    let name = format!("calibration-{}.toml", place.name);
    let path = directory.join(&name);
    let text = calibration.to_toml().map_err(io::Error::other);
    let written = text.and_then(|text| fs::write(&path, text));
    written.map(|()| name).map_err(|source| CalibrationError::Write { path, source })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::setup::{CAMERAS, drawn, without_magnetometer};
    use lodestone_config::Calibration;

    #[test]
    fn each_camera_is_calibrated_to_a_third_of_a_degree_and_its_twin_has_no_magnetometer() {
        let directory = tempfile::tempdir().unwrap();
        let mut config = drawn(Config::demo(), 1);
        let place = (1, directory.path());
        let expected = calibrate_all(&mut config, place, &StopFlag::new(), |_| {}).unwrap();
        let named: Vec<&str> = expected.iter().map(|e| e.camera.as_str()).collect();
        assert_eq!(named, CAMERAS);
        for Expected { camera, heading_sigma_deg } in &expected {
            assert!(*heading_sigma_deg < 0.33, "{camera}: {heading_sigma_deg}");
            let load = |name: &str| {
                let camera = config.camera.iter().find(|c| c.name == name).unwrap();
                let file = directory.path().join(camera.calibration.as_ref().unwrap());
                Calibration::load(file, camera.serial).unwrap()
            };
            let (own, twin) = (load(camera), load(&without_magnetometer(camera)));
            assert!(own.magnetometer.is_some() && twin.magnetometer.is_none());
            assert_eq!(own.accelerometer, twin.accelerometer);
        }
    }

    #[test]
    fn a_raised_flag_stops_it() {
        let stop = StopFlag::new();
        stop.raise();
        let directory = tempfile::tempdir().unwrap();
        let mut config = Config::demo();
        let stopped = calibrate_all(&mut config, (1, directory.path()), &stop, |_| {});
        assert!(matches!(stopped, Err(CalibrationError::Recording(RecordingError::Interrupted))));
    }
}
