//! The camera rides on a model vehicle on the floor of a room, at most 3.6 km/h.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::FRAC_PI_2;

use super::path::{Path, Segment};
use super::plan::{Plan, PlanBuilder};
use super::wave::Waves;
use super::{Leg, PoseJet, Trajectory, drawn_heading, drawn_side, lay};
use crate::driver::synthetic::jet::Jet;

/// A model vehicle.
pub(crate) struct ModelVehicle {
    path: Path,
    plan: Plan,
    /// The floor's height, m, by distance: unevenness, and the joints of its boards.
    floor: Waves<2>,
    pitch: Waves<2>,
    roll: Waves<2>,
}

impl ModelVehicle {
    /// Draws the round and the floor.
    pub(crate) fn drawn(rest_s: f64, rng: &mut ChaCha8Rng) -> Self {
        const CHANGE_M_S2: f64 = 0.5;
        let legs = legs(rng);
        let builder = PlanBuilder::after_rest(rest_s, CHANGE_M_S2);
        let (path, plan) = lay(&legs, 2, drawn_heading(rng), builder);
        Self {
            path,
            plan,
            floor: Waves::drawn([(1.5e-3, 1.31), (2.0e-5, 0.071)], rng),
            pitch: Waves::drawn([(7e-3, 1.31), (4e-4, 0.083)], rng),
            roll: Waves::drawn([(5e-3, 0.97), (4e-4, 0.071)], rng),
        }
    }
}

/// Half a round, which turns by 180°: laid twice, it closes.
fn legs(rng: &mut ChaCha8Rng) -> [Leg; 7] {
    let side = drawn_side(rng);
    let top = rng.random_range(0.85..1.0);
    let mut varied = |nominal: f64| nominal * rng.random_range(0.9..1.15);
    let turn = |rad: f64, radius_m: f64| Segment::turn(rad * side, radius_m);
    [
        Leg::to_stop(Segment::straight(varied(2.6)), top, varied(3.0)),
        Leg::through(turn(FRAC_PI_2, 0.35), 0.4, 0.4),
        Leg::through(Segment::straight(varied(1.0)), 0.8 * top, 0.4),
        Leg::through(turn(-0.6, 0.6), 0.5, 0.5),
        Leg::through(turn(0.6, 0.6), 0.5, 0.5),
        Leg::through(turn(FRAC_PI_2, 0.5), 0.5, 0.5),
        Leg::to_stop(Segment::straight(varied(1.2)), top, varied(2.0)),
    ]
}

impl Trajectory for ModelVehicle {
    fn pose(&self, time_s: f64) -> PoseJet {
        let distance: Jet = self.plan.at(time_s).distance;
        let point = self.path.at(distance);
        PoseJet {
            position: [point.x, point.y, self.floor.at(distance)],
            yaw: point.heading,
            pitch: self.pitch.at(distance),
            roll: self.roll.at(distance),
        }
    }
}
