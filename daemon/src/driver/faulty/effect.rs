//! What faults do to the values and the stamp of one sample.

use glam::DVec3;
use lodestone_config::model::{Fault, FaultKind};
use lodestone_fusion::{Accel, Gyro, Mag, Sensor, SensorTime};

use crate::reading::Reading;

/// Huge enough that its square is not finite, small enough to be finite itself.
const HUGE: f64 = 1e200;

/// The ends of the ZED 2's ranges: 1000 °/s, 8 g, 2048 µT.
const GYRO_END_RAD_S: f64 = 1000.0 * std::f64::consts::PI / 180.0;
const ACCEL_END_M_S2: f64 = 8.0 * 9.8189;
const MAG_END_UT: f64 = 2048.0;

/// What each fault of a list remembers of the first sample it met.
pub(super) struct Effects {
    memories: Vec<Memory>,
}

#[derive(Clone, Copy, Default)]
struct Memory {
    values: Option<(Gyro<Sensor>, Accel<Sensor>, Option<f32>)>,
    mag: Option<Mag<Sensor>>,
    stamp: Option<SensorTime>,
}

impl Effects {
    pub(super) fn new(faults: &[Fault]) -> Self {
        Self { memories: vec![Memory::default(); faults.len()] }
    }

    /// Applies one fault of the list to a sample it meets.
    pub(super) fn apply(&mut self, index: usize, kind: FaultKind, reading: &mut Reading) {
        let memory = &mut self.memories[index];
        match kind {
            FaultKind::TimeBackwards => memory.run_backwards(reading),
            FaultKind::Stuck => memory.stick(reading),
            FaultKind::NotANumber => fill(reading, [f64::NAN; 3]),
            FaultKind::Infinite => fill(reading, [f64::INFINITY; 3]),
            FaultKind::Huge => fill(reading, [HUGE; 3]),
            FaultKind::Saturated => {
                fill(reading, [GYRO_END_RAD_S, ACCEL_END_M_S2, MAG_END_UT]);
                reading.saturated = true;
            }
            FaultKind::NoMagnetometer => reading.mag = None,
            // These act on the order and number of samples, not on one.
            FaultKind::Drop
            | FaultKind::Duplicate
            | FaultKind::Unplug
            | FaultKind::Stall
            | FaultKind::Reorder => {}
        }
    }
}

impl Memory {
    /// Mirrors the stamp at the first one the fault met.
    fn run_backwards(&mut self, reading: &mut Reading) {
        let first = *self.stamp.get_or_insert(reading.sensor_time);
        reading.sensor_time = first + (first - reading.sensor_time);
    }

    /// Repeats the first values; the magnetometer keeps its own rhythm.
    fn stick(&mut self, reading: &mut Reading) {
        let now = (reading.gyro, reading.accel, reading.temperature_c);
        (reading.gyro, reading.accel, reading.temperature_c) = *self.values.get_or_insert(now);
        if let Some(mag) = &mut reading.mag {
            *mag = *self.mag.get_or_insert(*mag);
        }
    }
}

/// Sets every axis of gyroscope, accelerometer and a new magnetometer reading.
fn fill(reading: &mut Reading, [gyro, accel, mag]: [f64; 3]) {
    reading.gyro = Gyro::new(DVec3::splat(gyro));
    reading.accel = Accel::new(DVec3::splat(accel));
    reading.mag = reading.mag.map(|_| Mag::new(DVec3::splat(mag)));
}
