//! The camera is carried up a staircase of two flights and down again.
//!
//! The body rises step by step and swings sinusoidally with the stride, as in the paper's
//! trajectory figure "Climb Stairs". The walker goes up on one side of the stairs and down on the
//! other, with a turn on each landing and a rest at the top and at the bottom. The walker may halt on
//! the landings between two flights as well; that changes when, not where.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;

use super::path::{Path, Segment};
use super::plan::{Plan, PlanBuilder};
use super::wave::Waves;
use super::{Leg, PoseJet, Trajectory, drawn_heading, drawn_side, lay};
use crate::driver::synthetic::jet::Jet;

/// Height of one step, m.
const RISE_M: f64 = 0.17;
/// Depth of one step, m.
const RUN_M: f64 = 0.28;
/// Steps of one flight.
const STEPS: f64 = 12.0;
/// Smallest radius of the turn on a landing, m.
const TURN_RADIUS_M: f64 = 0.25;
/// The camera looks down at the steps, rad.
const GAZE_PITCH_RAD: f64 = 0.17;

/// A walk up and down stairs.
pub(crate) struct Stairs {
    path: Path,
    plan: Plan,
    flights: [Flight; 4],
    sway: Waves<1>,
    yaw: Waves<2>,
    pitch: Waves<2>,
    roll: Waves<1>,
}

/// A flight: where it begins within the lap, and +1 upstairs, −1 downstairs.
#[derive(Clone, Copy, Debug)]
struct Flight {
    start_m: f64,
    direction: f64,
}

impl Flight {
    /// Height gained on this flight, m; constant before and behind it.
    fn climb(self, within: Jet) -> Jet {
        let steps = (within + -self.start_m) * RUN_M.recip();
        let done = steps.value.floor().clamp(0.0, STEPS - 1.0);
        ((steps + -done).blend() + done) * (self.direction * RISE_M)
    }
}

impl Stairs {
    /// Draws the staircase's direction and the walker's habits; on the middle landings the walker halts
    /// for `halt_s`, if that is above zero.
    pub(crate) fn drawn(rest_s: f64, halt_s: f64, rng: &mut ChaCha8Rng) -> Self {
        const CHANGE_M_S2: f64 = 0.4;
        let side = drawn_side(rng);
        let speed_m_s = rng.random_range(0.36..0.46);
        let legs = legs(speed_m_s, side, (halt_s, rng.random_range(2.0..4.0)));
        let builder = PlanBuilder::after_rest(rest_s, CHANGE_M_S2);
        let (path, plan) = lay(&legs, 1, drawn_heading(rng), builder);
        Self {
            path,
            plan,
            flights: flights(&legs),
            sway: Waves::drawn([(0.03, 2.0 * RUN_M)], rng),
            yaw: Waves::drawn([(0.05, 2.0 * RUN_M), (0.15, 3.17)], rng),
            pitch: Waves::drawn([(0.035, RUN_M), (0.08, 2.31)], rng),
            roll: Waves::drawn([(0.05, 2.0 * RUN_M)], rng),
        }
    }
}

/// Two flights up with a left turn between them, then round and down on the other side. The turn
/// on the middle landing going down is three times as wide, so that the path closes.
fn legs(speed_m_s: f64, side: f64, (halt_s, pause_s): (f64, f64)) -> [Leg; 8] {
    let flight = Segment::straight(RUN_M * STEPS);
    let turn = |radii: f64| Segment::turn(PI * side * radii.signum(), TURN_RADIUS_M * radii.abs());
    let walk = |segment| Leg::through(segment, speed_m_s, speed_m_s);
    let landing = |segment| {
        if halt_s > 0.0 { Leg::to_stop(segment, speed_m_s, halt_s) } else { walk(segment) }
    };
    [
        walk(flight),
        landing(turn(1.0)),
        Leg::to_stop(flight, speed_m_s, pause_s),
        walk(turn(-1.0)),
        walk(flight),
        landing(turn(-3.0)),
        walk(flight),
        Leg::to_stop(turn(-1.0), speed_m_s, pause_s),
    ]
}

fn flights(legs: &[Leg; 8]) -> [Flight; 4] {
    let start = |leg: usize| legs[..leg].iter().map(|l| l.segments[0].length_m).sum();
    [(0, 1.0), (2, 1.0), (4, -1.0), (6, -1.0)]
        .map(|(leg, direction)| Flight { start_m: start(leg), direction })
}

impl Trajectory for Stairs {
    fn pose(&self, time_s: f64) -> PoseJet {
        let distance = self.plan.at(time_s).distance;
        let point = self.path.at(distance);
        let (sin, cos) = point.heading.sin_cos();
        let sway = self.sway.at(distance);
        let climbed = self.flights.iter().map(|f| f.climb(point.within));
        PoseJet {
            position: [
                point.x - sin * sway,
                point.y + cos * sway,
                climbed.fold(Jet::default(), |sum, height| sum + height),
            ],
            yaw: point.heading + self.yaw.at(distance),
            pitch: self.pitch.at(distance) + GAZE_PITCH_RAD,
            roll: self.roll.at(distance),
        }
    }
}
