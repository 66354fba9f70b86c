//! The camera rides in a car that circles, as slowly as a driver who calibrates: two turns to one
//! side, a stop, two turns to the other side.
//!
//! A car cannot be tilted by hand: all the tilt that it shows is the slope of the ground. That has
//! one steepness here, and points once all round during each pair of turns, as on the flank of a
//! shallow bowl or on the ramps of a car park, so that each heading is seen tilted to every side.
//!
//! Circling presses the car outward, steadily, which an accelerometer cannot tell from a tilt or
//! from its own bias. To the other side it presses the other way: that is why it turns both ways.

use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

use super::plan::{Plan, PlanBuilder};
use super::{PoseJet, Trajectory, drawn_heading, drawn_side};
use crate::driver::synthetic::jet::Jet;

/// Smallest turning circle of a passenger car, to its middle, m.
const RADIUS_M: f64 = 5.0;
/// Speed on the circle, m/s: 5.4 km/h, a car that creeps in gear.
const SPEED_M_S: f64 = 1.5;
/// Both turns to one side, rad.
const ONE_SIDE_RAD: f64 = 2.0 * TAU;
/// Turns of the slope for each turn of the car.
const SLOPE_TURNS: f64 = 0.5;
/// Rest after each pair of turns, s.
const PAUSE_S: f64 = 3.0;

/// Circles on sloping ground.
pub(crate) struct Circles {
    plan: Plan,
    /// +1 to the left first, −1 to the right first.
    side: f64,
    /// Heading at the beginning, rad.
    heading_rad: f64,
    /// Where the slope points upward at the beginning, rad from x.
    uphill_rad: f64,
    /// Slope of the ground, rad.
    tilt_rad: f64,
}

impl Circles {
    /// Draws heading, side and where the slope begins.
    pub(crate) fn drawn(rest_s: f64, tilt_rad: f64, rng: &mut ChaCha8Rng) -> Self {
        const CHANGE_M_S2: f64 = 0.4;
        let mut builder = PlanBuilder::after_rest(rest_s, CHANGE_M_S2);
        for _ in 0..2 {
            builder.leg(ONE_SIDE_RAD * RADIUS_M, SPEED_M_S, 0.0).pause(PAUSE_S);
        }
        Self {
            plan: builder.finish(),
            side: drawn_side(rng),
            heading_rad: drawn_heading(rng),
            uphill_rad: drawn_heading(rng),
            tilt_rad,
        }
    }

    /// How far it turned since its last stop, rad, and to which side. Where it stops, both
    /// readings of that instant are the same pose, up to whole turns.
    fn turned(&self, time_s: f64) -> (Jet, f64) {
        let angle = self.plan.at(time_s).distance * RADIUS_M.recip();
        let pairs = (angle.value / ONE_SIDE_RAD).floor();
        let side = if pairs.rem_euclid(2.0) < 0.5 { self.side } else { -self.side };
        (angle + -pairs * ONE_SIDE_RAD, side)
    }
}

impl Trajectory for Circles {
    fn pose(&self, time_s: f64) -> PoseJet {
        let (turned, side) = self.turned(time_s);
        let heading = turned * side + self.heading_rad;
        // From the car the slope seems to turn by what it turns itself and what the car turns.
        let apparent = SLOPE_TURNS + side;
        let begin = self.uphill_rad - self.heading_rad;
        let (sin, cos) = (turned * -apparent + begin).sin_cos();
        let (sin_tilt, cos_tilt) = self.tilt_rad.sin_cos();
        // The ground's normal, in axes that turn with the heading, leans downhill.
        let (ahead, left) = (cos * -sin_tilt, sin * -sin_tilt);
        // The third column of R_y(pitch) R_x(roll) is that normal.
        let across = (ahead * ahead + cos_tilt * cos_tilt).sqrt();
        let (sin_heading, cos_heading) = heading.sin_cos();
        let (sin_begin, cos_begin) = self.heading_rad.sin_cos();
        let radius = side * RADIUS_M;
        // ∫ tan(tilt) cos(uphill − heading) ds along the circle; zero after each pair of turns.
        let climb = -RADIUS_M * self.tilt_rad.tan() / apparent;
        PoseJet {
            position: [
                (sin_heading + -sin_begin) * radius,
                (cos_heading + -cos_begin) * -radius,
                (sin + -begin.sin()) * climb,
            ],
            yaw: heading,
            pitch: ahead.atan2(Jet::constant(cos_tilt)),
            roll: (-left).atan2(across),
        }
    }
}
