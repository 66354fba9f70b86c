//! Sensor axes to body axes, and the camera's calibration.

use glam::{DMat3, DVec3};
use lodestone_config::model::AxisMap;
use lodestone_config::{Calibration, GyroCalibration};
use lodestone_fusion::{Accel, Body, Gyro, ImuSample, Mag};

use crate::reading::Reading;

/// Turns readings into calibrated samples in the body frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Conditioner {
    /// A signed permutation: body coordinates of a vector given in sensor axes.
    body_from_sensor: DMat3,
    gyro: GyroModel,
    accel_bias: DVec3,
    magnetometer: Option<MagnetometerModel>,
    calibrated: bool,
}

/// rate = reading − bias − slope (T − T0).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct GyroModel {
    bias: DVec3,
    /// Zero where none was found.
    slope_per_kelvin: DVec3,
    reference_c: f64,
}

/// `B = C (B̃ − b0 − b1 (T − T0))` (the paper's eq:CalibrationMagnetometer, as maths.md reads it).
#[derive(Clone, Copy, Debug, PartialEq)]
struct MagnetometerModel {
    hard_iron: DVec3,
    slope_per_kelvin: DVec3,
    reference_c: f64,
    soft_iron: DMat3,
}

impl Conditioner {
    /// Takes an axis map and a calibration in sensor axes, where there is one.
    pub fn new(map: AxisMap, calibration: Option<&Calibration>) -> Self {
        let gyro = calibration.and_then(|c| c.gyro.as_ref());
        let accel = calibration.and_then(|c| c.accelerometer.as_ref());
        let magnetometer = calibration.and_then(|c| c.magnetometer.as_ref());
        Self {
            body_from_sensor: DMat3::from_cols_array_2d(&map.directions()).transpose(),
            gyro: gyro.map(GyroModel::new).unwrap_or_default(),
            accel_bias: accel.map_or(DVec3::ZERO, |a| a.bias_m_s2.into()),
            magnetometer: magnetometer.map(|m| MagnetometerModel {
                hard_iron: m.hard_iron_ut.into(),
                slope_per_kelvin: m.hard_iron_slope_ut_k.into(),
                reference_c: m.reference_temperature_c,
                soft_iron: DMat3::from_cols_array_2d(&m.soft_iron).transpose(),
            }),
            calibrated: calibration.is_some(),
        }
    }

    /// Whether a calibration of this camera is applied.
    pub const fn is_calibrated(&self) -> bool {
        self.calibrated
    }

    /// The reading in the body frame, calibrated.
    pub fn condition(&self, reading: &Reading) -> ImuSample {
        let turn = self.body_from_sensor;
        let temperature_c = reading.temperature_c.map(f64::from);
        let field = |raw: DVec3| self.magnetometer.map_or(raw, |m| m.field(raw, temperature_c));
        ImuSample {
            time: reading.sensor_time,
            gyro: Gyro::<Body>::new(turn * (reading.gyro.vector - self.gyro.bias(temperature_c))),
            accel: Accel::<Body>::new(turn * (reading.accel.vector - self.accel_bias)),
            mag: reading.mag.map(|m| Mag::<Body>::new(turn * field(m.vector))),
            saturated: reading.saturated,
        }
    }
}

impl GyroModel {
    fn new(gyro: &GyroCalibration) -> Self {
        Self {
            bias: gyro.bias_rad_s.into(),
            slope_per_kelvin: gyro.bias_slope_rad_s_k.map_or(DVec3::ZERO, DVec3::from),
            reference_c: gyro.reference_temperature_c,
        }
    }

    /// Without a temperature the reference temperature is the best guess.
    fn bias(&self, temperature_c: Option<f64>) -> DVec3 {
        let warmer = temperature_c.map_or(0.0, |t| t - self.reference_c);
        self.bias + self.slope_per_kelvin * warmer
    }
}

