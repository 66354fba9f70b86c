//! How the unit is turned.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::Scene;

/// How it is tilted while it turns about the vertical; angles in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tilt {
    /// Not at all.
    None,
    /// By a constant angle toward a direction that goes round.
    Cone(f64),
    /// Rolling and pitching to this angle, each as a sine.
    Rock(f64),
    /// Rolling and pitching as sums of slow sines, of this root mean square.
    Slow(f64),
    /// Through all attitudes.
    Tumble,
}

/// A smooth movement.
#[derive(Clone, Debug)]
pub struct Motion {
    tilt: Tilt,
    rest_s: f64,
    heading: f64,
    turn_rate: f64,
    /// Frequency, rad/s, and phase of each of the waves.
    waves: [(f64, f64); 8],
    side: f64,
}

impl Motion {
    /// Draws what distinguishes one movement from another.
    pub fn drawn(scene: &Scene, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let slow = matches!(scene.tilt, Tilt::Slow(_));
        let (low, high) = if slow { (0.02, 0.12) } else { (0.1, 0.4) };
        let moving_s = scene.duration_s - scene.rest_s;
        Self {
            tilt: scene.tilt,
            rest_s: scene.rest_s,
            heading: rng.random_range(0.0..TAU),
            turn_rate: scene.turns * TAU / moving_s,
            waves: std::array::from_fn(|_| {
                (TAU * rng.random_range(low..high), rng.random_range(0.0..TAU))
            }),
            side: if rng.random_bool(0.5) { 1.0 } else { -1.0 },
        }
    }

    /// Sensor to W (x east, y magnetic north, z up) at a time, s.
    pub fn attitude(&self, time_s: f64) -> DQuat {
        let t = (time_s - self.rest_s).max(0.0);
        let turn = DQuat::from_rotation_z(self.heading + self.side * self.turn_rate * t);
        let (roll, pitch) = match self.tilt {
            Tilt::None => (0.0, 0.0),
            Tilt::Cone(angle) => return turn * self.cone(angle, t),
            Tilt::Rock(angle) => (self.wave(0, t) * angle, self.wave(1, t) * angle),
            Tilt::Slow(rms) => (self.sum(0, t) * rms, self.sum(4, t) * rms),
            Tilt::Tumble => return self.tumble(t),
        };
        turn * DQuat::from_rotation_y(pitch.to_radians())
            * DQuat::from_rotation_x(roll.to_radians())
    }

    fn wave(&self, k: usize, t: f64) -> f64 {
        (self.waves[k].0 * t + self.waves[k].1).sin()
    }

    /// Of root mean square one over two axes: each takes half of the power.
    fn sum(&self, first: usize, t: f64) -> f64 {
        (first..first + 4).map(|k| self.wave(k, t)).sum::<f64>() / 2.0_f64.sqrt() / 2.0_f64.sqrt()
    }

    fn cone(&self, angle: f64, t: f64) -> DQuat {
        let direction = self.waves[0].0 * t + self.waves[0].1;
        let axis = DVec3::new(direction.cos(), direction.sin(), 0.0);
        DQuat::from_axis_angle(axis, angle.to_radians())
    }

    fn tumble(&self, t: f64) -> DQuat {
        let angle = |k: usize| self.side * (self.waves[k].0 * t * 0.5 + self.waves[k].1);
        DQuat::from_rotation_z(angle(0))
            * DQuat::from_rotation_x(angle(1))
            * DQuat::from_rotation_y(angle(2))
    }
}
