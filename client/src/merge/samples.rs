//! Clouds for the tests of this directory.

use glam::DVec3;
use lodestone_schema::{CloudFields, CloudFrame, CloudHeader, CloudPoint, Pose};

use super::place::{PlacedCloud, Range};
use crate::cloud::{CloudInfo, Motion};
use crate::frame::Body;
use crate::pose::samples::{checked, still};
use crate::transform::Transform;

/// A point in body axes, m.
pub(crate) fn point(position_m: [f32; 3]) -> CloudPoint {
    CloudPoint { position_m, time_offset_ns: 0, colour: [10, 20, 30, 255] }
}

/// A coloured cloud in body axes, seen without moving.
pub(crate) fn header(points: usize, time_ns: i64) -> CloudHeader {
    CloudHeader {
        time_ns,
        width: points as u32,
        fields: CloudFields::COLOUR.bits(),
        frame: CloudFrame::Body.code(),
        ..CloudHeader::default()
    }
}

/// The same cloud in the world, seen by a camera that stands somewhere, level, looking east.
pub(crate) fn placed(
    camera: usize,
    time_ns: i64,
    origin_m: DVec3,
    points: &[CloudPoint],
) -> PlacedCloud {
    let info = CloudInfo::check(&header(points.len(), time_ns), points.len()).expect("is sound");
    let pose = Pose { position_m: origin_m.to_array(), ..still(1, time_ns) };
    let at_rest = Transform::<Body, Body>::IDENTITY;
    let motion =
        Motion::over(time_ns, (0, 0), at_rest, |_, _| Ok(checked(pose))).expect("is known");
    PlacedCloud::place(camera, (&info, points), motion, Range::default(), Vec::new())
}
