use glam::{DQuat, DVec3};
use proptest::prelude::*;

use super::{VoxelMap, VoxelMapSettings};
use crate::frame::{Rotation, World};
use crate::merge::error::VoxelMapError;
use crate::merge::samples::{placed, point};
use crate::transform::Transform;

const S: i64 = 1_000_000_000;

fn map(voxel_m: f64, max_voxels: usize) -> VoxelMap {
    VoxelMap::new(VoxelMapSettings { voxel_m, max_voxels }).unwrap()
}

#[test]
fn sizes_without_meaning_are_refused() {
    let sized = |voxel_m, max_voxels| VoxelMap::new(VoxelMapSettings { voxel_m, max_voxels });
    assert_eq!(sized(0.0, 10).unwrap_err(), VoxelMapError::VoxelSize(0.0));
    assert!(sized(f64::NAN, 10).is_err());
    assert_eq!(sized(0.1, 0).unwrap_err(), VoxelMapError::VoxelCount(0));
    assert!(sized(0.1, usize::MAX).is_err());
}

#[test]
fn points_of_one_voxel_become_their_mean_with_what_is_known_of_them() {
    // Given two cameras kilometres from the origin that see the same place
    let mut map = map(0.1, 100);
    let far = DVec3::new(30_000.0, -20_000.0, 100.0);
    let [a, b] = [point([1.01, 0.02, 0.03]), point([1.03, 0.04, 0.05])];
    map.insert(&placed(0, S, far, &[a, b]));
    map.insert(&placed(3, 2 * S, far, &[b]));
    // Then it is one voxel
    assert_eq!(map.len(), 1);
    let voxel = map.at(far + DVec3::new(1.0, 0.0, 0.0) + 0.01).unwrap();
    let mean = far + DVec3::new(3.07, 0.10, 0.13) / 3.0;
    assert!(voxel.position_m.abs_diff_eq(mean, 1e-6), "{} {mean}", voxel.position_m);
    assert_eq!((voxel.points, voxel.clouds, voxel.last_seen_ns), (3, 2, 2 * S));
    assert_eq!(voxel.colour, Some([10, 20, 30]));
    let seen: Vec<usize> = (0..20).filter(|&camera| voxel.is_seen_by(camera)).collect();
    assert_eq!(seen, [0, 3]);
    assert_eq!(map.at(far), None);
}

#[test]
fn a_correction_turns_and_moves_a_cloud_about_the_worlds_origin() {
    let mut map = map(0.1, 100);
    let quarter = DQuat::from_rotation_z(core::f64::consts::FRAC_PI_2);
    let turn = Rotation::<World, World>::from_quaternion(quarter).unwrap();
    let correction = Transform::new(turn, DVec3::new(0.0, 0.0, 1.0));
    let cloud = placed(0, S, DVec3::new(10.0, 0.0, 0.0), &[point([1.0, 0.0, 0.0])]);
    map.insert_corrected(&cloud, correction);
    let found = map.voxels().next().unwrap().position_m;
    assert!(found.abs_diff_eq(DVec3::new(0.0, 11.0, 1.0), 1e-6), "{found}");
}

#[test]
fn what_lies_beyond_the_grid_is_counted() {
    let mut map = map(0.001, 100);
    map.insert(&placed(0, S, DVec3::new(0.0, 2000.0, 0.0), &[point([1.0, 0.0, 0.0]); 7]));
    assert_eq!((map.len(), map.counts().beyond_grid, map.counts().points), (0, 7, 0));
}

