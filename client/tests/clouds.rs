//! Clouds and their merging against sources in other processes, through real shared memory.

mod support;

use std::f64::consts::FRAC_PI_2;
use std::time::{Duration, Instant};

use lodestone_client::{CameraMerge, CloudFrame, CloudMerger, VoxelMapSettings, VoxelView};
use support::TestDomain;
use support::scanner::{COLUMNS, HALF_WALL_M, ROWS, Scanner, Setup, WALL_Y_M, scan_as_ordered};

const PATIENCE: Duration = Duration::from_secs(20);
const VOXEL_M: f64 = 0.05;

#[test]
#[ignore = "the source's side of the other tests, which start it themselves"]
fn scanner_process() {
    scan_as_ordered();
}

fn merger(domain: &TestDomain, cameras: &[&str], compensate: bool) -> CloudMerger {
    let size = VoxelMapSettings { voxel_m: VOXEL_M, max_voxels: 100_000 };
    let builder = domain.client().merger().map(size).compensate(compensate);
    let add = |builder: lodestone_client::CloudMergerBuilder, camera: &&str| {
        builder.camera(CameraMerge::new(*camera))
    };
    cameras.iter().fold(builder, add).open().expect("good settings")
}

/// Merges until a state is reached.
fn merge_until(merger: &mut CloudMerger, what: &str, is_reached: impl Fn(&CloudMerger) -> bool) {
    let begin = Instant::now();
    while !is_reached(merger) {
        assert!(begin.elapsed() < PATIENCE * 2, "never happened: {what}");
        if let Some(cloud) = merger.wait(Duration::from_millis(20)) {
            merger.insert(cloud);
        }
    }
}

fn each_has(clouds: u64) -> impl Fn(&CloudMerger) -> bool {
    move |merger| (0..merger.cameras().len()).all(|i| merger.counts(i).clouds >= clouds)
}

/// Furthest of all voxels' means from the wall, m.
fn bend_m(merger: &CloudMerger) -> f64 {
    merger.map().voxels().map(|v| (v.position_m.y - WALL_Y_M).abs()).fold(0.0, f64::max)
}

/// Voxels that the wall passes through.
fn voxels_of_wall() -> usize {
    let across = |half: f64| (2.0 * half / VOXEL_M).round() as usize + 1;
    across(HALF_WALL_M[0]) * across(HALF_WALL_M[1])
}

#[test]
fn a_cloud_comes_without_a_copy_and_as_it_was_sent() {
    let domain = TestDomain::shared();
    let _scanner = Scanner::start(&domain, "whole", Setup::at([0.0, 0.0], FRAC_PI_2));
    let mut clouds = domain.client().clouds("whole").unwrap();
    let first = clouds.wait(PATIENCE).unwrap();
    let info = first.info();
    assert_eq!((info.width(), info.height(), info.frame()), (COLUMNS, ROWS, CloudFrame::Body));
    assert!(info.has_colour() && info.has_point_time());
    assert_eq!(first.len(), (COLUMNS * ROWS) as usize);
    // Straight ahead, the wall's upper left corner: x forward, y left.
    let [x, y, z] = first[0].position_m;
    assert!((x - 5.0).abs() < 1e-6 && (y - 1.0).abs() < 1e-6 && (z + 0.5).abs() < 1e-6);
    // A second may be held, a third not, until one is given back.
    let second = clouds.wait(PATIENCE).unwrap();
    assert!(second.info().sequence() > info.sequence());
    assert!(clouds.wait(Duration::from_millis(200)).is_err());
    drop((first, second));
    assert!(clouds.wait(PATIENCE).is_ok());
}

#[test]
fn who_is_slow_loses_the_oldest_clouds_and_knows_how_many() {
    let domain = TestDomain::shared();
    let _scanner = Scanner::start(&domain, "slow-clouds", Setup::at([0.0, 0.0], FRAC_PI_2));
    let mut clouds = domain.client().clouds("slow-clouds").unwrap();
    let first = clouds.wait(PATIENCE).unwrap().info().sequence();
    // When ten and more clouds come meanwhile
    std::thread::sleep(Duration::from_millis(800));
    let next = clouds.wait(PATIENCE).unwrap().info().sequence();
    assert!(next > first + 1, "{first} {next}");
    assert_eq!(clouds.counts().lost, next - first - 1);
}

