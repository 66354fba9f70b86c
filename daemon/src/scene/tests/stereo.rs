//! Noise, range, and points without depth.

use lodestone_config::model::{Camera, Depth};
use lodestone_schema::CloudPoint;

use super::super::{DepthCamera, Frame, Scene};
use super::{FIRST, bare, camera, exposed, perfect, pose};

/// Depths of a wall straight ahead, at a distance from it.
fn depths(depth: Depth, distance_m: f64) -> Vec<f64> {
    let depth = Depth { field_of_view_deg: 30.0, width: 200, height: 100, ..depth };
    let place = pose([3.0 - distance_m, 0.0, 0.0], [0.0; 3]);
    let cloud = exposed(&camera(depth), &Scene::new(&bare()), place, FIRST);
    cloud.iter().map(|point| f64::from(point.position_m[2])).collect()
}

#[test]
fn noise_grows_with_the_square_of_depth_and_lies_along_the_ray() {
    const SIGMA_PER_M: f64 = 0.004;
    for distance_m in [1.0, 2.0, 4.0] {
        let seen = depths(Depth { sigma_per_m: SIGMA_PER_M, ..perfect() }, distance_m);
        let count = seen.len() as f64;
        let mean = seen.iter().sum::<f64>() / count;
        let sigma = (seen.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / count).sqrt();
        let expected = SIGMA_PER_M * distance_m * distance_m;
        // Of 20,000 draws the deviation's own is 0.5 %, the mean's 0.7 % of a deviation.
        assert!((sigma / expected - 1.0).abs() < 0.025, "{distance_m} m: {sigma}");
        assert!((mean - distance_m).abs() < 0.04 * expected, "{distance_m} m: {mean}");
    }
    let noisy = camera(Depth { sigma_per_m: 0.05, ..perfect() });
    let (scene, place) = (Scene::new(&bare()), pose([0.0; 3], [0.3, 0.1, 0.0]));
    let exact = exposed(&camera(perfect()), &scene, place, FIRST);
    for (noisy, exact) in exposed(&noisy, &scene, place, FIRST).iter().zip(&exact) {
        let slope =
            |p: &CloudPoint| [p.position_m[0], p.position_m[1]].map(|c| c / p.position_m[2]);
        let ([a, b], [c, d]) = (slope(noisy), slope(exact));
        assert!((a - c).abs() < 1e-5 && (b - d).abs() < 1e-5);
    }
}

#[test]
fn as_many_points_are_lost_as_configured_and_not_always_the_same() {
    let seen = depths(Depth { drop_probability: 0.1, ..perfect() }, 2.0);
    let lost = seen.iter().filter(|depth| depth.is_nan()).count();
    assert!((1830..2170).contains(&lost), "{lost} of 20,000");
    assert!(depths(Depth { drop_probability: 1.0, ..perfect() }, 2.0).iter().all(|z| z.is_nan()));
    assert!(depths(perfect(), 2.0).iter().all(|z| z.is_finite()));
}

#[test]
fn the_same_frame_repeats_and_another_frame_seed_or_camera_differs() {
    let scene = Scene::new(&bare());
    let seen = |seed: u64, index: usize, number: u64| {
        let settings = Depth { sigma_per_m: 0.003, drop_probability: 0.01, seed, ..perfect() };
        let camera =
            DepthCamera::new(&Camera { depth: Some(settings), ..Camera::default() }, index);
        let cloud = exposed(&camera, &scene, pose([0.0; 3], [0.0; 3]), Frame { number, ..FIRST });
        format!("{cloud:?}")
    };
    let first = seen(1, 0, 7);
    assert_eq!(first, seen(1, 0, 7));
    for other in [seen(1, 0, 8), seen(2, 0, 7), seen(1, 1, 7)] {
        assert_ne!(first, other);
    }
}

#[test]
fn there_is_no_depth_out_of_range() {
    let near = Depth { min_m: 2.0, max_m: 3.5, ..perfect() };
    assert!(depths(near, 1.9).iter().all(|depth| depth.is_nan()));
    assert!(depths(near, 2.1).iter().all(|depth| depth.is_finite()));
    assert!(depths(near, 3.6).iter().all(|depth| depth.is_nan()));
}

#[test]
fn there_is_no_depth_on_what_is_seen_edgewise() {
    // The floor 1.5 m below, seen level: the ray's slope is the sine of its angle to the floor.
    let scene = Scene::new(&bare());
    let place = pose([-2.9, 0.0, -1.45], [0.0; 3]);
    let grazing = camera(Depth { grazing_deg: 10.0, ..perfect() });
    let all = exposed(&camera(perfect()), &scene, place, FIRST);
    let kept = exposed(&grazing, &scene, place, FIRST);
    let mut seen_edgewise = 0;
    for (exact, kept) in all.iter().zip(&kept) {
        let [x, y, z] = exact.position_m.map(f64::from);
        let length = x.hypot(y).hypot(z);
        // Depth, width and height of the room are all above 2.9 m but below.
        let on_floor = (y - 0.05).abs() < 1e-5;
        let sine = if on_floor { y / length } else { continue };
        let limit = 10_f64.to_radians().sin();
        if (sine - limit).abs() > 1e-4 {
            assert_eq!(kept.position_m[2].is_finite(), sine > limit, "{exact:?}");
            seen_edgewise += usize::from(sine < limit);
        }
    }
    assert!(seen_edgewise > 50, "{seen_edgewise}");
}
