//! A trajectory that begins with a given heading.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use super::{PoseJet, Trajectory};

/// Another trajectory, turned about the vertical as a whole.
pub(crate) struct Turned {
    inner: Arc<dyn Trajectory>,
    /// Anticlockwise, rad.
    turn_rad: f64,
}

impl Turned {
    /// Turns a trajectory so that it begins with a heading, clockwise from W's y axis, rad.
    pub(crate) fn to(heading_rad: f64, inner: Arc<dyn Trajectory>) -> Self {
        let yaw_rad = FRAC_PI_2 - heading_rad;
        let turn_rad = yaw_rad - inner.pose(0.0).yaw.value;
        Self { inner, turn_rad }
    }
}

impl Trajectory for Turned {
    fn pose(&self, time_s: f64) -> PoseJet {
        let pose = self.inner.pose(time_s);
        let (sin, cos) = self.turn_rad.sin_cos();
        let [x, y, z] = pose.position;
        PoseJet {
            position: [x * cos - y * sin, x * sin + y * cos, z],
            yaw: pose.yaw + self.turn_rad,
            ..pose
        }
    }
}
