//! A recording as movement.

use std::path::Path;

use lodestone_calibration::Sample;
use lodestone_config::Loaded;
use lodestone_config::model::{Camera, DriverKind};

use super::{CalibrateError, Movement, settings};
use crate::recording::{Recording, Row};

/// The serial that was given, else that of the configuration's replayed camera.
pub(super) fn serial(loaded: &Loaded, given: Option<u64>) -> Option<u64> {
    given.or_else(|| Some(replayed(loaded)?.serial).filter(|&serial| serial != 0))
}

fn replayed(loaded: &Loaded) -> Option<&Camera> {
    loaded.config.camera.iter().find(|camera| camera.driver == DriverKind::Replay)
}

/// Every good row.
pub(super) fn movement(
    loaded: &Loaded,
    configured: bool,
    path: &Path,
    serial: u64,
) -> Result<Movement, CalibrateError> {
    let mut recording = Recording::open(path)?;
    let (mut samples, mut malformed) = (Vec::new(), 0_u64);
    while let Some(row) = recording.next_row() {
        match row {
            Ok(row) => samples.push(sample(&row)),
            Err(error) if error.is_fatal() => {
                let what = error.to_string();
                return Err(CalibrateError::Broken { rows: samples.len(), what });
            }
            Err(error) => {
                malformed += 1;
                tracing::debug!("{error}");
            }
        }
    }
    if malformed > 0 {
        tracing::warn!("{}: {malformed} rows cannot be read and are left out", path.display());
    }
    let default = Camera { driver: DriverKind::Replay, ..Camera::default() };
    let camera = replayed(loaded).unwrap_or(&default);
    let world = configured.then_some(&loaded.config.world);
    Ok(Movement { serial, samples, settings: settings::of(camera, world) })
}

fn sample(row: &Row) -> Sample {
    Sample {
        time_ns: row.time.as_nanos(),
        gyro_rad_s: row.gyro.vector,
        accel_m_s2: row.accel.vector,
        mag_ut: row.mag.map(|mag| mag.vector),
        temperature_c: row.temperature_c.map(f64::from),
    }
}
