//! The camera is turned by hand through all attitudes.
//!
//! What can be lifted is calibrated best: rolled over and over while it nods and turns, until each
//! axis has pointed everywhere. The hand turns it by about a radian a second.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::plan::{Plan, PlanBuilder};
use super::wave::Waves;
use super::{PoseJet, Trajectory, drawn_heading, drawn_side};
use crate::driver::synthetic::jet::Jet;

/// Rate of rolling, rad/s.
const RATE_RAD_S: f64 = 0.9;
/// Rolled before the hand rests, rad: about ten times over.
const ROLLED_RAD: f64 = 63.0;
/// Rest before the next round, s.
const PAUSE_S: f64 = 3.0;
/// Largest pitch, rad: the nose points nearly straight up and down.
const PITCH_RAD: f64 = 1.45;

/// Turning in the hand.
pub(crate) struct Tumble {
    /// How far it was rolled, rad, over time.
    plan: Plan,
    side: f64,
    heading_rad: f64,
    /// Turn about the vertical for each radian of roll.
    yaw_rate: f64,
    /// Pitch, in units of its largest, by roll.
    nod: Waves<1>,
    /// How the hands move meanwhile, m, by roll.
    hands: [Waves<2>; 3],
}

impl Tumble {
    /// Draws the order in which attitudes come.
    pub(crate) fn drawn(rest_s: f64, rng: &mut ChaCha8Rng) -> Self {
        const CHANGE_RAD_S2: f64 = 0.5;
        let mut builder = PlanBuilder::after_rest(rest_s, CHANGE_RAD_S2);
        builder.leg(ROLLED_RAD, RATE_RAD_S, 0.0).pause(PAUSE_S);
        let mut hand = || Waves::drawn([(0.12, 7.3), (0.04, 3.1)], rng);
        let hands = [hand(), hand(), hand()];
        Self {
            plan: builder.finish(),
            side: drawn_side(rng),
            heading_rad: drawn_heading(rng),
            yaw_rate: 0.27 * rng.random_range(0.9..1.1) * drawn_side(rng),
            // In no simple ratio to a turn, so that rolls do not repeat.
            nod: Waves::drawn([(1.0, 10.3)], rng),
            hands,
        }
    }
}

impl Trajectory for Tumble {
    fn pose(&self, time_s: f64) -> PoseJet {
        let rolled: Jet = self.plan.at(time_s).distance;
        PoseJet {
            position: [0, 1, 2].map(|axis| self.hands[axis].at(rolled)),
            yaw: rolled * self.yaw_rate + self.heading_rad,
            pitch: self.nod.at(rolled) * PITCH_RAD,
            roll: rolled * self.side,
        }
    }
}
