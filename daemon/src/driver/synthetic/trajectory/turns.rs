//! The camera rides in a car that circles, as slowly as a driver who calibrates, four times round.
//!
//! A car cannot be tilted by hand: all the tilt that it shows is the slope of the ground. It circles
//! on ground whose slope has one steepness, and points another way from turn to turn, as on the
//! flank of a shallow bowl or on the ramps of a car park: over four turns it points once all round,
//! so that each heading is seen tilted to every side.

use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

use super::plan::{Plan, PlanBuilder};
use super::{PoseJet, Trajectory, drawn_heading, drawn_side};
use crate::driver::synthetic::jet::Jet;

/// Smallest turning circle of a passenger car, to its middle, m.
const RADIUS_M: f64 = 5.0;
/// Speed on the circle, m/s: 7 km/h.
const SPEED_M_S: f64 = 2.0;
/// Turns before it stops.
const TURNS: f64 = 4.0;
/// Rest before the next round, s.
const PAUSE_S: f64 = 5.0;

/// Circles on sloping ground.
pub(crate) struct Turns {
    plan: Plan,
    /// +1 to the left, −1 to the right.
    side: f64,
    /// Heading at the beginning, rad.
    heading_rad: f64,
    /// Where the slope points upward at the beginning, rad from x.
    uphill_rad: f64,
    /// Slope of the ground, rad.
    tilt_rad: f64,
}

impl Turns {
    /// Draws heading, side and where the slope begins.
    pub(crate) fn drawn(rest_s: f64, tilt_rad: f64, rng: &mut ChaCha8Rng) -> Self {
        const CHANGE_M_S2: f64 = 0.4;
        let mut builder = PlanBuilder::after_rest(rest_s, CHANGE_M_S2);
        builder.leg(TURNS * TAU * RADIUS_M, SPEED_M_S, 0.0).pause(PAUSE_S);
        Self {
            plan: builder.finish(),
            side: drawn_side(rng),
            heading_rad: drawn_heading(rng),
            uphill_rad: drawn_heading(rng),
            tilt_rad,
        }
    }
}

impl Trajectory for Turns {
    fn pose(&self, time_s: f64) -> PoseJet {
        let turned = self.plan.at(time_s).distance * (self.side / RADIUS_M);
        let heading = turned + self.heading_rad;
        // Uphill runs against the turn, once round in four turns: by 5/4 of a turn against the car.
        let uphill = turned * (-1.0 / TURNS) + self.uphill_rad;
        let (sin_tilt, cos_tilt) = self.tilt_rad.sin_cos();
        let (sin, cos) = (uphill - heading).sin_cos();
        // The ground's normal in axes that turn with the heading leans downhill.
        let (ahead, left) = (cos * -sin_tilt, sin * -sin_tilt);
        // The third column of R_y(pitch) R_x(roll) is that normal.
        let across = (ahead * ahead + cos_tilt * cos_tilt).sqrt();
        let (sin_heading, cos_heading) = heading.sin_cos();
        let radius = self.side * RADIUS_M;
        // ∫ tan(tilt) cos(uphill − heading) ds along the circle.
        let climb = -radius * self.tilt_rad.tan() / (1.0 + 1.0 / TURNS);
        PoseJet {
            position: [sin_heading * radius, cos_heading * -radius, sin * climb],
            yaw: heading,
            pitch: ahead.atan2(Jet::constant(cos_tilt)),
            roll: (-left).atan2(across),
        }
    }
}
