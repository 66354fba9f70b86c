//! The IMU's temperature: an exponential warm-up.

use lodestone_config::model::SensorErrors;

/// Step of the reading, °C (zed2-protocol.md, report 0x01, offset 28).
const STEP_C: f64 = 0.01;

/// The warming IMU.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Thermometer {
    start_c: f64,
    end_c: f64,
    time_constant_s: f64,
    quantise: bool,
}

impl Thermometer {
    /// Warms as configured.
    pub(crate) const fn new(errors: &SensorErrors) -> Self {
        Self {
            start_c: errors.temperature_start_c,
            end_c: errors.temperature_end_c,
            time_constant_s: errors.temperature_time_constant_s,
            quantise: errors.quantise,
        }
    }

    /// True temperature at a time since the start, °C.
    pub(crate) fn at(&self, time_s: f64) -> f64 {
        if self.time_constant_s <= 0.0 {
            return self.end_c;
        }
        self.end_c + (self.start_c - self.end_c) * (-time_s.max(0.0) / self.time_constant_s).exp()
    }

    /// What the sensor says of a true temperature, °C.
    pub(crate) fn read(&self, temperature_c: f64) -> f32 {
        if self.quantise {
            ((temperature_c / STEP_C).round() * STEP_C) as f32
        } else {
            temperature_c as f32
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_warms_from_start_to_end() {
        let errors = SensorErrors {
            temperature_start_c: 20.0,
            temperature_end_c: 40.0,
            temperature_time_constant_s: 100.0,
            ..SensorErrors::default()
        };
        let thermometer = Thermometer::new(&errors);
        assert!((thermometer.at(0.0) - 20.0).abs() < 1e-12);
        assert!((thermometer.at(100.0) - (40.0 - 20.0 / std::f64::consts::E)).abs() < 1e-9);
        assert!((thermometer.at(1e6) - 40.0).abs() < 1e-9);
        assert!((thermometer.read(31.236) - 31.24).abs() < 1e-5);
    }
}
