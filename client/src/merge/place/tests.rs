use glam::{DQuat, DVec3};
use lodestone_schema::{CloudFields, CloudHeader, CloudPoint, Pose};
use proptest::prelude::*;

use super::{PlacedCloud, PointCounts, Range, span_ns};
use crate::cloud::{CloudInfo, MOST_OFFSET_NS, Motion};
use crate::frame::Body;
use crate::merge::samples::{header, placed, point};
use crate::pose::samples::{checked, still};
use crate::transform::Transform;

const TIME_NS: i64 = 5_000_000_000;

/// A camera that turns about up at 2 rad/s.
fn turning(time_ns: i64) -> Pose {
    let angle = 2.0 * (time_ns - TIME_NS) as f64 * 1e-9;
    Pose { orientation: DQuat::from_rotation_z(angle).to_array(), ..still(1, time_ns) }
}

fn placed_turning(points: &[CloudPoint]) -> PlacedCloud {
    let fields = (CloudFields::POINT_TIME | CloudFields::COLOUR).bits();
    let header = CloudHeader { fields, ..header(points.len(), TIME_NS) };
    let info = CloudInfo::check(&header, points.len()).unwrap();
    let at_rest = Transform::<Body, Body>::IDENTITY;
    let lookup = |time: crate::Time, _| Ok(checked(turning(time.to_monotonic_ns(0))));
    let motion = Motion::over(TIME_NS, span_ns(&info, points), at_rest, lookup).unwrap();
    PlacedCloud::place(0, (&info, points), motion, Range::default(), Vec::new())
}

#[test]
fn what_has_no_place_is_counted_by_its_reason() {
    let points = [
        point([1.0, 0.0, 0.0]),
        point([f32::NAN, 0.0, 0.0]),
        point([0.0, f32::INFINITY, 0.0]),
        point([f32::MAX, f32::MAX, 0.0]),
        point([41.0, 0.0, 0.0]),
        point([0.0; 3]),
    ];
    let cloud = placed(0, TIME_NS, DVec3::ZERO, &points);
    let expected = PointCounts { placed: 1, without_depth: 2, out_of_range: 3, out_of_time: 0 };
    assert_eq!(cloud.counts(), expected);
    assert_eq!(cloud.positions_m().collect::<Vec<_>>(), [DVec3::X]);
}

#[test]
fn a_point_is_placed_by_the_pose_at_its_own_time() {
    // Given a wall ahead, seen row by row while the camera turns by 0.06 rad
    let rows: Vec<CloudPoint> = (0..30)
        .map(|row| {
            let time_offset_ns = row * 1_000_000;
            let angle = -2.0 * f64::from(time_offset_ns) * 1e-9;
            // Where the point (3, 0) of the world is in the turned body
            let seen = DVec3::new(3.0 * angle.cos(), 3.0 * angle.sin(), 0.0).as_vec3();
            CloudPoint { time_offset_ns, ..point(seen.to_array()) }
        })
        .collect();
    let cloud = placed_turning(&rows);
    for place in cloud.positions_m() {
        assert!(place.abs_diff_eq(DVec3::new(3.0, 0.0, 0.0), 1e-5), "{place}");
    }
    // And without their times they lie on an arc of 18 cm.
    let bent = placed(0, TIME_NS, DVec3::ZERO, &rows);
    assert!(bent.positions_m().any(|place| place.y < -0.17));
}

proptest! {
    #[test]
    fn whatever_a_source_claims_nothing_panics_and_all_is_counted(
        raw in prop::collection::vec(any::<([u32; 3], i32, [u8; 4])>(), 0..50),
    ) {
        let points: Vec<CloudPoint> = raw
            .into_iter()
            .map(|(bits, time_offset_ns, colour)| {
                CloudPoint { position_m: bits.map(f32::from_bits), time_offset_ns, colour }
            })
            .collect();
        let counts = placed_turning(&points).counts();
        let all =
            counts.placed + counts.without_depth + counts.out_of_range + counts.out_of_time;
        prop_assert_eq!(all, points.len() as u64);
    }
}

#[test]
fn a_time_that_no_shutter_takes_is_not_used() {
    let too_late = MOST_OFFSET_NS as i32 + 1;
    let points = [0, too_late, i32::MIN, i32::MAX]
        .map(|time_offset_ns| CloudPoint { time_offset_ns, ..point([1.0, 0.0, 0.0]) });
    let counts = placed_turning(&points).counts();
    assert_eq!((counts.placed, counts.out_of_time), (1, 3));
}
