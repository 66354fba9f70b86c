//! The camera is carried through a room by hand.
//!
//! The walker goes round two tables in a figure of eight, never twice the same way: waves whose
//! lengths have no common multiple displace the path. The gait lifts and sways the camera, the
//! walker looks around, and now and then puts the camera down for some seconds.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{PI, SQRT_2, TAU};

use super::plan::{Plan, PlanBuilder};
use super::wave::Waves;
use super::{PoseJet, Trajectory, drawn_heading, drawn_side};
use crate::driver::synthetic::jet::Jet;

/// Half-length and half-width of the figure of eight, m: a room of some 5 m by 3 m.
const HALF_LENGTH_M: f64 = 1.8;
const HALF_WIDTH_M: f64 = 0.75;
/// Metres per radian of the figure's parameter, root mean square over the figure.
const SCALE_M: f64 = 1.66;
/// Length of one step, m; a stride is two.
const STEP_M: f64 = 0.55;
/// Walks before the pattern of speeds and pauses repeats (the path itself does not).
const BOUTS: usize = 9;
/// The camera looks down at what it films, rad.
const GAZE_PITCH_RAD: f64 = 0.09;

/// A hand-carried walk.
pub(crate) struct Walk {
    plan: Plan,
    heading_rad: f64,
    side: f64,
    start: f64,
    along: Waves<2>,
    across: Waves<2>,
    lift: Waves<2>,
    sway: Waves<1>,
    gaze_yaw: Waves<4>,
    gaze_pitch: Waves<3>,
    gaze_roll: Waves<3>,
}

impl Walk {
    /// Draws the way through the room.
    pub(crate) fn drawn(rest_s: f64, rng: &mut ChaCha8Rng) -> Self {
        Self {
            plan: drawn_plan(rest_s, rng),
            heading_rad: drawn_heading(rng),
            side: drawn_side(rng),
            start: rng.random_range(0.0..TAU),
            along: Waves::drawn([(0.15, TAU / 0.381_966), (0.05, TAU / SQRT_2)], rng),
            across: Waves::drawn([(0.15, TAU / 0.618_034), (0.05, TAU / 1.732_051)], rng),
            lift: Waves::drawn([(0.018, STEP_M), (0.05, 7.39)], rng),
            sway: Waves::drawn([(0.015, 2.0 * STEP_M)], rng),
            gaze_yaw: Waves::drawn(
                [(0.45, 8.17), (0.25, 3.89), (0.08, 1.93), (0.02, 2.0 * STEP_M)],
                rng,
            ),
            gaze_pitch: Waves::drawn([(0.14, 5.03), (0.07, 2.71), (0.012, STEP_M)], rng),
            gaze_roll: Waves::drawn([(0.06, 6.13), (0.05, 2.23), (0.02, 2.0 * STEP_M)], rng),
        }
    }

    /// The walker's place in the room, m, and heading, rad, at a travelled distance.
    fn walker(&self, distance: Jet) -> [Jet; 3] {
        let u = distance * SCALE_M.recip() + self.start;
        let length = Waves::in_phase([(HALF_LENGTH_M, TAU)]);
        let width = Waves::in_phase([(HALF_WIDTH_M * self.side, PI)]);
        let ((x0, dx0), (x1, dx1)) = (length.with_slope(u), self.along.with_slope(u));
        let ((y0, dy0), (y1, dy1)) = (width.with_slope(u), self.across.with_slope(u));
        // The slope never vanishes: the figure's own is at least 1.15 m/rad, the waves' at
        // most 0.22.
        [x0 + x1, y0 + y1, (dy0 + dy1).atan2(dx0 + dx1)]
    }
}

impl Trajectory for Walk {
    fn pose(&self, time_s: f64) -> PoseJet {
        let distance = self.plan.at(time_s).distance;
        let [x, y, heading] = self.walker(distance);
        let (sin, cos) = heading.sin_cos();
        let sway = self.sway.at(distance);
        let (x, y) = (x - sin * sway, y + cos * sway);
        let (sin, cos) = self.heading_rad.sin_cos();
        PoseJet {
            position: [x * cos - y * sin, x * sin + y * cos, self.lift.at(distance)],
            yaw: heading + self.gaze_yaw.at(distance) + self.heading_rad,
            pitch: self.gaze_pitch.at(distance) + GAZE_PITCH_RAD,
            roll: self.gaze_roll.at(distance),
        }
    }
}

fn drawn_plan(rest_s: f64, rng: &mut ChaCha8Rng) -> Plan {
    const CHANGE_M_S2: f64 = 0.6;
    let mut builder = PlanBuilder::after_rest(rest_s, CHANGE_M_S2);
    for _ in 0..BOUTS {
        let (length_m, speed_m_s) = (rng.random_range(8.0..17.0), rng.random_range(0.7..1.0));
        builder.leg(length_m, speed_m_s, 0.0).pause(rng.random_range(1.5..4.0));
    }
    builder.finish()
}
