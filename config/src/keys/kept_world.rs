//! Every key of the file that keeps the world.

use super::Kind::{Choice, Number, Switch, Text, Vector, Whole};
use super::range::{from_to, plus_minus};
use super::text::Text::CameraName;
use super::{Key, Schema, Section, Shape, key};

/// The file that keeps the world.
pub(crate) static KEPT_WORLD: Schema = Schema {
    sections: &[
        Section {
            path: "",
            shape: Shape::Root,
            meaning: "The world as it was fixed; written by the daemon.",
            keys: ROOT,
        },
        Section {
            path: "camera",
            shape: Shape::List,
            meaning: "Where a camera or body was last.",
            keys: CAMERA,
        },
    ],
};

/// A turn has no more than half a circle, rad.
const HALF_TURN: f64 = 3.2;

const ROOT: &[Key] = &[
    key("format", Whole(1, 1), "", "Version of this file's format.").required(),
    key("epoch", Whole(1, u32::MAX as i64), "", "Epoch of the world.").required(),
    key("t0_unix_ns", Whole(0, i64::MAX), "ns", "When it was fixed.").required(),
    key("north", Choice(&["magnetic", "true"]), "", "Which north its y axis points to.").required(),
    key("first_camera", Text(CameraName), "", "The camera or body that fixed it.").required(),
    key("starts_hold", Switch, "", "Whether configured starts are places in it.").required(),
    key("rotation_rad", Vector(plus_minus(HALF_TURN)), "rad", "First camera's rotation at t0.")
        .required(),
    key("heading_sigma_rad", Number(from_to(0.0, 10.0)), "rad", "Of that rotation.").required(),
    key("tilt_sigma_rad", Number(from_to(0.0, 10.0)), "rad", "Of that rotation.").required(),
    key("field_ut", Vector(plus_minus(1e4)), "µT", "Field at t0, in the world."),
    key("magnetometer_position_m", Vector(plus_minus(200.0)), "m", "In the first camera's axes.")
        .required(),
];

const CAMERA: &[Key] = &[
    key("name", Text(CameraName), "", "Name of the camera or body.").required(),
    key("position_m", Vector(plus_minus(1e7)), "m", "Where it was last.").required(),
    key("sigma_m", Vector(from_to(0.0, 1e7)), "m", "How well that was known, per axis.").required(),
    key(
        "source",
        Choice(&["common-start", "cloud-registration", "magnetic-gradient", "position-fix"]),
        "",
        "Where it was known from.",
    )
    .required(),
];
