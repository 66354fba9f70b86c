//! The Allan deviation of accelerometer and gyroscope at rest.

use glam::DMat3;
use lodestone_config::model::{Noise, TrajectoryKind};
use lodestone_fusion::SensorTime;
use serde::Serialize;

use super::allan::{AllanPoint, overlapping};
use super::place::Place;
use super::recording::{Purpose, RecordingError, record};
use super::statistics::{mean, standard_deviation};
use super::trace::body_from_sensor;
use crate::driver::Sink;
use crate::reading::Reading;
use crate::service::signals::StopFlag;

/// What a camera at rest shows.
#[derive(Clone, Debug, Serialize)]
pub struct Rest {
    /// Where.
    pub place: String,
    /// How long it was recorded, s.
    pub duration_s: f64,
    /// The noise figures that the synthetic sensors were given, which the curves should find.
    pub configured: Noise,
    /// Specific force in the body frame, m/s²; gravity is in it.
    pub accelerometer: AtRest,
    /// Angular rate in the body frame, rad/s; the earth's rate is in it.
    pub gyroscope: AtRest,
}

/// One sensor at rest, per body axis (forward, left, up).
#[derive(Clone, Debug, Serialize)]
pub struct AtRest {
    /// Mean: bias, and what a perfect sensor would read.
    pub mean: [Option<f64>; 3],
    /// Standard deviation of single samples.
    pub sigma: [Option<f64>; 3],
    /// Allan deviation.
    pub allan: [Vec<AllanPoint>; 3],
}

/// Records a place at rest for `duration_s` and looks at its noise.
///
/// # Errors
/// If the synthetic world cannot be made, or somebody asked to stop.
pub fn evaluate(
    place: &Place,
    seed: u64,
    duration_s: f64,
    stop: &StopFlag,
) -> Result<Rest, RecordingError> {
    let mut kept = Kept::new(body_from_sensor(place.camera.axes()));
    let at_rest = |synthetic: &mut lodestone_config::model::Synthetic| {
        synthetic.trajectory = TrajectoryKind::Standing;
        synthetic.duration_s = duration_s;
    };
    record(place, (Purpose::Rest, seed), at_rest, &mut kept, stop)?;
    let interval_s = kept.interval_s();
    Ok(Rest {
        place: place.name.clone(),
        duration_s,
        configured: place.camera.noise.unwrap_or_else(|| place.camera.model.noise()),
        accelerometer: AtRest::of(&kept.accel, interval_s),
        gyroscope: AtRest::of(&kept.gyro, interval_s),
    })
}

/// Keeps what is needed of an hour of samples.
struct Kept {
    body_from_sensor: DMat3,
    accel: [Vec<f64>; 3],
    gyro: [Vec<f64>; 3],
    span: Option<(SensorTime, SensorTime)>,
}

impl Kept {
    fn new(body_from_sensor: DMat3) -> Self {
        Self { body_from_sensor, accel: Default::default(), gyro: Default::default(), span: None }
    }

    /// Mean interval between samples, s; lost ones make it longer by their part.
    fn interval_s(&self) -> f64 {
        let intervals = self.gyro[0].len().saturating_sub(1).max(1);
        self.span.map_or(0.0, |(first, last)| (last - first).as_secs_f64() / intervals as f64)
    }
}

impl Sink for Kept {
    fn push(&mut self, reading: Reading) {
        let accel = (self.body_from_sensor * reading.accel.vector).to_array();
        let gyro = (self.body_from_sensor * reading.gyro.vector).to_array();
        for axis in 0..3 {
            self.accel[axis].push(accel[axis]);
            self.gyro[axis].push(gyro[axis]);
        }
        let first = self.span.map_or(reading.sensor_time, |(first, _)| first);
        self.span = Some((first, reading.sensor_time));
    }
}

impl AtRest {
    fn of(axes: &[Vec<f64>; 3], interval_s: f64) -> Self {
        Self {
            mean: [0, 1, 2].map(|axis| mean(&axes[axis])),
            sigma: [0, 1, 2].map(|axis| standard_deviation(&axes[axis])),
            allan: [0, 1, 2].map(|axis| overlapping(&axes[axis], interval_s, 8)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::allan::at;
    use crate::evaluation::place::places;
    use glam::DVec3;

    #[test]
    fn the_curves_find_the_densities_that_the_sensors_were_given() {
        let place = &places(&[]).unwrap()[1];
        let rest = evaluate(place, 1, 60.0, &StopFlag::new()).unwrap();
        let expected = [
            (&rest.accelerometer, rest.configured.accel_density_m_s2_rthz),
            (&rest.gyroscope, rest.configured.gyro_density_rad_s_rthz),
        ];
        for (sensor, density) in expected {
            for curve in &sensor.allan {
                let point = at(curve, 0.5).unwrap();
                let ratio = point.deviation * point.tau_s.sqrt() / density;
                assert!((ratio - 1.0).abs() < 0.25, "{ratio}");
            }
        }
        let gravity = rest.accelerometer.mean.map(Option::unwrap);
        assert!((DVec3::from_array(gravity).length() - 9.81).abs() < 0.2, "{gravity:?}");
    }
}
