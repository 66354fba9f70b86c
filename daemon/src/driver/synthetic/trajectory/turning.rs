//! The camera is turned by hand for a calibration: round and round, tilted, or through all attitudes.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;

use super::plan::{Plan, PlanBuilder};
use super::wave::Waves;
use super::{PoseJet, Trajectory, drawn_heading, drawn_side};
use crate::driver::synthetic::jet::Jet;

/// The plan counts seconds of turning: its distance grows by 1 a second.
const BOUT: f64 = 240.0;
/// How fast the turning begins and ends, 1/s.
const CHANGE: f64 = 0.5;

/// Turned about the vertical, with waves or turns about the other axes.
pub(crate) struct Turning {
    plan: Plan,
    /// From the axis to the camera, m.
    arm_m: f64,
    heading_rad: f64,
    /// rad per unit of the plan.
    turn: f64,
    /// The same about the forward axis.
    overturn: f64,
    pitch: Waves<2>,
    roll: Waves<2>,
}

impl Turning {
    /// A turn in 25 s, tilted by some degrees to every side, as on a vehicle on uneven ground.
    pub(crate) fn turns(rest_s: f64, arm_m: f64, rng: &mut ChaCha8Rng) -> Self {
        Self {
            turn: drawn_side(rng) * TAU / 25.0,
            overturn: 0.0,
            pitch: Waves::drawn([(0.10, 5.9), (0.05, 13.7)], rng),
            roll: Waves::drawn([(0.10, 7.3), (0.05, 17.1)], rng),
            ..Self::round(rest_s, arm_m, rng)
        }
    }

    /// Through all attitudes.
    pub(crate) fn tumble(rest_s: f64, arm_m: f64, rng: &mut ChaCha8Rng) -> Self {
        Self {
            turn: drawn_side(rng) * TAU / 17.0,
            overturn: drawn_side(rng) * TAU / 13.0,
            pitch: Waves::drawn([(1.0, 9.1), (0.2, 5.3)], rng),
            roll: Waves::drawn([(0.3, 6.7), (0.1, 3.9)], rng),
            ..Self::round(rest_s, arm_m, rng)
        }
    }

    fn round(rest_s: f64, arm_m: f64, rng: &mut ChaCha8Rng) -> Self {
        let mut plan = PlanBuilder::after_rest(rest_s, CHANGE);
        plan.leg(BOUT, 1.0, 0.0).pause(3.0);
        let still = Waves::drawn([(0.0, 1.0), (0.0, 1.0)], rng);
        Self {
            plan: plan.finish(),
            arm_m,
            heading_rad: drawn_heading(rng),
            turn: 0.0,
            overturn: 0.0,
            pitch: still,
            roll: still,
        }
    }
}

impl Trajectory for Turning {
    fn pose(&self, time_s: f64) -> PoseJet {
        let turned: Jet = self.plan.at(time_s).distance;
        let yaw = turned * self.turn + self.heading_rad;
        let (sin, cos) = yaw.sin_cos();
        PoseJet {
            position: [cos * self.arm_m, sin * self.arm_m, Jet::default()],
            yaw,
            pitch: self.pitch.at(turned),
            roll: turned * self.overturn + self.roll.at(turned),
        }
    }
}
