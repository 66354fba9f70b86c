//! Replays of BROAD, recordings of a hand-held IMU with optical ground truth.

use std::path::{Path, PathBuf};

use lodestone_tests::system::{Trial, orientation_rmse_deg, replay, skipped};

/// Total orientation error of each trial, degrees, as it was when this table was last looked at.
/// A change in behaviour shows here, and belongs into the review of whatever changed it.
const GOLDEN_DEG: [(&str, f64); 15] = [
    ("01_undisturbed_slow_rotation_A", 0.0),
    ("03_undisturbed_slow_rotation_C", 0.0),
    ("05_undisturbed_slow_rotation_with_breaks_B", 0.0),
    ("07_undisturbed_fast_rotation_B", 0.0),
    ("09_undisturbed_fast_rotation_with_breaks_B", 0.0),
    ("11_undisturbed_slow_translation_B", 0.0),
    ("14_undisturbed_slow_translation_with_breaks_B", 0.0),
    ("16_undisturbed_fast_translation_B", 0.0),
    ("21_undisturbed_fast_combined", 0.0),
    ("25_disturbed_tapping_B", 0.0),
    ("27_disturbed_phone_vibration_B", 0.0),
    ("29_disturbed_stationary_magnet_B", 0.0),
    ("31_disturbed_stationary_magnet_D", 0.0),
    ("33_disturbed_attached_magnet_2cm", 0.0),
    ("35_disturbed_attached_magnet_4cm", 0.0),
];

/// How far a trial may be from its number.
const TOLERANCE_DEG: f64 = 0.5;

/// Bound on the mean over all trials.
const MEAN_LIMIT_DEG: f64 = 3.5;

/// The recordings stand beside the project, not in it.
fn recordings() -> Option<PathBuf> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/broad");
    directory.is_dir().then_some(directory)
}

#[test]
fn on_fifteen_trials_of_broad_the_orientation_is_as_good_as_it_was() {
    let Some(directory) = recordings() else {
        return skipped("no recordings of BROAD in ../shared/data/broad");
    };
    let out = tempfile::tempdir().unwrap();
    let mut errors_deg = Vec::new();
    for (name, golden_deg) in GOLDEN_DEG {
        let trial = Trial::read(&directory.join(format!("{name}.csv.zst")));
        let replayed = replay(&trial.recording, out.path(), &[]);
        assert_eq!(replayed.code, Some(0), "{}", replayed.log);
        let poses = replayed.unbroken_poses();
        assert_eq!(poses.len(), trial.times_s.len(), "{name}: one row for each row");
        let in_step = poses.iter().zip(&trial.times_s).all(|(p, t)| (p.time_s - t).abs() < 1e-6);
        assert!(in_step, "{name}: times differ");
        errors_deg.push((name, golden_deg, orientation_rmse_deg(&trial.truth, &poses)));
    }
    for (name, golden_deg, error_deg) in &errors_deg {
        println!("{name:48} {error_deg:8.3} (was {golden_deg:.2})");
    }
    let mean_deg = errors_deg.iter().map(|e| e.2).sum::<f64>() / errors_deg.len() as f64;
    println!("mean {mean_deg:.3}");
    assert!(mean_deg <= MEAN_LIMIT_DEG, "mean {mean_deg:.3}°");
    for (name, golden_deg, error_deg) in errors_deg {
        assert!((error_deg - golden_deg).abs() <= TOLERANCE_DEG, "{name}: {error_deg:.3}°");
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