#[test]
fn two_cameras_that_see_one_wall_give_one_wall() {
    let domain = TestDomain::shared();
    let _left = Scanner::start(&domain, "left", Setup::at([-2.0, 0.5], 1.2));
    let _right = Scanner::start(&domain, "right", Setup::at([1.5, -1.0], 1.9));
    let mut merger = merger(&domain, &["left", "right"], true);
    merge_until(&mut merger, "ten clouds of each", each_has(10));
    // Then it is as thin as one, nowhere doubled, and most of it was seen by both
    assert!(bend_m(&merger) < 1e-4, "{} m", bend_m(&merger));
    // Rounding puts what lies on a face between two voxels into either.
    let voxels: Vec<VoxelView> = merger.map().voxels().collect();
    assert!(voxels.len() <= 2 * voxels_of_wall(), "{} voxels", voxels.len());
    let by_both = voxels.iter().filter(|v| v.is_seen_by(0) && v.is_seen_by(1)).count();
    assert!(by_both * 2 > voxels_of_wall(), "{by_both} of {}", voxels_of_wall());
    assert!(voxels.iter().all(|v| v.colour == Some([200, 100, 50])));
    for camera in 0..2 {
        let counts = merger.counts(camera);
        assert_eq!(counts.points.placed, counts.clouds * u64::from(COLUMNS * ROWS));
        // Where the source's process is held up, poses have gaps: how many is not the point.
        assert_eq!((counts.invalid, counts.restarts), (0, 0));
        assert!(merger.lateness(camera).quantile(0.5).is_some());
    }
}

#[test]
fn a_turning_camera_gives_a_straight_wall_by_the_times_of_its_points_and_else_a_bent_one() {
    let domain = TestDomain::shared();
    let setup = Setup { rate_rad_s: 2.0, ..Setup::at([0.0, 0.0], FRAC_PI_2) };
    let _scanner = Scanner::start(&domain, "turning", setup);
    let mut straight = merger(&domain, &["turning"], true);
    merge_until(&mut straight, "ten clouds", each_has(10));
    assert!(bend_m(&straight) < 1e-3, "{} m", bend_m(&straight));
    // Over 30 ms it turns by 0.06 rad: 5 cm at the wall's side.
    let mut bent = merger(&domain, &["turning"], false);
    merge_until(&mut bent, "ten clouds", each_has(10));
    assert!(bend_m(&bent) > 0.03, "{} m", bend_m(&bent));
}

#[test]
fn clouds_that_are_garbage_are_counted_and_the_others_still_come() {
    let domain = TestDomain::shared();
    let setup = Setup { garbage: true, ..Setup::at([0.0, 0.0], FRAC_PI_2) };
    let _scanner = Scanner::start(&domain, "garbage", setup);
    let mut merger = merger(&domain, &["garbage"], true);
    merge_until(&mut merger, "good and bad clouds", |merger| {
        let counts = merger.counts(0);
        counts.clouds >= 5 && counts.invalid >= 5
    });
    assert!(bend_m(&merger) < 1e-4, "{} m", bend_m(&merger));
}

#[test]
fn a_source_that_is_killed_and_started_again_is_followed() {
    let domain = TestDomain::shared();
    let setup = Setup::at([0.0, 0.0], FRAC_PI_2);
    let first = Scanner::start(&domain, "restarted", setup);
    let mut merger = merger(&domain, &["restarted"], true);
    merge_until(&mut merger, "clouds", each_has(3));
    first.kill();
    let _second = Scanner::start(&domain, "restarted", setup);
    let before = merger.counts(0).clouds;
    merge_until(&mut merger, "clouds of the second", |m| m.counts(0).clouds >= before + 3);
    assert_eq!(merger.counts(0).restarts, 1);
    assert!(bend_m(&merger) < 1e-4, "{} m", bend_m(&merger));
}

#[test]
fn a_cloud_without_a_pose_is_counted_with_the_reason_and_never_placed() {
    let domain = TestDomain::shared();
    let setup = Setup { poses: false, ..Setup::at([0.0, 0.0], FRAC_PI_2) };
    let _scanner = Scanner::start(&domain, "poseless", setup);
    let mut merger = merger(&domain, &["poseless"], true);
    merge_until(&mut merger, "clouds without poses", |m| m.counts(0).without_pose >= 2);
    assert!(merger.map().is_empty());
    let reason = merger.refused(0).expect("is known").to_string();
    assert!(reason.contains("not connected"), "{reason}");
}

#[test]
fn a_world_defined_anew_begins_the_map_anew() {
    let domain = TestDomain::shared();
    let setup = Setup::at([0.0, 0.0], FRAC_PI_2);
    let first = Scanner::start(&domain, "anew", setup);
    let mut merger = merger(&domain, &["anew"], true);
    merge_until(&mut merger, "clouds", each_has(3));
    first.kill();
    // Given that in the new world the same camera is elsewhere
    let moved = Setup { world_epoch: 2, place_m: [30.0, 0.0], ..setup };
    let _second = Scanner::start(&domain, "anew", moved);
    merge_until(&mut merger, "the new world", |m| m.world_epoch() == Some(2));
    assert_eq!(merger.begun_anew(), 1);
    let begun = merger.counts(0).clouds;
    merge_until(&mut merger, "clouds of it", |m| m.counts(0).clouds >= begun + 2);
    assert!(merger.map().voxels().all(|v| v.clouds <= 4), "nothing is left of the old one");
}
