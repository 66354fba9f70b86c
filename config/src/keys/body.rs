//! Every key of a rigid body.

use super::Kind::{Switch, Text, Vector};
use super::range::plus_minus;
use super::realtime::BODY_CPU;
use super::text::Text::CameraName;
use super::{Key, key};

pub(super) const BODY: &[Key] = &[
    key("name", Text(CameraName), "", "Its name, unlike any other body's and any camera's.")
        .required(),
    key(
        "vehicle",
        Switch,
        "",
        "Whether it is a road vehicle: x points where it drives, the origin is in the middle of the \
         axle that does not steer (the rear one), where it moves neither sideways nor up and down. \
         A speed counts along x. Not for boats, aircraft, or wheels that roll to every side.",
    ),
    key(
        "antenna_m",
        Vector(plus_minus(100.0)),
        "m",
        "Where the antenna of a satellite receiver is on the body: position fixes in a recording, if they \
         come without an orientation, are its place. Without this key they are the camera's.",
    ),
    key(
        "gradient",
        Switch,
        "",
        "Whether the magnetic field's gradient between its cameras tells the velocity where steel makes \
         it strong enough. It needs three cameras or more, not in a line, calibrated, with their \
         magnetometers' places surveyed to centimetres.",
    ),
    BODY_CPU,
];
