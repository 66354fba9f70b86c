//! Attitude from gyroscope and accelerometer alone: level, with a heading that drifts.

use glam::{DQuat, DVec3};
use lodestone_fusion::so3;

/// How fast the accelerometer pulls the tilt, 1/s. Small: a wrong start lasts; large: accelerations
/// tilt it.
const TILT_GAIN: f64 = 0.3;

/// How fast it pulls the bias, 1/s². With the gain above: damped critically.
const BIAS_GAIN: f64 = 0.0225;

/// A complementary filter (Mahony, Hamel, Pflimlin 2008, eq. 33, gravity alone).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Levelling {
    /// Sensor to a level frame with z up.
    pub(crate) attitude: DQuat,
    /// What of the gyroscope's bias the tilt shows, rad/s.
    pub(crate) bias: DVec3,
}

impl Levelling {
    /// Begins with the direction of a specific force.
    pub(crate) fn start(accel: DVec3) -> Self {
        let up = accel.try_normalize().unwrap_or(DVec3::Z);
        Self { attitude: DQuat::from_rotation_arc(up, DVec3::Z), bias: DVec3::ZERO }
    }

    /// Goes on by an interval.
    pub(crate) fn step(&mut self, dt_s: f64, gyro: DVec3, accel: DVec3) {
        let up = self.attitude.inverse() * DVec3::Z;
        let seen = accel.try_normalize().unwrap_or(up);
        let error = seen.cross(up);
        // A gap must not overshoot.
        let pull_s = dt_s.min(0.5 / TILT_GAIN);
        self.bias -= error * (BIAS_GAIN * pull_s);
        let turn = (gyro - self.bias) * dt_s + error * (TILT_GAIN * pull_s);
        self.attitude = (self.attitude * so3::exp(turn)).normalize();
    }
}
