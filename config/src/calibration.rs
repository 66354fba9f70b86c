//! The calibration file of one camera.
//!
//! All vectors are in the sensor's own axes, before [`crate::model::AxisMap`]. A part that was not
//! calibrated is absent; it is not zero.

use std::path::Path;

use serde::{Deserialize, Serialize};
pub use toml::value::Date;

use crate::check::Report;
use crate::error::LoadError;
use crate::load::read_text;

/// What was found out about one camera's sensors, on one day, in one mounting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Serial number of the camera.
    pub serial: u64,
    /// Day of the calibration.
    pub date: Date,
    /// How the camera was mounted; the magnetometer's part holds for this mounting alone.
    pub mounting: Option<String>,
    /// Range of the sensor's temperature during the calibration.
    pub temperature: Option<TemperatureRange>,
    /// Magnetometer.
    pub magnetometer: Option<MagnetometerCalibration>,
    /// Gyroscope.
    pub gyro: Option<GyroCalibration>,
    /// Accelerometer.
    pub accelerometer: Option<AccelerometerCalibration>,
}

/// A range of temperature.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TemperatureRange {
    /// Lowest, °C.
    pub min_c: f64,
    /// Highest, °C.
    pub max_c: f64,
}

/// The magnetometer's model: `B = C (B̃ − b0 − b1 (T − T0))` turns a reading `B̃` at temperature
/// `T` into the field `B`, both in the sensor frame, µT (eq:CalibrationMagnetometer of the paper).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MagnetometerCalibration {
    /// Hard iron `b0`, µT.
    pub hard_iron_ut: [f64; 3],
    /// Change of the hard iron per kelvin `b1`, µT/K.
    #[serde(default)]
    pub hard_iron_slope_ut_k: [f64; 3],
    /// Reference temperature `T0`, °C.
    #[serde(default = "reference_temperature_c")]
    pub reference_temperature_c: f64,
    /// Correction of soft iron `C`, row by row; its determinant is positive.
    pub soft_iron: [[f64; 3]; 3],
    /// Standard deviation of the heading that this calibration leaves, over the tilts it was made
    /// with and all headings, degrees; unknown if absent.
    pub heading_sigma_deg: Option<f64>,
    /// The same for a level camera, degrees.
    pub level_heading_sigma_deg: Option<f64>,
    /// What the calibration left of one reading, root mean square per axis, µT.
    pub residual_ut: Option<f64>,
    /// Strength of the earth's field as found, µT; its scale is that of the readings.
    pub field_ut: Option<f64>,
    /// Its standard deviation, µT.
    pub field_sigma_ut: Option<f64>,
    /// Dip of the earth's field as found, degrees, positive downward.
    pub dip_deg: Option<f64>,
    /// Its standard deviation, degrees.
    pub dip_sigma_deg: Option<f64>,
    /// Covariance of `C` row by row, of `b0`, µT, and of `b1`, µT/K, if that was found: 12 or 15
    /// rows of as many numbers.
    pub covariance: Option<Vec<Vec<f64>>>,
}

const fn reference_temperature_c() -> f64 {
    25.0
}

/// The gyroscope's model: rate = reading − bias − slope (T − T0).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GyroCalibration {
    /// Bias at `T0`, rad/s.
    pub bias_rad_s: [f64; 3],
    /// Its standard deviation, rad/s.
    pub bias_sigma_rad_s: Option<[f64; 3]>,
    /// Change of the bias per kelvin, rad/s/K; unknown, and not applied, if absent.
    pub bias_slope_rad_s_k: Option<[f64; 3]>,
    /// Reference temperature `T0`, °C.
    #[serde(default = "reference_temperature_c")]
    pub reference_temperature_c: f64,
}

/// The accelerometer's model: specific force = reading − bias.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AccelerometerCalibration {
    /// Bias, m/s²; near zero along a direction that the movement did not show.
    pub bias_m_s2: [f64; 3],
    /// Its standard deviation, m/s²; large along a direction that the movement did not show.
    pub bias_sigma_m_s2: Option<[f64; 3]>,
}

impl Calibration {
    /// Loads the calibration of the camera with a serial number.
    ///
    /// # Errors
    ///
    /// The file cannot be read, something in it is wrong, or it belongs to another camera.
    pub fn load(path: impl AsRef<Path>, expected_serial: u64) -> Result<Self, LoadError> {
        let path = path.as_ref();
        let calibration = Self::load_any(path)?;
        if calibration.serial == expected_serial {
            return Ok(calibration);
        }
        Err(LoadError::OtherCamera {
            path: path.into(),
            found: calibration.serial,
            expected: expected_serial,
        })
    }

    /// Loads a calibration of whichever camera, where nothing says which one made the data.
    ///
    /// # Errors
    ///
    /// The file cannot be read, or something in it is wrong.
    pub fn load_any(path: impl AsRef<Path>) -> Result<Self, LoadError> {
        let path = path.as_ref();
        Ok(Self::from_toml(&path.display().to_string(), &read_text(path)?)?)
    }

    /// The calibration as the text of its file.
    ///
    /// # Errors
    ///
    /// The serial number is above [`i64::MAX`], which TOML cannot write.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }
}

/// Checks the rules between keys.
pub(crate) fn check(calibration: &Calibration, report: &mut Report) {
    if let Some(range) = calibration.temperature.filter(|range| range.min_c > range.max_c) {
        let problem = format!("{} is above max_c, {}", range.min_c, range.max_c);
        let others = ["temperature.max_c"];
        report.conflict("temperature.min_c", &others, problem, "at most temperature.max_c");
    }
    check_covariance(calibration, report);
    let parts = [
        calibration.magnetometer.is_some(),
        calibration.gyro.is_some(),
        calibration.accelerometer.is_some(),
    ];
    if parts == [false; 3] {
        let allowed = "at least one of the tables [magnetometer], [gyro], [accelerometer]";
        report.conflict("magnetometer", &[], "nothing is calibrated".into(), allowed);
    }
}

/// The covariance has rows for the slope exactly where the file has one.
fn check_covariance(calibration: &Calibration, report: &mut Report) {
    let Some(magnetometer) = &calibration.magnetometer else { return };
    let Some(covariance) = &magnetometer.covariance else { return };
    let has_slope = magnetometer.hard_iron_slope_ut_k.iter().any(|slope| *slope != 0.0);
    if has_slope && covariance.len() != 15 {
        let problem = format!("has {} rows, and hard_iron_slope_ut_k is there", covariance.len());
        let others = ["magnetometer.hard_iron_slope_ut_k"];
        report.conflict("magnetometer.covariance", &others, problem, "15 rows");
    }
}
