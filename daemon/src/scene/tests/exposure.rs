//! What a perfect camera sees.

use std::convert::Infallible;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_6};

use glam::DVec3;
use lodestone_client::{Body, Transform, World, body_from_optical_axes};
use lodestone_config::model::{self, Camera, Depth};
use lodestone_schema::CloudPoint;
use proptest::prelude::*;

use super::super::{DepthCamera, Frame, Scene};
use super::{FIRST, bare, camera, exposed, furnished, in_world, perfect, pose};

/// The point in the middle, of a camera with odd numbers of columns and rows.
fn middle(depth: Depth, scene: &Scene, place: Transform<World, Body>) -> CloudPoint {
    let depth = Depth { width: 49, height: 33, ..depth };
    exposed(&camera(depth), scene, place, FIRST)[16 * 49 + 24]
}

#[test]
fn a_wall_straight_ahead_is_flat_at_its_depth() {
    let scene = Scene::new(&bare());
    // 3 m east of the origin; 25° to either side the corners are not reached, nor the ceiling.
    let narrow = camera(Depth { field_of_view_deg: 50.0, ..perfect() });
    for point in exposed(&narrow, &scene, pose([0.0; 3], [0.0; 3]), FIRST) {
        assert!((point.position_m[2] - 3.0).abs() < 1e-6, "{point:?}");
        assert_eq!(point.colour[3], 255);
    }
}

#[test]
fn rows_and_columns_spread_as_the_field_of_view_says() {
    let scene = Scene::new(&bare());
    let cloud = exposed(&camera(perfect()), &scene, pose([0.0; 3], [0.0; 3]), FIRST);
    let slope = |point: &CloudPoint| {
        let [x, y, z] = point.position_m.map(f64::from);
        (x / z, y / z)
    };
    let (left, top) = slope(&cloud[0]);
    let (right, bottom) = slope(&cloud[50 * 33 - 1]);
    // 90° over 50 pixels: the middles of the outer ones are at 49/50 of a slope of 1.
    assert!((left + 0.98).abs() < 1e-6 && (right - 0.98).abs() < 1e-6, "{left} {right}");
    assert!((top + 0.64).abs() < 1e-6 && (bottom - 0.64).abs() < 1e-6, "{top} {bottom}");
}

#[test]
fn a_turned_camera_sees_the_wall_it_is_turned_to() {
    let scene = Scene::new(&bare());
    for (angles, expected_m) in [
        ([FRAC_PI_6, 0.0, 0.0], 3.0 / FRAC_PI_6.cos()),
        ([FRAC_PI_2, 0.0, 0.0], 2.5),
        ([0.0, FRAC_PI_2, 0.0], 1.5),
        ([-FRAC_PI_2, 0.0, 1.0], 2.5),
    ] {
        let depth = f64::from(middle(perfect(), &scene, pose([0.0; 3], angles)).position_m[2]);
        assert!((depth - expected_m).abs() < 1e-5, "{angles:?}: {depth}");
    }
}

#[test]
fn rays_begin_at_the_lens() {
    let scene = Scene::new(&bare());
    let settings = Camera {
        depth: Some(perfect()),
        lens_position_m: Some([0.1, 0.06, 0.0]),
        ..Camera::default()
    };
    let cloud = exposed(&DepthCamera::new(&settings, 0), &scene, pose([0.0; 3], [0.0; 3]), FIRST);
    let ahead = cloud[50 * 16 + 25].position_m[2];
    assert!((ahead - 2.9).abs() < 1e-6, "{ahead}");
}

#[test]
fn what_stands_before_the_wall_hides_it_and_a_box_around_the_eye_is_not_seen() {
    let chest =
        |centre_m| model::SceneBox { centre_m, size_m: [0.5; 3], ..model::SceneBox::default() };
    let scene = model::Scene { boxes: vec![chest([2.0, 0.0, 0.0]), chest([0.0; 3])], ..bare() };
    let point = middle(perfect(), &Scene::new(&scene), pose([0.0; 3], [0.0; 3]));
    assert!((point.position_m[2] - 1.75).abs() < 1e-6, "{point:?}");
}

