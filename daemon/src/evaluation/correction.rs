//! What a calibration makes of a reading of the magnetometer.

use glam::{DMat3, DVec3};
use lodestone_calibration::Outcome;

/// The paper's eq:CalibrationMagnetometer, as maths.md reads it: `B = C (B̃ − b₀ − b₁ (T − T₀))`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correction {
    soft_iron: DMat3,
    hard_iron_ut: DVec3,
    slope_ut_k: DVec3,
    reference_c: f64,
}

impl Correction {
    /// Readings as they come.
    pub const NONE: Self = Self {
        soft_iron: DMat3::IDENTITY,
        hard_iron_ut: DVec3::ZERO,
        slope_ut_k: DVec3::ZERO,
        reference_c: 0.0,
    };

    /// What a calibration found.
    pub fn of(outcome: &Outcome) -> Self {
        let magnetometer = &outcome.magnetometer;
        let slope = magnetometer.hard_iron_slope_ut_k.zip(outcome.temperature);
        Self {
            soft_iron: magnetometer.soft_iron,
            hard_iron_ut: magnetometer.hard_iron_ut,
            slope_ut_k: slope.map_or(DVec3::ZERO, |(slope, _)| slope),
            reference_c: slope.map_or(0.0, |(_, span)| span.reference_c),
        }
    }

    /// The field of a reading, µT, in the same axes. Without a temperature the slope is left aside.
    pub fn apply(&self, reading_ut: DVec3, temperature_c: Option<f64>) -> DVec3 {
        let warm = temperature_c.map_or(DVec3::ZERO, |t| self.slope_ut_k * (t - self.reference_c));
        self.soft_iron * (reading_ut - self.hard_iron_ut - warm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_undoes_the_distortion_that_it_describes() {
        let distortion =
            DMat3::from_cols_array_2d(&[[1.1, 0.1, 0.0], [0.0, 0.9, 0.0], [0.05, 0.0, 1.0]]);
        let (hard_iron, slope) = (DVec3::new(10.0, -20.0, 5.0), DVec3::new(0.1, 0.0, -0.2));
        let correction = Correction {
            soft_iron: distortion.inverse(),
            hard_iron_ut: hard_iron,
            slope_ut_k: slope,
            reference_c: 25.0,
        };
        let field = DVec3::new(20.0, 3.0, -43.0);
        let reading = distortion * field + hard_iron + slope * 7.0;
        assert!((correction.apply(reading, Some(32.0)) - field).length() < 1e-12);
        assert_eq!(Correction::NONE.apply(reading, Some(32.0)), reading);
    }
}
