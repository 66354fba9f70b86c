//! Where a sensor was while it saw a cloud.

use glam::{DVec3, Mat3, Vec3};
use lodestone_schema::Validity;

use crate::error::LookupError;
use crate::frame::{Body, Frame, World};
use crate::pose::CameraPose;
use crate::time::Time;
use crate::transform::Transform;

/// Poses are looked up this far apart, ns; in between the motion is straight.
///
/// A turn at 10 rad/s between two knots bends by 0.02 rad: the straight way is 5e-5 of a point's distance
/// off (the sagitta, θ²/8), 0.25 mm at 5 m.
pub const KNOT_STEP_NS: i64 = 2_000_000;

/// Furthest time of a point from its cloud's time, ns; what claims more is not used.
///
/// Bounds the knots to 257, whatever a source claims. A rolling shutter takes some 30 ms, a turn of a lidar
/// 100 ms.
pub const MOST_OFFSET_NS: i64 = 256_000_000;

/// Why a cloud has no motion.
#[derive(Clone, Debug, thiserror::Error)]
pub enum MotionError {
    /// There is no pose at one of its times.
    #[error(transparent)]
    Lookup(#[from] LookupError),
    /// The filter began anew, or the world was defined anew, while the cloud was seen.
    #[error("the pose was re-initialised while the cloud was seen")]
    Broken,
}

/// Where the axes of a sensor were in the world over the time of a cloud.
///
/// Positions are kept relative to [`Motion::origin_m`], the sensor's place at the cloud's time, so that f32
/// holds a micrometre wherever in the world the camera is.
#[derive(Clone, Debug)]
pub struct Motion {
    pose: CameraPose,
    origin_m: DVec3,
    /// Of the first knot, after the cloud's time, ns.
    first_offset_ns: i64,
    steps_per_ns: f32,
    /// At least two, evenly over the span.
    knots: Vec<Placement>,
}

/// Sensor coordinates to the world's axes, relative to the cloud's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placement {
    rotation: Mat3,
    translation_m: Vec3,
}

impl Placement {
    /// A point, m.
    #[inline]
    pub(crate) fn apply(&self, point_m: Vec3) -> Vec3 {
        self.rotation * point_m + self.translation_m
    }

    /// Which way a direction of the sensor points in the world.
    pub(crate) fn turn(&self, direction: Vec3) -> Vec3 {
        self.rotation * direction
    }

    /// Straight between two; not quite a rotation, see [`KNOT_STEP_NS`].
    #[inline]
    fn between(a: &Self, b: &Self, s: f32) -> Self {
        Self {
            rotation: a.rotation * (1.0 - s) + b.rotation * s,
            translation_m: a.translation_m + (b.translation_m - a.translation_m) * s,
        }
    }
}

impl Motion {
    /// The motion of a sensor at `body_from_sensor` over the times of a cloud's points, offsets from its
    /// time, ns; cut to [`MOST_OFFSET_NS`].
    ///
    /// # Errors
    /// [`MotionError`].
    pub fn over<S: Frame>(
        time_ns: i64,
        (first_ns, last_ns): (i64, i64),
        body_from_sensor: Transform<Body, S>,
        mut lookup: impl FnMut(Time, Validity) -> Result<CameraPose, LookupError>,
    ) -> Result<Self, MotionError> {
        let mut at = |offset_ns: i64| {
            let time = Time::Monotonic(time_ns.saturating_add(offset_ns));
            lookup(time, Validity::HEADING | Validity::POSITION)
        };
        let pose = at(0)?;
        let placed = |pose: &CameraPose| {
            pose.world_from_body().map(|p| p * body_from_sensor).map_err(LookupError::from)
        };
        let origin_m = placed(&pose)?.origin();
        let first = first_ns.clamp(-MOST_OFFSET_NS, MOST_OFFSET_NS);
        let span = last_ns.clamp(first, MOST_OFFSET_NS) - first;
        let steps = ((span + KNOT_STEP_NS - 1) / KNOT_STEP_NS).max(1);
        let mut knots = Vec::with_capacity(steps as usize + 1);
        for step in 0..=steps {
            let found = at(first + span * step / steps)?;
            if !is_comparable(&found, &pose) {
                return Err(MotionError::Broken);
            }
            knots.push(relative(placed(&found)?, origin_m));
        }
        let steps_per_ns = if span > 0 { steps as f32 / span as f32 } else { 0.0 };
        Ok(Self { pose, origin_m, first_offset_ns: first, steps_per_ns, knots })
    }

    /// The pose at the cloud's time.
    pub const fn pose(&self) -> &CameraPose {
        &self.pose
    }

    /// Where the sensor was at the cloud's time in the world, m.
    pub const fn origin_m(&self) -> DVec3 {
        self.origin_m
    }

    /// Where the sensor was at an offset from the cloud's time; outside its span, at the nearer end.
    #[inline]
    pub(crate) fn at(&self, offset_ns: i32) -> Placement {
        let since_first = (i64::from(offset_ns) - self.first_offset_ns).max(0);
        let way = since_first as f32 * self.steps_per_ns;
        // At the last knot, the last segment ends.
        let knot = (way as usize).min(self.knots.len() - 2);
        let (before, after) = (&self.knots[knot], &self.knots[knot + 1]);
        Placement::between(before, after, (way - knot as f32).min(1.0))
    }
}

/// Whether two poses are of one world and one run of the filter.
fn is_comparable(a: &CameraPose, b: &CameraPose) -> bool {
    (a.world_epoch(), a.reset_counter()) == (b.world_epoch(), b.reset_counter())
}

fn relative<S: Frame>(world_from_sensor: Transform<World, S>, origin_m: DVec3) -> Placement {
    Placement {
        rotation: world_from_sensor.rotation().matrix().as_mat3(),
        translation_m: (world_from_sensor.origin() - origin_m).as_vec3(),
    }
}

#[cfg(test)]
mod tests;
