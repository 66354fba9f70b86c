//! What the sensors of one camera make of the motion and the field: one file per sensor.

mod accelerometer;
mod axes;
mod flicker;
mod gyroscope;
mod inertial;
mod magnetometer;
mod quantiser;
mod thermometer;

use glam::DVec3;
use lodestone_config::model::{Camera, Synthetic};
use lodestone_fusion::{Accel, Body, Gyro, Mag, Sensor};

pub use axes::AxisMapError;

use accelerometer::Accelerometer;
use axes::SensorAxes;
use gyroscope::Gyroscope;
use magnetometer::Magnetometer;
use thermometer::Thermometer;

/// Temperature at which biases are stated, °C.
const REFERENCE_C: f64 = 25.0;

/// What one sample would read without any error, in the body frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stimulus {
    /// Time since the source began, s.
    pub(crate) time_s: f64,
    pub(crate) gyro: Gyro<Body>,
    pub(crate) accel: Accel<Body>,
    pub(crate) mag: Mag<Body>,
}

/// What one sample reads, in the sensor's axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measured {
    pub(crate) gyro: Gyro<Sensor>,
    pub(crate) accel: Accel<Sensor>,
    pub(crate) mag: Option<Mag<Sensor>>,
    pub(crate) temperature_c: f32,
    pub(crate) saturated: bool,
}

/// A vector with whether one of its axes is at the end of its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Digital {
    pub(crate) vector: DVec3,
    pub(crate) saturated: bool,
}

/// The sensors of one camera.
#[derive(Clone, Debug)]
pub(crate) struct SensorUnit {
    axes: SensorAxes,
    thermometer: Thermometer,
    gyroscope: Gyroscope,
    accelerometer: Accelerometer,
    magnetometer: Magnetometer,
}

impl SensorUnit {
    /// The sensors as configured, sampled at `rate_hz`.
    pub(crate) fn new(
        camera: &Camera,
        synthetic: &Synthetic,
        rate_hz: f64,
    ) -> Result<Self, AxisMapError> {
        let noise = camera.noise.unwrap_or_else(|| camera.model.noise());
        Ok(Self {
            axes: SensorAxes::new(camera.axes())?,
            thermometer: Thermometer::new(&synthetic.errors),
            gyroscope: Gyroscope::new(&noise, &synthetic.errors, synthetic.seed, rate_hz),
            accelerometer: Accelerometer::new(&noise, &synthetic.errors, synthetic.seed, rate_hz),
            magnetometer: Magnetometer::new(&noise, synthetic, rate_hz),
        })
    }

    /// Takes one sample: a point sample at the stimulus' instant, as the ZED 2 sends it.
    pub(crate) fn measure(&mut self, stimulus: &Stimulus) -> Measured {
        let temperature_c = self.thermometer.at(stimulus.time_s);
        let axes = self.axes;
        let sensed = |vector| axes.to_sensor(vector);
        let gyro = self.gyroscope.read(sensed(stimulus.gyro.vector), temperature_c);
        let accel = self.accelerometer.read(sensed(stimulus.accel.vector), temperature_c);
        let mag = self.magnetometer.read(sensed(stimulus.mag.vector), temperature_c);
        Measured {
            gyro: Gyro::new(gyro.vector),
            accel: Accel::new(accel.vector),
            mag: mag.map(|m| Mag::new(m.vector)),
            temperature_c: self.thermometer.read(temperature_c),
            saturated: gyro.saturated || accel.saturated || mag.is_some_and(|m| m.saturated),
        }
    }
}
