//! The scene from one place at one instant, ready for rays.

use glam::{DMat3, DVec3, Mat3, Vec3};
use lodestone_client::{Optical, Transform, World};

use super::shape::{Shape, Solid, turned};
use super::{Room, Scene};

/// The scene from a camera, in single precision: a micrometre within a room.
#[derive(Clone, Debug)]
pub(super) struct View<'s> {
    pub(super) room: &'s Room,
    pub(super) half_m: Vec3,
    /// Where the rays begin, room frame, m.
    pub(super) origin_m: Vec3,
    /// Optical axes to the room's.
    pub(super) room_from_optical: Mat3,
    pub(super) solids: Vec<SeenSolid>,
}

/// A solid from where the rays begin.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenSolid {
    pub(super) solid: Solid,
    pub(super) kind: Kind,
    /// Where the rays begin, in the solid's own frame, m.
    pub(super) origin_m: Vec3,
    /// Cosine and sine of the turn from the room's axes to the solid's.
    pub(super) turn: (f32, f32),
    pub(super) bound: Bound,
}

/// A shape in single precision.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    Box { half_m: Vec3 },
    Cylinder { radius_m: f32, half_height_m: f32 },
    Ball { radius_m: f32 },
}

/// The cone of directions, in the optical frame, in which something may be seen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bound {
    /// Unit vector to its middle.
    axis: Vec3,
    /// Cosine and sine of half its opening; the sine is 1 where the eye is inside.
    cos: f32,
    sin: f32,
}

impl Bound {
    /// The cone round a sphere.
    fn of_sphere(centre: Vec3, radius: f32) -> Self {
        let distance = centre.length();
        if distance <= radius {
            return Self { axis: Vec3::Z, cos: -1.0, sin: 0.0 };
        }
        let sin = radius / distance;
        Self { axis: centre / distance, cos: (1.0 - sin * sin).sqrt(), sin }
    }

    /// The cone round some directions.
    pub(super) fn of_directions(directions: &[Vec3]) -> Self {
        let sum: Vec3 = directions.iter().map(|d| d.normalize()).sum();
        let axis = sum.normalize();
        let cos = directions.iter().map(|d| axis.dot(d.normalize())).fold(1.0, f32::min);
        // A little wider, for what rounding costs.
        let cos = cos - 1e-5;
        Self { axis, cos, sin: (1.0 - cos * cos).max(0.0).sqrt() }
    }

    /// Whether two cones have a direction in common: the angle between their axes is at most the sum of
    /// their half openings.
    pub(super) fn meets(&self, other: &Self) -> bool {
        let open = other.cos < 0.0 || self.cos < 0.0;
        open || self.axis.dot(other.axis) >= self.cos * other.cos - self.sin * other.sin
    }
}

impl Scene {
    /// The scene from a camera at a time, `CLOCK_MONOTONIC`, ns.
    pub(super) fn view(
        &self,
        world_from_optical: Transform<World, Optical>,
        time_ns: i64,
    ) -> View<'_> {
        let turn_rad = self.frame.heading_rad;
        let origin = self.frame.point(world_from_optical.origin());
        let axes = world_from_optical.rotation().matrix();
        let column = |axis: DVec3| turned(axis, turn_rad);
        let room_from_optical =
            DMat3::from_cols(column(axes.x_axis), column(axes.y_axis), column(axes.z_axis));
        let seen = |solid| SeenSolid::new(solid, origin, &room_from_optical);
        View {
            room: &self.room,
            half_m: self.room.half_m.as_vec3(),
            origin_m: origin.as_vec3(),
            room_from_optical: room_from_optical.as_mat3(),
            solids: self.solids_at(time_ns).map(seen).collect(),
        }
    }
}

impl SeenSolid {
    fn new(solid: Solid, eye: DVec3, room_from_optical: &DMat3) -> Self {
        let (sin, cos) = solid.turn_rad.sin_cos();
        let centre = room_from_optical.transpose() * (solid.centre_m - eye);
        Self {
            solid,
            kind: Kind::of(solid.shape),
            origin_m: solid.local(eye).as_vec3(),
            turn: (cos as f32, -sin as f32),
            bound: Bound::of_sphere(centre.as_vec3(), solid.shape.bounding_radius_m() as f32),
        }
    }

    /// A direction of the room frame in the solid's own.
    pub(super) fn local(&self, direction: Vec3) -> Vec3 {
        let (cos, sin) = self.turn;
        let Vec3 { x, y, z } = direction;
        Vec3::new(cos * x - sin * y, sin * x + cos * y, z)
    }
}

impl Kind {
    fn of(shape: Shape) -> Self {
        match shape {
            Shape::Box { half_m } => Self::Box { half_m: half_m.as_vec3() },
            Shape::Cylinder { radius_m, half_height_m } => {
                Self::Cylinder { radius_m: radius_m as f32, half_height_m: half_height_m as f32 }
            }
            Shape::Ball { radius_m } => Self::Ball { radius_m: radius_m as f32 },
        }
    }
}
