//! Replays of BROAD, recordings of a hand-held IMU with optical ground truth.

use std::path::{Path, PathBuf};
use std::thread;

use lodestone_tests::system::{Trial, TrialScore, replay, skipped};

/// Total orientation error of each trial, degrees, as it was when this table was last looked at.
/// A change in behaviour shows here, and belongs into the review of whatever changed it; the test
/// prints the new table (`--nocapture`).
const GOLDEN_DEG: [(&str, f64); 15] = [
    ("01_undisturbed_slow_rotation_A", 1.95),
    ("03_undisturbed_slow_rotation_C", 1.94),
    ("05_undisturbed_slow_rotation_with_breaks_B", 0.70),
    ("07_undisturbed_fast_rotation_B", 1.39),
    ("09_undisturbed_fast_rotation_with_breaks_B", 0.68),
    ("11_undisturbed_slow_translation_B", 0.75),
    ("14_undisturbed_slow_translation_with_breaks_B", 1.76),
    ("16_undisturbed_fast_translation_B", 0.81),
    ("21_undisturbed_fast_combined", 1.73),
    ("25_disturbed_tapping_B", 1.52),
    ("27_disturbed_phone_vibration_B", 5.22),
    ("29_disturbed_stationary_magnet_B", 1.43),
    ("31_disturbed_stationary_magnet_D", 0.99),
    ("33_disturbed_attached_magnet_2cm", 1.20),
    ("35_disturbed_attached_magnet_4cm", 1.35),
];

/// How far a trial may be from its number.
const TOLERANCE_DEG: f64 = 0.5;

/// Bounds on the means over all trials.
const TOTAL_LIMIT_DEG: f64 = 1.7;
const INCLINATION_LIMIT_DEG: f64 = 0.6;

/// The recordings stand beside the project, not in it.
fn recordings() -> Option<PathBuf> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/broad");
    directory.is_dir().then_some(directory)
}

/// Replays one trial, with every `nth` magnetometer reading, and scores it.
fn score(directory: &Path, name: &str, nth: usize) -> TrialScore {
    let out = tempfile::tempdir().unwrap();
    let mut trial = Trial::read(&directory.join(format!("{name}.csv.zst")));
    if nth > 1 {
        trial = trial.with_every_nth_reading(nth, out.path());
    }
    let replayed = replay(&trial.recording, &out.path().join("poses"), &[]);
    assert_eq!(replayed.code, Some(0), "{}", replayed.log);
    let poses = replayed.unbroken_poses();
    assert_eq!(poses.len(), trial.times_s.len(), "{name}: one row for each row");
    let in_step = poses.iter().zip(&trial.times_s).all(|(p, t)| (p.time_s - t).abs() < 1e-6);
    assert!(in_step, "{name}: times differ");
    trial.score(&poses)
}

/// The scores of all trials in the table's order, worked out two at a time.
fn scores(directory: &Path, nth: usize) -> Vec<TrialScore> {
    let half = |trials: &[(&str, f64)]| -> Vec<TrialScore> {
        trials.iter().map(|(name, _)| score(directory, name, nth)).collect()
    };
    let (first, second) = GOLDEN_DEG.split_at(GOLDEN_DEG.len() / 2);
    thread::scope(|scope| {
        let first = scope.spawn(|| half(first));
        let second = half(second);
        [first.join().expect("no trial fails"), second].concat()
    })
}

fn mean(scores: &[TrialScore], of: fn(&TrialScore) -> f64) -> f64 {
    scores.iter().map(of).sum::<f64>() / scores.len() as f64
}

#[test]
fn on_fifteen_trials_of_broad_the_orientation_is_as_good_as_it_was() {
    let Some(directory) = recordings() else {
        return skipped("no recordings of BROAD in ../shared/data/broad");
    };
    let scores = scores(&directory, 1);

    for ((name, _), score) in GOLDEN_DEG.iter().zip(&scores) {
        println!("    (\"{name}\", {:.2}),", score.total_deg);
    }
    let total_deg = mean(&scores, |s| s.total_deg);
    let inclination_deg = mean(&scores, |s| s.inclination_deg);
    println!("mean {total_deg:.3}°, inclination {inclination_deg:.3}°");
    assert!(total_deg <= TOTAL_LIMIT_DEG, "mean {total_deg:.3}°");
    assert!(inclination_deg <= INCLINATION_LIMIT_DEG, "inclination {inclination_deg:.3}°");
    for ((name, golden_deg), score) in GOLDEN_DEG.iter().zip(&scores) {
        let change_deg = score.total_deg - golden_deg;
        let now_deg = score.total_deg;
        assert!(change_deg.abs() <= TOLERANCE_DEG, "{name}: {now_deg:.3}°, was {golden_deg}°");
    }
    let covered = mean(&scores, |s| s.within_3_sigma);
    assert!(covered > 0.97, "heading within three standard deviations: {covered:.3}");
    for ((name, _), score) in GOLDEN_DEG.iter().zip(&scores) {
        let (called, disturbed) = (score.called_disturbed, name.contains("_disturbed_"));
        assert!(disturbed || called < 0.02, "{name}: {called:.3} of it is called disturbed");
    }
}

#[test]
fn with_every_sixth_magnetometer_reading_broad_is_as_good() {
    let Some(directory) = recordings() else {
        return skipped("no recordings of BROAD in ../shared/data/broad");
    };
    let total_deg = mean(&scores(&directory, 6), |s| s.total_deg);
    println!("mean {total_deg:.3}°");
    assert!(total_deg <= TOTAL_LIMIT_DEG + 0.05, "mean {total_deg:.3}°");
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
