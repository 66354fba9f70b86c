//! The magnetometer's readings of one recording, corrected and compared with the truth.

use glam::{DMat3, DVec3};
use lodestone_config::model::AxisMap;

use super::correction::Correction;
use super::statistics::{root_mean_square, standard_deviation};
use crate::driver::synthetic::{EarthField, TruthSource};
use crate::reading::Reading;

/// One reading of the magnetometer, as a correction leaves it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldReading {
    /// Time since the first sample, s.
    pub time_s: f64,
    /// The field in the body frame, µT.
    pub body_ut: DVec3,
    /// True heading of the camera's forward axis, clockwise from the world's north, 0 to 360°.
    pub heading_deg: f64,
    /// How far the field's horizontal part points from the true one's, under the true tilt, ±180°,
    /// clockwise positive: the error of a heading that rests on this reading.
    pub heading_error_deg: f64,
}

/// All readings of a recording, with one correction.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace(pub Vec<FieldReading>);

impl Trace {
    /// Corrects the readings of a recording. The truth is used for the score alone.
    pub fn of(
        readings: &[Reading],
        truth: &TruthSource,
        (axes, earth): (AxisMap, &EarthField),
        correction: &Correction,
    ) -> Self {
        let body_from_sensor = body_from_sensor(axes);
        let start = truth.start();
        let corrected = readings.iter().filter_map(|reading| {
            let temperature_c = reading.temperature_c.map(f64::from);
            let sensor_ut = correction.apply(reading.mag?.vector, temperature_c);
            let body_ut = body_from_sensor * sensor_ut;
            let orientation = truth.truth_at(reading.sensor_time).orientation;
            let seen = orientation.apply(body_ut);
            let error = compass_deg(seen) - compass_deg(earth.world_ut);
            Some(FieldReading {
                time_s: (reading.sensor_time - start).as_secs_f64(),
                body_ut,
                heading_deg: compass_deg(orientation.apply(DVec3::X)).rem_euclid(360.0),
                // A field that seems to lie too far clockwise makes the camera's heading too small.
                heading_error_deg: -wrapped_deg(error),
            })
        });
        Self(corrected.collect())
    }

    /// The paper's σ: the standard deviation of the field's norm, µT; `None` of fewer than two
    /// readings.
    pub fn norm_sigma_ut(&self) -> Option<f64> {
        let norms: Vec<f64> = self.0.iter().map(|r| r.body_ut.length()).collect();
        standard_deviation(&norms)
    }

    /// Root mean square of the heading's error, degrees; `None` of no readings.
    pub fn heading_rms_deg(&self) -> Option<f64> {
        let errors: Vec<f64> = self.0.iter().map(|r| r.heading_error_deg).collect();
        root_mean_square(&errors)
    }
}

/// The matrix that turns sensor coordinates into body coordinates.
pub(super) fn body_from_sensor(axes: AxisMap) -> DMat3 {
    DMat3::from_cols_array_2d(&axes.directions()).transpose()
}

/// Direction of a vector's horizontal part, clockwise from north, degrees.
fn compass_deg(world: DVec3) -> f64 {
    world.x.atan2(world.y).to_degrees()
}

/// The same angle in ±180°.
fn wrapped_deg(angle_deg: f64) -> f64 {
    (angle_deg + 180.0).rem_euclid(360.0) - 180.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::place::places;
    use crate::evaluation::recording::{Purpose, record};
    use crate::service::signals::StopFlag;
    use lodestone_config::model::{MagneticDistortion, SensorErrors};

    /// A perfect sensor in a car, with a distortion.
    fn trace(distortion: MagneticDistortion, correction: &Correction) -> Trace {
        let mut places = places(&[]).unwrap();
        let place = places.remove(2);
        let mut readings = Vec::new();
        let change = |synthetic: &mut lodestone_config::model::Synthetic| {
            synthetic.errors =
                SensorErrors { noise_scale: 0.0, quantise: false, ..SensorErrors::default() };
            synthetic.distortion = distortion;
            synthetic.motor.clear();
            synthetic.instrument.clear();
        };
        let purpose = (Purpose::Fresh(0), 1);
        let truth = record(&place, purpose, change, &mut readings, &StopFlag::new()).unwrap();
        let earth = EarthField::of(&place.world).unwrap();
        Trace::of(&readings, &truth, (place.camera.axes(), &earth), correction)
    }

    #[test]
    fn a_perfect_sensor_has_no_error() {
        let trace = trace(MagneticDistortion::default(), &Correction::NONE);
        assert!(trace.0.len() > 3900);
        assert!(trace.norm_sigma_ut().unwrap() < 1e-9);
        assert!(trace.heading_rms_deg().unwrap() < 0.01, "{:?}", trace.heading_rms_deg());
    }

    #[test]
    fn hard_iron_ahead_pulls_north_toward_the_camera() {
        // Sensor z is forward: 5 µT ahead, with the camera looking east, adds 5 µT to the east.
        let hard_iron =
            MagneticDistortion { hard_iron_ut: [0.0, 0.0, 5.0], ..MagneticDistortion::default() };
        let trace = trace(hard_iron, &Correction::NONE);
        let east = trace.0.iter().filter(|r| (r.heading_deg - 90.0).abs() < 3.0);
        let errors: Vec<f64> = east.map(|r| r.heading_error_deg).collect();
        assert!(!errors.is_empty());
        let horizontal = 21.0_f64;
        let expected = -(5.0_f64 / horizontal).atan().to_degrees();
        assert!(errors.iter().all(|e| (e - expected).abs() < 1.5), "{errors:?}");
    }

    #[test]
    fn angles_wrap_at_half_a_turn() {
        assert!((wrapped_deg(190.0) + 170.0).abs() < 1e-12);
        assert!((wrapped_deg(-350.0) - 10.0).abs() < 1e-12);
    }
}
