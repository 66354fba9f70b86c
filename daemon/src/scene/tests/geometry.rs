//! Distances by hand, and the mover.

use glam::DVec3;
use lodestone_config::model;
use proptest::prelude::*;

use super::super::{Scene, Shape};
use super::{bare, furnished};

fn distance_m(scene: &Scene, point: [f64; 3]) -> f64 {
    scene.distance_m(point.into(), None)
}

#[test]
fn the_room_is_as_near_as_its_nearest_wall() {
    let scene = Scene::new(&bare());
    for (point, expected_m) in [
        ([0.0, 0.0, 0.0], 1.5),
        ([2.9, 0.0, 0.0], 0.1),
        ([3.2, 0.0, 0.0], 0.2),
        ([0.0, -2.4, 1.0], 0.1),
        ([3.3, 2.9, 0.0], 0.5),
    ] {
        assert!((distance_m(&scene, point) - expected_m).abs() < 1e-12, "{point:?}");
    }
    assert!(scene.holds(DVec3::new(2.9, 2.4, -1.4)) && !scene.holds(DVec3::new(3.1, 0.0, 0.0)));
}

#[test]
fn a_floor_that_is_not_there_is_no_surface() {
    let open = model::Room { floor: false, ..bare().room };
    let scene = Scene::new(&model::Scene { room: open, ..model::Scene::default() });
    assert!((distance_m(&scene, [0.0, 0.0, -1.4]) - 2.5).abs() < 1e-12, "the wall, not the floor");
    assert!((distance_m(&scene, [0.0, 0.0, 1.4]) - 0.1).abs() < 1e-12, "the ceiling");
}

#[test]
fn headings_turn_clockwise_seen_from_above() {
    let board = model::SceneBox {
        size_m: [2.0, 0.2, 0.2],
        heading_deg: 30.0,
        ..model::SceneBox::default()
    };
    let scene = Scene::new(&model::Scene { boxes: vec![board], ..bare() });
    // East by 30° toward south is where its end is.
    let end = DVec3::new(30_f64.to_radians().cos(), -30_f64.to_radians().sin(), 0.0);
    assert!(scene.distance_m(end, None) < 1e-12);
    assert!((scene.distance_m(end * 1.25, None) - 0.25).abs() < 1e-12);
    // A turned room: its eastern wall is 3 m to where its end would be.
    let turned = model::Room { heading_deg: 30.0, ..bare().room };
    let scene = Scene::new(&model::Scene { room: turned, ..model::Scene::default() });
    assert!(scene.distance_m(end * 3.0, None) < 1e-12);
}

/// A time on the clock that is a multiple of the mover's period, ns.
const SEVEN_MONTHS: i64 = 7_000_000_000 * 2_600_000;

#[test]
fn what_moves_goes_round_in_its_period_and_is_not_there_without_a_time() {
    let scene = Scene::new(&furnished());
    let settings = furnished().mover.expect("it moves");
    let place = |part: f64| {
        let (sin, cos) = (std::f64::consts::TAU * part).sin_cos();
        let offset = DVec3::new(settings.reach_east_m * cos, settings.reach_north_m * sin, 0.0);
        DVec3::from_array(settings.centre_m) + offset
    };
    for eighth in 0..8 {
        let part = f64::from(eighth) / 8.0;
        let time_ns = SEVEN_MONTHS + (part * 7e9) as i64;
        let on_it = place(part) + DVec3::new(0.0, 0.0, 0.25);
        assert!(scene.distance_m(on_it, Some(time_ns)) < 1e-8, "{eighth}");
        assert!(scene.distance_m(on_it, Some(time_ns + 1_000_000_000)) > 0.1, "{eighth}");
        assert!(scene.distance_m(on_it, None) > 0.1, "{eighth}");
        assert!(scene.is_swept(on_it, 0.02), "{eighth}");
    }
    assert!(!scene.is_swept(DVec3::from_array(settings.centre_m), 0.1), "the middle of its way");
}

fn shapes() -> impl Strategy<Value = Shape> {
    let size = 0.1..2.0_f64;
    prop_oneof![
        [size.clone(), size.clone(), size.clone()]
            .prop_map(|half| Shape::Box { half_m: half.into() }),
        (size.clone(), size.clone())
            .prop_map(|(radius_m, half_height_m)| Shape::Cylinder { radius_m, half_height_m }),
        size.prop_map(|radius_m| Shape::Ball { radius_m }),
    ]
}

proptest! {
    /// A distance changes by no more than its point moves, and is reached by some step.
    #[test]
    fn distances_are_distances(
        shape in shapes(),
        a in [-4.0..4.0_f64, -4.0..4.0, -4.0..4.0],
        step in [-0.5..0.5_f64, -0.5..0.5, -0.5..0.5],
    ) {
        let (a, step) = (DVec3::from_array(a), DVec3::from_array(step));
        let at = |p: DVec3| shape.signed_distance_m(p);
        prop_assert!((at(a + step) - at(a)).abs() <= step.length() + 1e-12);
        prop_assert!(at(a) <= a.length() && at(DVec3::ZERO) < 0.0);
        prop_assert!(a.length() <= at(a).max(0.0) + shape.bounding_radius_m() + 1e-12);
    }
}
