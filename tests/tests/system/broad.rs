//! Replays of BROAD, recordings of a hand-held IMU with optical ground truth.

use std::path::{Path, PathBuf};
use std::thread;

use lodestone_tests::system::{Trial, orientation_rmse_deg, replay, skipped};

/// Total orientation error of each trial, degrees, as it was when this table was last looked at.
/// A change in behaviour shows here, and belongs into the review of whatever changed it; the test
/// prints the new table (`--nocapture`).
const GOLDEN_DEG: [(&str, f64); 15] = [
    ("01_undisturbed_slow_rotation_A", 2.90),
    ("03_undisturbed_slow_rotation_C", 2.00),
    ("05_undisturbed_slow_rotation_with_breaks_B", 1.37),
    ("07_undisturbed_fast_rotation_B", 1.75),
    ("09_undisturbed_fast_rotation_with_breaks_B", 1.62),
    ("11_undisturbed_slow_translation_B", 0.48),
    ("14_undisturbed_slow_translation_with_breaks_B", 2.10),
    ("16_undisturbed_fast_translation_B", 1.21),
    ("21_undisturbed_fast_combined", 2.08),
    ("25_disturbed_tapping_B", 1.94),
    ("27_disturbed_phone_vibration_B", 3.21),
    ("29_disturbed_stationary_magnet_B", 1.86),
    ("31_disturbed_stationary_magnet_D", 1.30),
    ("33_disturbed_attached_magnet_2cm", 2.39),
    ("35_disturbed_attached_magnet_4cm", 1.60),
];

/// How far a trial may be from its number.
const TOLERANCE_DEG: f64 = 0.5;

/// Bound on the mean over all trials.
const MEAN_LIMIT_DEG: f64 = 2.0;

/// The recordings stand beside the project, not in it.
fn recordings() -> Option<PathBuf> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/broad");
    directory.is_dir().then_some(directory)
}

/// Replays one trial and gives its total orientation error, degrees.
fn error_deg(directory: &Path, name: &str) -> f64 {
    let trial = Trial::read(&directory.join(format!("{name}.csv.zst")));
    let out = tempfile::tempdir().unwrap();
    let replayed = replay(&trial.recording, out.path(), &[]);
    assert_eq!(replayed.code, Some(0), "{}", replayed.log);
    let poses = replayed.unbroken_poses();
    assert_eq!(poses.len(), trial.times_s.len(), "{name}: one row for each row");
    let in_step = poses.iter().zip(&trial.times_s).all(|(p, t)| (p.time_s - t).abs() < 1e-6);
    assert!(in_step, "{name}: times differ");
    orientation_rmse_deg(&trial.truth, &poses)
}

/// The errors of all trials in the table's order, worked out two at a time.
fn errors_deg(directory: &Path) -> Vec<f64> {
    let half = |trials: &[(&str, f64)]| -> Vec<f64> {
        trials.iter().map(|(name, _)| error_deg(directory, name)).collect()
    };
    let (first, second) = GOLDEN_DEG.split_at(GOLDEN_DEG.len() / 2);
    thread::scope(|scope| {
        let first = scope.spawn(|| half(first));
        let second = half(second);
        [first.join().expect("no trial fails"), second].concat()
    })
}

#[test]
fn on_fifteen_trials_of_broad_the_orientation_is_as_good_as_it_was() {
    let Some(directory) = recordings() else {
        return skipped("no recordings of BROAD in ../shared/data/broad");
    };
    let errors_deg = errors_deg(&directory);

    for ((name, _), error_deg) in GOLDEN_DEG.iter().zip(&errors_deg) {
        println!("    (\"{name}\", {error_deg:.2}),");
    }
    let mean_deg = errors_deg.iter().sum::<f64>() / errors_deg.len() as f64;
    println!("mean {mean_deg:.3}°");
    assert!(mean_deg <= MEAN_LIMIT_DEG, "mean {mean_deg:.3}°");
    for ((name, golden_deg), error_deg) in GOLDEN_DEG.iter().zip(&errors_deg) {
        let change_deg = error_deg - golden_deg;
        assert!(change_deg.abs() <= TOLERANCE_DEG, "{name}: {error_deg:.3}°, was {golden_deg}°");
    }
}

#[test]
fn a_trial_of_broad_gives_the_same_bytes_twice() {
    let Some(directory) = recordings() else {
        return skipped("no recordings of BROAD in ../shared/data/broad");
    };
    let out = tempfile::tempdir().unwrap();
    let recording = directory.join("35_disturbed_attached_magnet_4cm.csv.zst");
    let first = replay(&recording, &out.path().join("first"), &[]);
    let second = replay(&recording, &out.path().join("second"), &[]);
    assert!(!first.bytes.is_empty() && first.bytes == second.bytes);
}