impl MagnetometerModel {
    /// Without a temperature the reference temperature is the best guess.
    fn field(&self, raw: DVec3, temperature_c: Option<f64>) -> DVec3 {
        let warmer = temperature_c.map_or(0.0, |t| t - self.reference_c);
        self.soft_iron * (raw - self.hard_iron - self.slope_per_kelvin * warmer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reading::{HostTime, RecordedAiding};
    use lodestone_config::{Date, MagnetometerCalibration};
    use lodestone_fusion::SensorTime;

    fn reading(accel: DVec3, mag: DVec3, temperature_c: f32) -> Reading {
        Reading {
            sensor_time: SensorTime::from_nanos(1),
            arrival: HostTime::from_nanos(1),
            gyro: Gyro::new(DVec3::ZERO),
            accel: Accel::new(accel),
            mag: Some(Mag::new(mag)),
            temperature_c: Some(temperature_c),
            saturated: false,
            aiding: RecordedAiding::NONE,
            epoch: 0,
        }
    }

    #[test]
    fn a_level_zed2_reads_gravity_upward() {
        let conditioner = Conditioner::new(AxisMap::default(), None);
        let sample = conditioner.condition(&reading(DVec3::new(-9.81, 0.0, 0.0), DVec3::X, 20.0));
        assert_eq!(sample.accel.vector, DVec3::new(0.0, 0.0, 9.81));
        assert_eq!(sample.mag.map(|m| m.vector), Some(DVec3::NEG_Z));
    }

    fn nothing() -> Calibration {
        Calibration {
            serial: 1,
            date: Date { year: 2026, month: 1, day: 1 },
            mounting: None,
            temperature: None,
            magnetometer: None,
            gyro: None,
            accelerometer: None,
        }
    }

    #[test]
    fn the_gyros_bias_follows_the_temperature() {
        let gyro = GyroCalibration {
            bias_rad_s: [0.01, -0.02, 0.03],
            bias_sigma_rad_s: None,
            bias_slope_rad_s_k: Some([1e-3, 0.0, -1e-3]),
            reference_temperature_c: 25.0,
        };
        let calibration = Calibration { gyro: Some(gyro), ..nothing() };
        let conditioner = Conditioner::new(AxisMap::IDENTITY, Some(&calibration));
        let at = |temperature_c: Option<f32>| {
            let reading = Reading { temperature_c, ..reading(DVec3::X, DVec3::X, 0.0) };
            conditioner.condition(&reading).gyro.vector
        };
        assert!((at(Some(35.0)) - DVec3::new(-0.02, 0.02, -0.02)).length() < 1e-12);
        assert!((at(None) - DVec3::new(-0.01, 0.02, -0.03)).length() < 1e-12);
    }

    #[test]
    fn the_magnetometer_model_is_undone() {
        let soft_iron = [[1.05, 0.02, -0.01], [0.02, 0.97, 0.03], [-0.01, 0.03, 1.01]];
        let magnetometer = MagnetometerCalibration {
            hard_iron_ut: [12.0, -30.0, 7.0],
            hard_iron_slope_ut_k: [0.1, 0.0, -0.2],
            reference_temperature_c: 25.0,
            soft_iron,
            heading_sigma_deg: None,
            level_heading_sigma_deg: None,
            residual_ut: None,
            field_ut: None,
            field_sigma_ut: None,
            dip_deg: None,
            dip_sigma_deg: None,
            covariance: None,
        };
        let calibration = Calibration { magnetometer: Some(magnetometer), ..nothing() };
        let conditioner = Conditioner::new(AxisMap::default(), Some(&calibration));
        let field = DVec3::new(20.0, -5.0, 44.0);
        let correction = DMat3::from_cols_array_2d(&soft_iron).transpose();
        let raw = correction.inverse() * field + DVec3::new(13.0, -30.0, 5.0);
        let sample = conditioner.condition(&reading(DVec3::X, raw, 35.0));
        let expected = DVec3::new(44.0, -5.0, -20.0);
        assert!((sample.mag.expect("there is one").vector - expected).length() < 1e-9);
    }
}
