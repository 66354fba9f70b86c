//! Noise and offset of accelerometer and gyroscope at rest: the paper's figure "Sensory Ground Truth".

use glam::DVec3;
use lodestone_fusion::ImuSample;
use serde::Serialize;

use super::dead_reckoning::{LOW_PASS_HZ, low_pass};
use super::run::Run;
use crate::evaluation::statistics::{mean, standard_deviation};

/// Length of the piece that is drawn, s.
const DRAWN_S: f64 = 4.0;

/// Both sensors at rest.
#[derive(Clone, Debug, Serialize)]
pub struct Noise {
    /// How long the camera was at rest, s.
    pub duration_s: f64,
    /// Cut-off of the low-pass behind `sigma_low_passed`, Hz.
    pub low_pass_hz: f64,
    /// Acceleration in body axes (forward, left, up), gravity taken off, m/s².
    pub acceleration: AtRest,
    /// Angular velocity in body axes, rad/s.
    pub angular_velocity: AtRest,
}

/// One sensor at rest, per body axis.
#[derive(Clone, Debug, Serialize)]
pub struct AtRest {
    /// Mean: what is there and should not be.
    pub offset: [f64; 3],
    /// Standard deviation of single samples.
    pub sigma: [f64; 3],
    /// The same after the low-pass.
    pub sigma_low_passed: [f64; 3],
    /// The first seconds, for the figure: time, s, and value.
    #[serde(skip)]
    pub drawn: Vec<(f64, DVec3)>,
}

impl Noise {
    /// Looks at a camera that stands all the time. Gravity and the earth's turn are taken off by the
    /// true attitude, so that what is left are the sensors' own errors. `None` of too few samples.
    pub fn of(run: &Run) -> Option<Self> {
        let samples = &run.heard.samples;
        let attitude = run.truth.0.first()?.orientation.inverse();
        let gravity = attitude.apply(DVec3::Z * 9.81);
        let mut filtered = samples.clone();
        low_pass(&mut filtered, run.heard.rate_hz);
        let accel = |sample: &ImuSample| sample.accel.vector - gravity;
        let gyro = |sample: &ImuSample| sample.gyro.vector;
        Some(Self {
            duration_s: (samples.last()?.time - samples.first()?.time).as_secs_f64(),
            low_pass_hz: LOW_PASS_HZ,
            acceleration: AtRest::of(samples, &filtered, &accel)?,
            angular_velocity: AtRest::of(samples, &filtered, &gyro)?,
        })
    }
}

impl AtRest {
    fn of(
        samples: &[ImuSample],
        filtered: &[ImuSample],
        value: &dyn Fn(&ImuSample) -> DVec3,
    ) -> Option<Self> {
        let start = samples.first()?.time;
        let per_axis = |of: &dyn Fn(&[f64]) -> Option<f64>, samples: &[ImuSample]| {
            let axis = |k: usize| of(&samples.iter().map(|s| value(s)[k]).collect::<Vec<_>>());
            Some([axis(0)?, axis(1)?, axis(2)?])
        };
        let timed = samples.iter().map(|s| ((s.time - start).as_secs_f64(), value(s)));
        Some(Self {
            offset: per_axis(&mean, samples)?,
            sigma: per_axis(&standard_deviation, samples)?,
            sigma_low_passed: per_axis(&standard_deviation, filtered)?,
            drawn: timed.take_while(|(time_s, _)| *time_s <= DRAWN_S).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::dynamic::unit::Unit;
    use crate::evaluation::place::dynamic_scenes;
    use crate::service::signals::StopFlag;

    #[test]
    fn offset_and_noise_are_those_that_the_sensors_were_given() {
        let scene = dynamic_scenes().unwrap().remove(0);
        // Sensor axes: x down, y left, z forward.
        let unit = Unit::with_biases(0, [-3e-3, 2e-3, 1e-3], [-0.03, 0.02, 0.01]);
        let run = Run::record(&scene, &unit, 1, &StopFlag::new()).unwrap();
        let noise = Noise::of(&run).unwrap();
        for (axis, expected) in [0.01, 0.02, 0.03].into_iter().enumerate() {
            let found = noise.acceleration.offset[axis];
            assert!((found - expected).abs() < 0.004, "{axis}: {found}");
            let found = noise.angular_velocity.offset[axis];
            assert!((found - 0.1 * expected).abs() < 2.5e-4, "{axis}: {found}");
            // A sample of white noise has its density times the root of the rate.
            let sigma = 1.6e-3 * 400.0_f64.sqrt();
            assert!((noise.acceleration.sigma[axis] / sigma - 1.0).abs() < 0.1);
            assert!(noise.acceleration.sigma_low_passed[axis] < 0.4 * sigma);
        }
        assert!((noise.acceleration.drawn.len() as f64 - 400.0 * DRAWN_S).abs() < 30.0);
    }
}