#[test]
fn a_full_map_forgets_what_was_not_seen_for_longest() {
    // Given a map full of a place that is seen again and again, and of one that was left
    let mut map = map(0.1, 64);
    let spots = |from: f32| -> Vec<_> {
        (0..32).map(|i| point([1.05, 0.05, from + 0.1 * i as f32 + 0.05])).collect()
    };
    let here = DVec3::ZERO;
    map.insert(&placed(0, S, here, &spots(0.0)));
    map.insert(&placed(0, 2 * S, here, &spots(10.0)));
    assert_eq!((map.len(), map.counts().evicted), (64, 0));
    // When the camera comes to new places, and sees the second again each time
    for step in 0..20 {
        let time_ns = (3 + 2 * step) * S;
        map.insert(&placed(0, time_ns, here, &spots(10.0)));
        map.insert(&placed(0, time_ns + S, here, &spots(15.0)[..8]));
    }
    // Then only the first was thinned out
    let is_known = |from: f32, i: i32| {
        map.at(DVec3::new(1.05, 0.05, f64::from(from) + 0.1 * f64::from(i) + 0.05)).is_some()
    };
    assert_eq!(map.counts().evicted, 8);
    assert!((0..32).all(|i| is_known(10.0, i)));
    assert_eq!((0..32).filter(|&i| is_known(0.0, i)).count(), 24);
    assert!((0..8).all(|i| is_known(15.0, i)));
}

#[test]
fn an_hour_of_new_places_takes_no_more_memory() {
    // Given an hour at 15 Hz, three metres further each second
    let mut map = map(0.05, 20_000);
    let bytes = map.bytes();
    let wall: Vec<_> =
        (0..2_000).map(|i| point([3.0, 0.1 * (i % 50) as f32, 0.1 * (i / 50) as f32])).collect();
    for cloud in 0..3600 * 15_i64 / 10 {
        let time_ns = cloud * S * 10 / 15;
        let origin = DVec3::new(2.0 * cloud as f64, 0.0, 0.0);
        map.insert(&placed(0, time_ns, origin, &wall));
    }
    // Then the map holds the last places in the memory that it had
    assert_eq!((map.bytes(), map.len()), (bytes, 20_000));
    assert!(map.voxels.capacity() == 20_000);
    assert_eq!(map.counts().evicted, 5400 * 2_000 - 20_000);
    let oldest = map.voxels().map(|voxel| voxel.last_seen_ns).min().unwrap();
    assert!(oldest >= 5389 * S * 10 / 15 - S, "the last ten clouds fill it");
}

#[test]
fn a_cleared_map_is_empty_and_takes_clouds_of_another_time() {
    let mut map = map(0.1, 100);
    map.insert(&placed(0, 100 * S, DVec3::ZERO, &[point([1.0, 0.0, 0.0])]));
    map.clear();
    assert!(map.is_empty() && map.at(DVec3::X).is_none());
    map.insert(&placed(0, S, DVec3::ZERO, &[point([1.0, 0.0, 0.0])]));
    assert_eq!(map.voxels().next().unwrap().last_seen_ns, S);
}

proptest! {
    #[test]
    fn each_voxel_is_the_mean_of_its_points(
        points in prop::collection::vec(prop::array::uniform3(-3.0..3.0_f32), 1..200),
        origin in prop::array::uniform3(-100.0..100.0_f64),
        voxel_m in 0.01..1.0_f64,
    ) {
        let points: Vec<_> = points.into_iter().map(point).collect();
        let cloud = placed(0, S, DVec3::from_array(origin), &points);
        let mut map = map(voxel_m, 1000);
        map.insert(&cloud);
        // Given the same sums over all points, whatever voxel they are in
        let expected: DVec3 = cloud.positions_m().sum();
        let found: DVec3 = map.voxels().map(|v| v.position_m * f64::from(v.points)).sum();
        let count: u32 = map.voxels().map(|v| v.points).sum();
        prop_assert_eq!(count as usize, cloud.points().len());
        prop_assert!(found.abs_diff_eq(expected, 1e-5 * f64::from(count)), "{} {}", found, expected);
        // Then each point has a voxel no further off than its diagonal
        for place in cloud.positions_m() {
            let near = map.voxels().any(|v| v.position_m.distance(place) <= voxel_m * 1.7321 + 1e-5);
            prop_assert!(near);
        }
    }
}
