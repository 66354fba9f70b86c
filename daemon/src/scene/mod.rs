//! The scene around synthetic cameras: what depth sources see, and what clouds are scored against.
//!
//! ```text
//! configuration ─> Scene ─┬─ view at one instant ─> rays ─> depth camera ─> cloud
//!                         └─ distance of a point to the nearest surface
//! ```
//!
//! A [`Scene`] is a room with [`Solid`]s in it and something that moves. A `View` is the scene from
//! one place at one instant, in single precision, ready for rays; the [`DepthCamera`] casts them.
//! The estimator knows nothing of any of it.
//!
//! Everything is kept in the *room frame*: origin in the room's centre, axes along its walls, z up.
//! So numbers stay small wherever in the world the room is.

mod camera;
mod mover;
mod paint;
mod rays;
mod shape;
mod stereo;
mod view;

#[cfg(test)]
mod tests;

use glam::DVec3;
use lodestone_config::model;

pub use camera::{DepthCamera, Frame};
use mover::Mover;
use paint::Palette;
#[cfg(test)]
use shape::Shape;
use shape::Solid;

/// A room, furniture, and what moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    frame: RoomFrame,
    room: Room,
    solids: Vec<Solid>,
    mover: Option<Mover>,
}

/// Where the room is in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
struct RoomFrame {
    centre_m: DVec3,
    heading_rad: f64,
}

impl RoomFrame {
    /// Turns a vector of W into the room frame; the heading is clockwise, so this is anticlockwise.
    fn turn(&self, vector: DVec3) -> DVec3 {
        shape::turned(vector, self.heading_rad)
    }

    fn point(&self, world_m: DVec3) -> DVec3 {
        self.turn(world_m - self.centre_m)
    }
}

/// The room itself, in its own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Room {
    half_m: DVec3,
    palette: Palette,
    floor: bool,
    ceiling: bool,
}

impl Room {
    fn new(room: &model::Room) -> Self {
        Self {
            half_m: DVec3::from_array(room.size_m) * 0.5,
            palette: Palette::of_room(room),
            floor: room.floor,
            ceiling: room.ceiling,
        }
    }

    /// Distance of a point to the nearest of the faces that are there, m.
    fn distance_m(&self, point: DVec3) -> f64 {
        let beyond = (point.abs() - self.half_m).max(DVec3::ZERO);
        let mut nearest = f64::INFINITY;
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let there = axis != 2 || if side < 0.0 { self.floor } else { self.ceiling };
                let mut offset = beyond;
                offset[axis] = point[axis] - side * self.half_m[axis];
                if there {
                    nearest = nearest.min(offset.length());
                }
            }
        }
        nearest
    }

    fn holds(&self, point: DVec3) -> bool {
        point.abs().cmplt(self.half_m).all()
    }
}

impl Scene {
    /// Builds a configured scene.
    pub fn new(scene: &model::Scene) -> Self {
        let frame = RoomFrame {
            centre_m: scene.room.centre_m.into(),
            heading_rad: scene.room.heading_deg.to_radians(),
        };
        let boxes = scene.boxes.iter().map(|b| Solid::of_box(b, &frame));
        let cylinders = scene.cylinder.iter().map(|c| Solid::of_cylinder(c, &frame));
        Self {
            room: Room::new(&scene.room),
            solids: boxes.chain(cylinders).collect(),
            mover: scene.mover.as_ref().map(|mover| Mover::new(mover, &frame)),
            frame,
        }
    }

    /// Distance of a point of W to the nearest surface, m, on whichever side of it the point is.
    ///
    /// What moves counts where it is at the time, `CLOCK_MONOTONIC`, ns; without a time it is not there.
    /// Surfaces that nobody can see, such as a cupboard's back on the wall, count as well.
    pub fn distance_m(&self, point_m: DVec3, time_ns: Option<i64>) -> f64 {
        let point = self.frame.point(point_m);
        let still = self.solids.iter().map(|solid| solid.distance_m(point));
        let moving = time_ns.and_then(|at| self.moving_at(at)).map(|solid| solid.distance_m(point));
        still.chain(moving).fold(self.room.distance_m(point), f64::min)
    }

    fn moving_at(&self, time_ns: i64) -> Option<Solid> {
        self.mover.as_ref().map(|mover| mover.solid_at(time_ns))
    }

    /// Every solid as it is at a time, `CLOCK_MONOTONIC`, ns.
    fn solids_at(&self, time_ns: i64) -> impl Iterator<Item = Solid> {
        self.solids.iter().copied().chain(self.moving_at(time_ns))
    }

    /// Whether what moves comes within a margin, m, of a point of W somewhere on its way.
    pub fn is_swept(&self, point_m: DVec3, margin_m: f64) -> bool {
        let point = self.frame.point(point_m);
        self.mover.as_ref().is_some_and(|mover| mover.sweeps(point, margin_m))
    }

    /// Whether a point of W is inside the room; from outside nothing is seen.
    pub fn holds(&self, point_m: DVec3) -> bool {
        self.room.holds(self.frame.point(point_m))
    }
}
