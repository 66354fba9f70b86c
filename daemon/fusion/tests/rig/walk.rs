//! A rig that is carried through rooms: its true motion, as a smooth function of time.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

/// How somebody walks.
#[derive(Clone, Debug)]
pub(crate) struct Walk {
    /// Speed along the path, m/s.
    pub(crate) speed_m_s: f64,
    /// Times at which they start and stop, in turn, s.
    pub(crate) starts_and_stops: Vec<f64>,
    /// Half lengths of the area walked about in, m.
    pub(crate) area_m: [f64; 2],
    /// Bounce of the carried rig, m, and its swaying, rad.
    pub(crate) bounce_m: f64,
    pub(crate) sway_rad: f64,
}

impl Default for Walk {
    fn default() -> Self {
        Self {
            speed_m_s: 1.1,
            starts_and_stops: vec![3.0],
            area_m: [7.0, 4.5],
            bounce_m: 0.02,
            sway_rad: 0.05,
        }
    }
}

/// Seconds from standing to walking.
const RAMP_S: f64 = 0.8;
/// Steps per second.
const STEPS_HZ: f64 = 1.8;

impl Walk {
    /// Parameter of the path at a time: the way if the path were walked at constant speed, m.
    fn way(&self, time_s: f64) -> f64 {
        let ramp = |since: f64| {
            let x = (since / RAMP_S).clamp(0.0, 1.0);
            RAMP_S * (x * x * x - 0.5 * x * x * x * x) + (since - RAMP_S).max(0.0)
        };
        let signed =
            |(k, at): (usize, &f64)| (if k % 2 == 0 { 1.0 } else { -1.0 }) * ramp(time_s - at);
        self.speed_m_s * self.starts_and_stops.iter().enumerate().map(signed).sum::<f64>()
    }

    fn liveliness(&self, time_s: f64) -> f64 {
        let h = 1e-4;
        (self.way(time_s + h) - self.way(time_s - h)) / (2.0 * h * self.speed_m_s)
    }

    /// A place of the path, on the floor.
    pub(crate) fn path(&self, way: f64) -> DVec3 {
        let [a, b] = self.area_m;
        DVec3::new(a * (way / a).sin(), b * (way * 0.7 / b + 0.4).sin(), 0.0)
    }

    /// Position of the rig's filter point in the world, m.
    pub(crate) fn position(&self, time_s: f64) -> DVec3 {
        let (lively, phase) = (self.liveliness(time_s), TAU * STEPS_HZ * time_s);
        let bounce = DVec3::new(0.0, 0.6 * (0.5 * phase).sin(), phase.sin());
        self.path(self.way(time_s)) + bounce * (self.bounce_m * lively) + DVec3::Z
    }

    /// Rig to world.
    pub(crate) fn orientation(&self, time_s: f64) -> DQuat {
        let (way, h) = (self.way(time_s), 1e-4);
        let ahead = self.path(way + h) - self.path(way - h);
        let sway = self.sway_rad * self.liveliness(time_s);
        let phase = TAU * STEPS_HZ * time_s;
        let yaw = ahead.y.atan2(ahead.x) + sway * (0.5 * phase).sin();
        let pitch = 0.1 + sway * (phase + 1.0).sin();
        let roll = 0.05 + 0.7 * sway * (0.5 * phase + 2.0).sin();
        DQuat::from_euler(glam::EulerRot::ZYX, yaw, pitch, roll)
    }

    /// Velocity of a point of the rig in the world, m/s.
    pub(crate) fn velocity(&self, time_s: f64, arm: DVec3) -> DVec3 {
        let (h, at) = (1e-4, |t: f64| self.position(t) + self.orientation(t) * arm);
        (at(time_s + h) - at(time_s - h)) / (2.0 * h)
    }
}
