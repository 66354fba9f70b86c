//! What moves in the room: where it is at a time.

use std::f64::consts::TAU;

use glam::DVec3;
use lodestone_config::model::{MoverShape, SceneMover};

use super::RoomFrame;
use super::paint::Palette;
use super::shape::{Shape, Solid, turned};

/// Something that goes round an ellipse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mover {
    /// The solid in the middle of its way.
    at_centre: Solid,
    /// Half axes of its way, east and north, m.
    reach_m: DVec3,
    /// From the world's axes to the room's, anticlockwise, rad.
    turn_rad: f64,
    period_ns: i64,
}

impl Mover {
    pub(super) fn new(settings: &SceneMover, frame: &RoomFrame) -> Self {
        let half_m = 0.5 * settings.size_m;
        let shape = match settings.shape {
            MoverShape::Cube => Shape::Box { half_m: DVec3::splat(half_m) },
            MoverShape::Ball => Shape::Ball { radius_m: half_m },
        };
        Self {
            at_centre: Solid {
                shape,
                centre_m: frame.point(settings.centre_m.into()),
                turn_rad: frame.heading_rad,
                palette: Palette::new(settings.colour, settings.pattern, settings.pattern_m),
            },
            reach_m: DVec3::new(settings.reach_east_m, settings.reach_north_m, 0.0),
            turn_rad: frame.heading_rad,
            period_ns: ((settings.period_s * 1e9).round() as i64).max(1),
        }
    }

    /// The solid where it is at a time, `CLOCK_MONOTONIC`, ns.
    pub(super) fn solid_at(&self, time_ns: i64) -> Solid {
        // Whole nanoseconds: after months the phase is as exact as at the start.
        self.solid_at_phase(time_ns.rem_euclid(self.period_ns) as f64 / self.period_ns as f64)
    }

    fn solid_at_phase(&self, phase: f64) -> Solid {
        let (sin, cos) = (TAU * phase).sin_cos();
        let offset = turned(self.reach_m * DVec3::new(cos, sin, 0.0), self.turn_rad);
        Solid { centre_m: self.at_centre.centre_m + offset, ..self.at_centre }
    }

    /// Whether it comes within a margin of a point of the room frame, m.
    pub(super) fn sweeps(&self, point: DVec3, margin_m: f64) -> bool {
        const LOOKS: u32 = 256;
        // Between two looks it goes on by less than this.
        let step_m = self.reach_m.length() * TAU / f64::from(LOOKS);
        // Most points are nowhere near its way.
        let reach_m = self.reach_m.max_element() + self.at_centre.shape.bounding_radius_m();
        if point.distance(self.at_centre.centre_m) > reach_m + margin_m + step_m {
            return false;
        }
        (0..LOOKS).any(|look| {
            let solid = self.solid_at_phase(f64::from(look) / f64::from(LOOKS));
            solid.shape.signed_distance_m(solid.local(point)) < margin_m + 0.5 * step_m
        })
    }
}
