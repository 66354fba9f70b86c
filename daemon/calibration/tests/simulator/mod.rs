//! A sensor unit that is turned, for the yardstick and the tests: written apart from the fit, it
//! shares no formula with it.

pub mod motion;
pub mod unit;

use glam::{DMat3, DQuat, DVec3};
use lodestone_calibration::{Outcome, Sample};

pub use motion::{Motion, Tilt};
pub use unit::Unit;

/// What a simulated recording is made of.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    /// How it is tilted.
    pub tilt: Tilt,
    /// Rate of gyroscope and accelerometer, Hz.
    pub rate_hz: f64,
    /// Samples between two readings of the magnetometer.
    pub mag_every: usize,
    /// Duration, s.
    pub duration_s: f64,
    /// Whole turns.
    pub turns: f64,
    /// Rest at the beginning, s.
    pub rest_s: f64,
    /// The gyroscope's samples are means over their interval, not point samples.
    pub mean_rate: bool,
    /// Scales the noise of gyroscope and accelerometer.
    pub noise_scale: f64,
    /// Noise of the magnetometer, µT.
    pub mag_sigma_ut: f64,
}

impl Scene {
    /// The yardstick: 50 Hz, 120 s, four turns, 0.5 µT.
    pub const fn yardstick(tilt: Tilt) -> Self {
        Self {
            tilt,
            rate_hz: 50.0,
            mag_every: 1,
            duration_s: 120.0,
            turns: 4.0,
            rest_s: 0.0,
            mean_rate: false,
            noise_scale: 1.0,
            mag_sigma_ut: 0.5,
        }
    }

    /// One recording and the unit it was made with.
    pub fn draw(&self, seed: u64) -> (Vec<Sample>, Unit) {
        let unit = Unit::drawn(seed);
        let motion = Motion::drawn(self, seed.wrapping_mul(2) + 1);
        (unit::record(self, &unit, &motion, seed), unit)
    }

    /// Heading errors of a calibration on a fresh movement of the same kind, with true tilt and
    /// without noise: root mean square, degrees.
    pub fn heading_error_deg(&self, unit: &Unit, outcome: &Outcome, seed: u64) -> f64 {
        let m = &outcome.magnetometer;
        self.heading_error_of(unit, m.soft_iron, m.hard_iron_ut, seed)
    }

    /// The same for a correction of soft iron and a hard iron.
    pub fn heading_error_of(&self, unit: &Unit, correction: DMat3, hard: DVec3, seed: u64) -> f64 {
        let motion = Motion::drawn(self, seed.wrapping_mul(2) + 1_000_001);
        let count = (self.duration_s * 10.0) as usize;
        let error = |k: usize| {
            let attitude: DQuat = motion.attitude(self.rest_s + 0.1 * k as f64);
            let field = correction * (unit.field_reading(attitude) - hard);
            let world = attitude * field;
            world.x.atan2(world.y)
        };
        let square = (0..count).map(|k| error(k).powi(2)).sum::<f64>() / count as f64;
        square.sqrt().to_degrees()
    }
}
