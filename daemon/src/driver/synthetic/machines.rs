//! Fields of what runs on the same vehicle as the camera: machines that turn, devices that switch.
//!
//! Both are fixed to the body, so no movement tells them from the sensor's own error, and a
//! calibration that stands still in the camera's axes cannot take out what changes in time.

use std::f64::consts::TAU;

use glam::DVec3;
use lodestone_config::model::{Instrument, Motor, Synthetic};
use rand::RngExt;

use super::jet::Blend;
use super::random::Stream;

/// Time in which a device switches on or off, s: relays and inrush.
const SWITCH_S: f64 = 0.05;

/// Everything that runs on the vehicle.
#[derive(Clone, Debug)]
pub(crate) struct Machines {
    motors: Vec<Turning>,
    instruments: Vec<Switching>,
    /// Time and speed of the sample before.
    last: Option<(f64, f64)>,
}

#[derive(Clone, Copy, Debug)]
struct Turning {
    motor: Motor,
    /// Turns since the beginning; only the part after the point matters.
    turns: f64,
}

#[derive(Clone, Copy, Debug)]
struct Switching {
    instrument: Instrument,
    /// How far the first cycle is through at the beginning, s.
    begun_s: f64,
}

impl Machines {
    /// What is configured, each at a drawn point of its turn or cycle.
    pub(crate) fn drawn(synthetic: &Synthetic) -> Self {
        let mut rng = Stream::Machines.of(synthetic.seed);
        let motors = synthetic.motor.iter();
        let motors = motors.map(|&motor| Turning { motor, turns: rng.random() }).collect();
        let instruments = synthetic.instrument.iter().map(|&instrument| {
            let cycle_s = instrument.on_s + instrument.off_s;
            Switching { instrument, begun_s: cycle_s * rng.random::<f64>() }
        });
        Self { motors, instruments: instruments.collect(), last: None }
    }

    /// Their field in the body frame, µT, at a time while the camera moves with `speed_m_s`.
    /// Times must not decrease: the phase of a motor is the integral of its frequency, by the
    /// trapezoidal rule from sample to sample.
    pub(crate) fn field(&mut self, time_s: f64, speed_m_s: f64) -> DVec3 {
        let (last_s, last_m_s) =
            self.last.replace((time_s, speed_m_s)).unwrap_or((time_s, speed_m_s));
        let (passed_s, mean_m_s) = (time_s - last_s, 0.5 * (speed_m_s + last_m_s));
        let motors = self.motors.iter_mut().map(|m| m.advance(passed_s, mean_m_s));
        let moving = motors.fold(DVec3::ZERO, |sum, b| sum + b);
        self.instruments.iter().fold(moving, |sum, i| sum + i.at(time_s))
    }
}

impl Turning {
    fn advance(&mut self, passed_s: f64, speed_m_s: f64) -> DVec3 {
        let frequency_hz = self.motor.idle_hz + self.motor.hz_per_m_s * speed_m_s;
        self.turns = (self.turns + frequency_hz * passed_s).fract();
        DVec3::from_array(self.motor.field_ut) * (TAU * self.turns).sin()
    }
}

impl Switching {
    fn at(&self, time_s: f64) -> DVec3 {
        let Instrument { field_ut, on_s, off_s } = self.instrument;
        let field = DVec3::from_array(field_ut);
        if off_s == 0.0 {
            return field;
        }
        let within_s = (self.begun_s + time_s).rem_euclid(on_s + off_s);
        let ramp_s = SWITCH_S.min(0.5 * on_s);
        let envelope =
            Blend::at(within_s / ramp_s).value * Blend::at((on_s - within_s) / ramp_s).value;
        field * envelope
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_S: f64 = 0.0025;

    fn machines(motor: Vec<Motor>, instrument: Vec<Instrument>) -> Machines {
        Machines::drawn(&Synthetic { motor, instrument, seed: 5, ..Synthetic::default() })
    }

    /// Upward crossings of zero on the x axis while the speed grows evenly to `top_m_s`.
    fn crossings(motor: Motor, top_m_s: f64, duration_s: f64) -> u32 {
        let mut machines = machines(vec![motor], vec![]);
        let mut before = f64::NAN;
        let mut count = 0;
        for k in 0..(duration_s / STEP_S) as u32 {
            let time_s = f64::from(k) * STEP_S;
            let now = machines.field(time_s, top_m_s * time_s / duration_s).x;
            count += u32::from(before <= 0.0 && now > 0.0);
            before = now;
        }
        count
    }

    #[test]
    fn a_motor_turns_with_its_frequency_and_faster_with_speed() {
        let motor = Motor { field_ut: [2.0, 0.0, -1.0], idle_hz: 13.3, hz_per_m_s: 0.0 };
        assert!(crossings(motor, 20.0, 100.0).abs_diff(1330) <= 1);
        // The integral of 2 Hz/(m/s) × speed over a ramp to 20 m/s in 100 s is 2000 turns.
        let geared = Motor { hz_per_m_s: 2.0, ..motor };
        assert!(crossings(geared, 20.0, 100.0).abs_diff(3330) <= 1);
    }

    #[test]
    fn a_motors_field_has_its_amplitude_and_direction() {
        let motor = Motor { field_ut: [2.0, 0.0, -1.0], idle_hz: 7.1, hz_per_m_s: 0.0 };
        let mut machines = machines(vec![motor], vec![]);
        let fields: Vec<_> =
            (0..40_000).map(|k| machines.field(f64::from(k) * STEP_S, 0.0)).collect();
        let largest = fields.iter().map(|b| b.x).fold(0.0, f64::max);
        assert!((largest - 2.0).abs() < 1e-3, "{largest}");
        let mean_square = fields.iter().map(|b| b.length_squared()).sum::<f64>() / 40_000.0;
        assert!((mean_square - 2.5).abs() < 0.01, "{mean_square}");
        assert!(fields.iter().all(|b| (b.x + 2.0 * b.z).abs() < 1e-12 && b.y == 0.0));
    }

    #[test]
    fn an_instrument_is_on_for_its_part_of_the_time_and_does_not_jump() {
        let instrument = Instrument { field_ut: [0.0, 3.0, 0.0], on_s: 2.0, off_s: 6.0 };
        let mut machines = machines(vec![], vec![instrument]);
        let fields: Vec<_> =
            (0..32_000).map(|k| machines.field(f64::from(k) * STEP_S, 0.0).y).collect();
        let on = fields.iter().filter(|b| **b > 1.5).count() as f64 / 32_000.0;
        // 2 s of 8 s, less half a ramp at either end.
        assert!((on - 1.95 / 8.0).abs() < 0.002, "{on}");
        // The blend is steepest with 1.875 over its 50 ms.
        let step = fields.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
        assert!(step < 3.0 * 1.9 * STEP_S / SWITCH_S, "{step}");
    }

    #[test]
    fn an_instrument_that_is_never_off_is_constant() {
        let instrument = Instrument { field_ut: [1.0, 3.0, 0.5], on_s: 1.0, off_s: 0.0 };
        let mut machines = machines(vec![], vec![instrument]);
        for k in 0..100 {
            assert_eq!(machines.field(f64::from(k) * 0.1, 0.0), DVec3::new(1.0, 3.0, 0.5));
        }
    }
}
