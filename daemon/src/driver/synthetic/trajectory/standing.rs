//! The camera stands on a tripod.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{PoseJet, Trajectory, drawn_heading};
use crate::driver::synthetic::jet::Jet;

/// Largest tilt of the tripod's head, rad.
const TILT_RAD: f64 = 0.05;

/// Rest, looking anywhere, nearly level.
pub(crate) struct Standing {
    pose: PoseJet,
}

impl Standing {
    /// Draws where it looks.
    pub(crate) fn drawn(rng: &mut ChaCha8Rng) -> Self {
        let mut tilt = || Jet::constant(rng.random_range(-TILT_RAD..TILT_RAD));
        let (pitch, roll) = (tilt(), tilt());
        let yaw = Jet::constant(drawn_heading(rng));
        Self { pose: PoseJet { position: [Jet::default(); 3], yaw, pitch, roll } }
    }

    /// The same with a pitch (nose down positive) or a roll (right side down positive) that is given, rad.
    pub(crate) fn tilted(self, pitch_rad: Option<f64>, roll_rad: Option<f64>) -> Self {
        let pitch = pitch_rad.map_or(self.pose.pitch, Jet::constant);
        let roll = roll_rad.map_or(self.pose.roll, Jet::constant);
        Self { pose: PoseJet { pitch, roll, ..self.pose } }
    }
}

impl Trajectory for Standing {
    fn pose(&self, _time_s: f64) -> PoseJet {
        self.pose
    }
}