#[test]
fn there_is_no_depth_where_there_is_nothing_and_none_from_outside() {
    let open = model::Room { ceiling: false, ..bare().room };
    let scene = Scene::new(&model::Scene { room: open, ..model::Scene::default() });
    let upward = middle(perfect(), &scene, pose([0.0; 3], [0.0, -FRAC_PI_2, 0.0]));
    assert!(upward.position_m[0].is_nan() && upward.colour == [0; 4], "{upward:?}");
    let outside = exposed(&camera(perfect()), &scene, pose([3.5, 0.0, 0.0], [0.0; 3]), FIRST);
    assert!(outside.iter().all(|point| point.position_m[2].is_nan()));
}

/// Poses somewhere inside the furnished room.
fn poses() -> impl Strategy<Value = Transform<World, Body>> {
    let angles = [-3.2..3.2_f64, -1.5..1.5, -0.6..0.6];
    ([-1.6..1.6_f64, -1.6..1.6, -1.3..1.3], angles)
        .prop_map(|(position_m, angles)| pose(position_m, angles))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn every_point_is_on_a_surface_and_nothing_is_in_its_way(
        place in poses(),
        time_ns in 0..20_000_000_000_i64,
    ) {
        let scene = Scene::new(&furnished());
        let frame = Frame { number: 0, time_ns };
        let eye = place.origin();
        let inside = |point: DVec3| scene.solids_at(time_ns).any(|solid| solid.holds(scene.frame.point(point)));
        prop_assume!(scene.holds(eye) && !inside(eye));
        for point in exposed(&camera(perfect()), &scene, place, frame) {
            let end = in_world(place, &point);
            prop_assert!(scene.distance_m(end, Some(time_ns)) < 2e-5, "{end}");
            // Rounding may graze an edge; half a millimetre short of the end nothing is entered.
            let way = end - eye;
            for part in 1..16 {
                let on_the_way = eye + way * (f64::from(part) / 16.0 - 1e-4);
                prop_assert!(!inside(on_the_way), "{on_the_way} before {end}");
            }
        }
    }
}

#[test]
fn a_rolling_shutter_sees_each_row_at_its_own_time() {
    const RATE_RAD_S: f64 = 1.5;
    let scene = Scene::new(&furnished());
    let rolling = camera(Depth { rolling_shutter_s: 0.02, ..perfect() });
    let place = |time_ns: i64| {
        let since_s = (time_ns - FIRST.time_ns) as f64 * 1e-9;
        pose([0.1 + 0.8 * since_s, -0.2, 0.3], [RATE_RAD_S * since_s, 0.1, 0.0])
    };
    let nothing = CloudPoint { position_m: [0.0; 3], time_offset_ns: -1, colour: [0; 4] };
    let mut cloud = vec![nothing; rolling.points()];
    let Ok(()) = rolling.expose(&scene, FIRST, |t| Ok::<_, Infallible>(place(t)), &mut cloud);
    let worst = |at: &dyn Fn(&CloudPoint) -> i64| {
        let off = cloud.iter().map(|point| {
            let seen_ns = FIRST.time_ns + i64::from(point.time_offset_ns);
            let optical = DVec3::from_array(point.position_m.map(f64::from));
            let end = (place(at(point)) * body_from_optical_axes()).apply(optical);
            scene.distance_m(end, Some(seen_ns))
        });
        off.fold(0.0, f64::max)
    };
    let compensated = worst(&|point| FIRST.time_ns + i64::from(point.time_offset_ns));
    let not = worst(&|_| FIRST.time_ns);
    assert!(compensated < 2e-5, "{compensated}");
    assert!(not > 0.03, "{not}");
    let (first, last) = (cloud[0].time_offset_ns, cloud[50 * 33 - 1].time_offset_ns);
    assert!(first >= 0 && last <= 20_000_000 && last > 18_000_000, "{first} {last}");
}

#[test]
fn a_pose_that_is_not_known_is_handed_on() {
    let scene = Scene::new(&bare());
    let camera = camera(perfect());
    let mut cloud = exposed(&camera, &scene, pose([0.0; 3], [0.0; 3]), FIRST);
    let unknown = camera.expose(&scene, FIRST, |_| Err("unknown"), &mut cloud);
    assert_eq!(unknown, Err("unknown"));
}
