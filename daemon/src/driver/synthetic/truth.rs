//! What really happened, for demonstrations and tests; no estimator ever sees it.

use glam::DVec3;
use lodestone_fusion::{Accel, Body, Rotation, SensorTime, World};

use super::clock::SensorClock;
use super::kinematics::{Earth, Mover};

/// The true state of a camera at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Position in W, m; its origin is where the first camera begins.
    pub position_m: DVec3,
    /// Velocity in W, m/s.
    pub velocity_m_s: DVec3,
    /// Body to world.
    pub orientation: Rotation<World, Body>,
    /// Angular rate of the body against W (without the earth's), in the body frame, rad/s.
    pub angular_rate_rad_s: DVec3,
    /// Specific force in the body frame, without any error of a sensor.
    pub specific_force: Accel<Body>,
}

/// The truth as a pure function of the sensor's time. Cheap to clone; for any thread.
#[derive(Clone)]
pub struct TruthSource {
    mover: Mover,
    earth: Earth,
    clock: SensorClock,
}

impl TruthSource {
    pub(crate) const fn new(mover: Mover, earth: Earth, clock: SensorClock) -> Self {
        Self { mover, earth, clock }
    }

    /// The truth at a time on the sensor's clock. Before the first sample the camera rests.
    ///
    /// A quantised stamp is up to one tick (39.0625 µs) older than its sample.
    pub fn truth_at(&self, sensor_time: SensorTime) -> Truth {
        let motion = self.mover.at(self.clock.world_time_s(sensor_time));
        Truth {
            position_m: motion.position,
            velocity_m_s: motion.velocity,
            orientation: motion.orientation,
            angular_rate_rad_s: motion.rate,
            specific_force: Accel::new(self.earth.specific_force(&motion)),
        }
    }

    /// The sensor's clock when the source began: the nominal time of its first sample.
    pub fn start(&self) -> SensorTime {
        self.clock.stamp(0.0)
    }
}

impl std::fmt::Debug for TruthSource {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("TruthSource").field("clock", &self.clock).finish_non_exhaustive()
    }
}
