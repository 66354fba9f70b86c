//! Solids: boxes, upright cylinders and balls.

use glam::{DVec2, DVec3};
use lodestone_config::model;

use super::RoomFrame;
use super::paint::Palette;

/// The shape of a solid, around its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shape {
    /// A box, by half its sides, m.
    Box {
        /// Along its own x, y and z.
        half_m: DVec3,
    },
    /// A cylinder whose axis is upright.
    Cylinder {
        /// Its radius, m.
        radius_m: f64,
        /// Half its height, m.
        half_height_m: f64,
    },
    /// A ball.
    Ball {
        /// Its radius, m.
        radius_m: f64,
    },
}

impl Shape {
    /// Radius of the smallest sphere around it, m.
    pub(super) fn bounding_radius_m(&self) -> f64 {
        match *self {
            Self::Box { half_m } => half_m.length(),
            Self::Cylinder { radius_m, half_height_m } => radius_m.hypot(half_height_m),
            Self::Ball { radius_m } => radius_m,
        }
    }

    /// Distance from its surface, m, negative inside, of a point in its own frame.
    pub(super) fn signed_distance_m(&self, point: DVec3) -> f64 {
        match *self {
            Self::Box { half_m } => {
                let beyond = point.abs() - half_m;
                beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0)
            }
            Self::Cylinder { radius_m, half_height_m } => {
                let across = point.truncate().length() - radius_m;
                let beyond = DVec2::new(across, point.z.abs() - half_height_m);
                beyond.max(DVec2::ZERO).length() + beyond.max_element().min(0.0)
            }
            Self::Ball { radius_m } => point.length() - radius_m,
        }
    }
}

/// A shape at a place in the room frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Solid {
    pub(super) shape: Shape,
    /// Its centre in the room frame, m.
    pub(super) centre_m: DVec3,
    /// From its own axes to the room's, anticlockwise about z, rad.
    pub(super) turn_rad: f64,
    pub(super) palette: Palette,
}

impl Solid {
    pub(super) fn of_box(settings: &model::SceneBox, frame: &RoomFrame) -> Self {
        Self {
            shape: Shape::Box { half_m: DVec3::from_array(settings.size_m) * 0.5 },
            centre_m: frame.point(settings.centre_m.into()),
            turn_rad: frame.heading_rad - settings.heading_deg.to_radians(),
            palette: Palette::new(settings.colour, settings.pattern, settings.pattern_m),
        }
    }

    pub(super) fn of_cylinder(settings: &model::Cylinder, frame: &RoomFrame) -> Self {
        Self {
            shape: Shape::Cylinder {
                radius_m: settings.radius_m,
                half_height_m: 0.5 * settings.height_m,
            },
            centre_m: frame.point(settings.centre_m.into()),
            turn_rad: 0.0,
            palette: Palette::new(settings.colour, settings.pattern, settings.pattern_m),
        }
    }

    /// A point of the room frame in the solid's own, m.
    pub(super) fn local(&self, point: DVec3) -> DVec3 {
        turned(point - self.centre_m, -self.turn_rad)
    }

    /// Whether a point of the room frame is inside.
    #[cfg(test)]
    pub(super) fn holds(&self, point: DVec3) -> bool {
        self.shape.signed_distance_m(self.local(point)) < 0.0
    }

    /// Distance of a point of the room frame to the surface, from either side, m.
    pub(super) fn distance_m(&self, point: DVec3) -> f64 {
        self.shape.signed_distance_m(self.local(point)).abs()
    }
}

/// A vector turned anticlockwise about z.
pub(super) fn turned(vector: DVec3, angle_rad: f64) -> DVec3 {
    DVec2::from_angle(angle_rad).rotate(vector.truncate()).extend(vector.z)
}
