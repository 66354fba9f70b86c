//! Replays of walks with a sensor on the foot: recordings with motion capture, and a closed walk.

use std::path::{Path, PathBuf};

use lodestone_tests::system::{PoseLine, Walk, replay, skipped};

/// Error of each walk, m, as it was when this table was last looked at; the test prints the new one
/// (`--nocapture`). In 2017-12-15-17-59-19 the motion capture itself fails for half a second.
const GOLDEN_M: [(&str, f64); 11] = [
    ("2017-11-22-11-22-03", 0.067),
    ("2017-11-22-11-26-05", 0.081),
    ("2017-11-22-11-30-14", 0.127),
    ("2017-11-22-11-39-47", 0.067),
    ("2017-11-22-11-49-03", 0.051),
    ("2017-11-22-11-52-02", 0.045),
    ("2017-11-27-11-13-10", 0.092),
    ("2017-11-27-11-17-28", 0.067),
    ("2017-12-15-17-59-19", 0.102),
    ("2017-12-15-18-01-18", 0.115),
    ("2018-02-09-11-29-43", 0.062),
];

/// How far a walk may be from its number, m.
const TOLERANCE_M: f64 = 0.03;
const MEDIAN_LIMIT_M: f64 = 0.075;
const MEAN_LIMIT_M: f64 = 0.085;
/// From start to end of the closed walk, in space, m.
const CLOSURE_LIMIT_M: f64 = 0.082;

/// The recordings stand beside the project, not in it.
fn recordings() -> Option<PathBuf> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/foot");
    directory.is_dir().then_some(directory)
}

/// The poses of one recording, one for each row.
fn poses(recording: &Path, options: &[&str]) -> Vec<PoseLine> {
    let out = tempfile::tempdir().unwrap();
    let replayed = replay(recording, out.path(), options);
    assert_eq!(replayed.code, Some(0), "{}", replayed.log);
    replayed.unbroken_poses()
}

#[test]
fn on_eleven_walks_the_position_is_as_good_as_it_was() {
    let Some(directory) = recordings() else {
        return skipped("no recordings of walks in ../shared/data/foot");
    };
    let score = |name: &str| {
        let walk = Walk::read(&directory.join(format!("{name}.csv.zst")));
        walk.score_m(&poses(&walk.recording, &["--preset", "foot"]))
    };
    let scores: Vec<f64> = GOLDEN_M.iter().map(|(name, _)| score(name)).collect();
    for ((name, _), score) in GOLDEN_M.iter().zip(&scores) {
        println!("    (\"{name}\", {score:.3}),");
    }
    let mut sorted = scores.clone();
    sorted.sort_by(f64::total_cmp);
    let (median, mean) = (sorted[sorted.len() / 2], scores.iter().sum::<f64>() / 11.0);
    println!("median {median:.3} m, mean {mean:.3} m");
    assert!(median <= MEDIAN_LIMIT_M, "median {median:.3} m");
    assert!(mean <= MEAN_LIMIT_M, "mean {mean:.3} m");
    for ((name, golden), score) in GOLDEN_M.iter().zip(&scores) {
        assert!((score - golden).abs() <= TOLERANCE_M, "{name}: {score:.3} m, was {golden} m");
    }
}

#[test]
fn a_closed_walk_closes() {
    let Some(directory) = recordings() else {
        return skipped("no recordings of walks in ../shared/data/foot");
    };
    let poses = poses(&directory.join("gait_short_walk.csv.zst"), &["--preset", "foot"]);
    let at = |pose: &PoseLine| pose.position_m.expect("a position in each row");
    let (first, last) = (at(&poses[0]), at(&poses[poses.len() - 1]));
    let closure = (last - first).length();
    println!("closes within {closure:.3} m");
    assert!(closure <= CLOSURE_LIMIT_M, "{closure:.3} m");
    let farthest = poses.iter().map(|pose| (at(pose) - first).length()).fold(0.0, f64::max);
    assert!(farthest > 2.0, "it went somewhere: {farthest:.3} m");
}

#[test]
fn axes_are_the_recordings_unless_others_are_asked_for() {
    // Given a recording in aerospace axes, when its poses are written in either world, then they are
    // mirror images: x and y change places, z its sign.
    let Some(directory) = recordings() else {
        return skipped("no recordings of walks in ../shared/data/foot");
    };
    let recording = directory.join("2017-11-22-11-52-02.csv.zst");
    let written = |frame: &str| poses(&recording, &["--preset", "foot", "--frame", frame]);
    let (auto, ned, enu) = (written("auto"), written("ned"), written("enu"));
    assert_eq!(auto, ned);
    for (ned, enu) in ned.iter().zip(&enu) {
        let (n, e) = (ned.position_m.unwrap(), enu.position_m.unwrap());
        assert!((n - glam::DVec3::new(e.y, e.x, -e.z)).length() < 2e-6, "{n} and {e}");
        // Both turn the body's down to down.
        let (n, e) = (ned.orientation.unwrap(), enu.orientation.unwrap());
        let (n, e) = (n * glam::DVec3::Z, e * glam::DVec3::Z);
        assert!((n - glam::DVec3::new(e.y, e.x, -e.z)).length() < 1e-6, "{n} and {e}");
    }
    assert!(ned[0].orientation.unwrap().mul_vec3(glam::DVec3::Z).z > 0.9, "z points down");
}
