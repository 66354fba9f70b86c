//! The camera rides in a car through a town, up to 80 km/h.
//!
//! A round of two equal halves: a fast road, traffic lights, right-angled and wide turns and a
//! bend. The road rises and falls, the body pitches under braking and rolls outward in turns, and
//! the road's roughness shakes it more the faster it goes.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{FRAC_PI_2, PI};

use super::path::{Path, Segment};
use super::plan::{Plan, PlanBuilder};
use super::wave::Waves;
use super::{Leg, PoseJet, Trajectory, drawn_heading, drawn_side, lay};

/// Top speed, m/s: 79 km/h.
const TOP_M_S: f64 = 79.0 / 3.6;
/// Pitch under acceleration, rad per m/s²: about one degree at firm braking.
const PITCH_RAD_PER_M_S2: f64 = 0.006;
/// Roll under centripetal acceleration, rad per m/s².
const ROLL_RAD_PER_M_S2: f64 = 0.008;

/// A car in town.
pub(crate) struct Car {
    path: Path,
    plan: Plan,
    /// Height of the road, m, by distance.
    road: Waves<2>,
    /// Height of the body above the road, m, by distance: bounce and roughness.
    shake: Waves<3>,
    shake_pitch: Waves<2>,
    shake_roll: Waves<2>,
}

impl Car {
    /// Draws the town.
    pub(crate) fn drawn(rest_s: f64, rng: &mut ChaCha8Rng) -> Self {
        const CHANGE_M_S2: f64 = 1.4;
        let legs = legs(rng);
        let builder = PlanBuilder::after_rest(rest_s, CHANGE_M_S2);
        let (path, plan) = lay(&legs, 2, drawn_heading(rng), builder);
        Self {
            path,
            plan,
            road: Waves::drawn([(0.7, 313.0), (0.25, 167.0)], rng),
            shake: Waves::drawn([(5e-3, 15.3), (8e-5, 1.87), (2e-5, 0.83)], rng),
            shake_pitch: Waves::drawn([(4e-3, 14.1), (2e-4, 1.87)], rng),
            shake_roll: Waves::drawn([(8e-3, 83.0), (2e-4, 2.03)], rng),
        }
    }
}

/// Half a round, which turns by 180°: laid twice, it closes.
fn legs(rng: &mut ChaCha8Rng) -> [Leg; 11] {
    let side = drawn_side(rng);
    let top = TOP_M_S * rng.random_range(0.93..1.0);
    let mut varied = |nominal: f64| nominal * rng.random_range(0.95..1.2);
    let turn = |rad: f64, radius_m: f64| Segment::turn(rad * side, radius_m);
    [
        Leg::to_stop(Segment::straight(varied(430.0)), top, varied(8.0)),
        Leg::through(Segment::straight(varied(140.0)), 13.5, 5.5),
        Leg::through(turn(FRAC_PI_2, 12.0), 5.5, 5.5),
        Leg::through(Segment::straight(varied(240.0)), 16.0, 12.0),
        Leg::through(turn(-0.4, 60.0), 12.0, 12.0),
        Leg::through(turn(0.4, 60.0), 12.0, 12.0),
        Leg::to_stop(Segment::straight(varied(150.0)), 13.5, varied(12.0)),
        Leg::through(Segment::straight(varied(110.0)), 11.0, 6.5),
        Leg::through(turn(PI / 3.0, 18.0), 6.5, 6.5),
        Leg::through(turn(PI / 6.0, 25.0), 7.5, 7.5),
        Leg::to_stop(Segment::straight(varied(200.0)), 15.0, varied(5.0)),
    ]
}

impl Trajectory for Car {
    fn pose(&self, time_s: f64) -> PoseJet {
        let progress = self.plan.at(time_s);
        let (distance, speed) = (progress.distance, progress.speed);
        let point = self.path.at(distance);
        let (height, slope) = self.road.with_slope(distance);
        let centripetal = speed * speed * point.curvature;
        PoseJet {
            position: [point.x, point.y, height + self.shake.at(distance)],
            yaw: point.heading,
            // Uphill and under acceleration the nose is up, which is negative pitch.
            pitch: self.shake_pitch.at(distance)
                - slope.atan()
                - progress.acceleration * PITCH_RAD_PER_M_S2,
            // In a left turn the body leans to the right, which is positive roll.
            roll: self.shake_roll.at(distance) + centripetal * ROLL_RAD_PER_M_S2,
        }
    }
}
