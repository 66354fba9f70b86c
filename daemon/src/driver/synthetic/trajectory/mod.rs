//! How cameras move: one file per trajectory.
//!
//! Each trajectory is a smooth function of time that begins with rest and never ends. Everything
//! in it depends on time through the travelled distance of a [`plan::Plan`] alone, so where the
//! plan pauses, the camera truly rests. Position is at least C², so specific force is continuous,
//! and attitude at least C¹ with a continuous rate.

mod car;
mod circles;
mod model_vehicle;
mod path;
mod plan;
mod stairs;
mod standing;
mod turned;
mod turning;
mod walk;
mod wave;

#[cfg(test)]
mod tests;

use std::sync::Arc;

use lodestone_config::model::{Synthetic, TrajectoryKind};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::jet::Jet;

/// A pose with its derivatives by time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PoseJet {
    /// Position in W, m.
    pub(crate) position: [Jet; 3],
    /// About z, rad, from x toward y. May jump by whole turns.
    pub(crate) yaw: Jet,
    /// About y, rad, nose down positive.
    pub(crate) pitch: Jet,
    /// About x, rad, right side down positive.
    pub(crate) roll: Jet,
}

/// A smooth motion.
pub(crate) trait Trajectory: Send + Sync {
    /// The pose at a time since the beginning, s; at rest before it.
    fn pose(&self, time_s: f64) -> PoseJet;
}

/// The trajectory as configured; the generator draws what distinguishes one camera from another.
pub(crate) fn build(synthetic: &Synthetic, rng: &mut ChaCha8Rng) -> Arc<dyn Trajectory> {
    let drawn = drawn(synthetic, rng);
    match synthetic.heading_deg {
        Some(heading_deg) => Arc::new(turned::Turned::to(heading_deg.to_radians(), drawn)),
        None => drawn,
    }
}

fn drawn(synthetic: &Synthetic, rng: &mut ChaCha8Rng) -> Arc<dyn Trajectory> {
    let rest_s = synthetic.rest_s;
    match synthetic.trajectory {
        TrajectoryKind::Standing => {
            let [pitch, roll] =
                [synthetic.pitch_deg, synthetic.roll_deg].map(|angle| angle.map(f64::to_radians));
            Arc::new(standing::Standing::drawn(rng).tilted(pitch, roll))
        }
        TrajectoryKind::Walk => Arc::new(walk::Walk::drawn(rest_s, rng)),
        TrajectoryKind::Stairs => Arc::new(stairs::Stairs::drawn(rest_s, synthetic.halt_s, rng)),
        TrajectoryKind::ModelVehicle => Arc::new(model_vehicle::ModelVehicle::drawn(rest_s, rng)),
        TrajectoryKind::Car => Arc::new(car::Car::drawn(rest_s, rng)),
        TrajectoryKind::Turns => Arc::new(turning::Turning::turns(rest_s, synthetic.arm_m, rng)),
        TrajectoryKind::Tumble => Arc::new(turning::Turning::tumble(rest_s, synthetic.arm_m, rng)),
        TrajectoryKind::Circles => {
            Arc::new(circles::Circles::drawn(rest_s, synthetic.tilt_deg.to_radians(), rng))
        }
    }
}

/// +1 or −1: whether a layout is mirrored.
fn drawn_side(rng: &mut ChaCha8Rng) -> f64 {
    if rng.random_bool(0.5) { 1.0 } else { -1.0 }
}

/// A heading, anywhere in the full circle, rad.
fn drawn_heading(rng: &mut ChaCha8Rng) -> f64 {
    rng.random_range(-std::f64::consts::PI..std::f64::consts::PI)
}

/// A way to go with a speed to go at, for trajectories on a laid-out path.
struct Leg {
    segments: Vec<path::Segment>,
    cruise_m_s: f64,
    exit_m_s: f64,
    /// Rest at the end; only where `exit_m_s` is zero.
    pause_s: f64,
}

impl Leg {
    /// Travels one segment and goes on.
    fn through(segment: path::Segment, cruise_m_s: f64, exit_m_s: f64) -> Self {
        Self { segments: vec![segment], cruise_m_s, exit_m_s, pause_s: 0.0 }
    }

    /// Travels one segment and stops at its end.
    fn to_stop(segment: path::Segment, cruise_m_s: f64, pause_s: f64) -> Self {
        Self { segments: vec![segment], cruise_m_s, exit_m_s: 0.0, pause_s }
    }
}

/// Lays legs as a path of `times` equal blocks with the speed plan that belongs to it.
fn lay(
    legs: &[Leg],
    times: usize,
    heading_rad: f64,
    mut builder: plan::PlanBuilder,
) -> (path::Path, plan::Plan) {
    let block: Vec<_> = legs.iter().flat_map(|leg| leg.segments.iter().copied()).collect();
    for leg in std::iter::repeat_n(legs, times).flatten() {
        let length_m = leg.segments.iter().map(|s| s.length_m).sum();
        builder.leg(length_m, leg.cruise_m_s, leg.exit_m_s);
        if leg.pause_s > 0.0 {
            builder.pause(leg.pause_s);
        }
    }
    (path::Path::repeated(heading_rad, &block, times), builder.finish())
}
