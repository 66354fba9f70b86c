//! BROAD's recordings and its metric.

use std::fs;
use std::path::{Path, PathBuf};

use glam::DQuat;
use lodestone_schema::Status;

use super::{PoseLine, table, text_of};

/// A recording with the ground truth that the filter is not shown.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The recording.
    pub recording: PathBuf,
    /// Times of all rows, s.
    pub times_s: Vec<f64>,
    /// Body to world for each row that is scored.
    pub truth: Vec<Option<DQuat>>,
}

/// How good the poses of a trial are. Angles are root mean squares over the rows that are scored,
/// degrees; nothing is aligned to the truth.
#[derive(Clone, Copy, Debug)]
pub struct TrialScore {
    /// The whole angle between estimate and truth.
    pub total_deg: f64,
    /// The angle that remains when the headings are made equal.
    pub inclination_deg: f64,
    /// Part of the scored rows whose heading error is within three standard deviations.
    pub within_3_sigma: f64,
    /// Part of all rows that are called disturbed.
    pub called_disturbed: f64,
}

impl Trial {
    /// Reads the ground truth of a recording.
    ///
    /// # Panics
    /// If the recording cannot be read or has no ground truth.
    pub fn read(recording: &Path) -> Self {
        let columns = table(recording, &["t", "qw", "qx", "qy", "qz", "movement"]);
        let row = |n: usize| {
            let q = DQuat::from_xyzw(columns[2][n], columns[3][n], columns[4][n], columns[1][n]);
            let scored = columns[5][n] > 0.5 && q.is_finite();
            scored.then(|| q.normalize())
        };
        let truth = (0..columns[0].len()).map(row).collect();
        Self { recording: recording.into(), times_s: columns[0].clone(), truth }
    }

    /// The same trial with only every `nth` magnetometer reading, as a new recording in a directory.
    ///
    /// # Panics
    /// If the recording has no magnetometer columns, or cannot be written.
    #[must_use]
    pub fn with_every_nth_reading(&self, nth: usize, directory: &Path) -> Self {
        let text = text_of(&self.recording);
        let (header, rows) = text.split_once('\n').expect("a header");
        let first = header.split(',').position(|name| name == "mx").expect("a magnetometer");
        let mut thinned = format!("{header}\n");
        for (n, row) in rows.lines().enumerate() {
            let mut fields: Vec<&str> = row.split(',').collect();
            if n % nth != 0 {
                fields[first..first + 3].fill("");
            }
            thinned.push_str(&fields.join(","));
            thinned.push('\n');
        }
        let name = self.recording.file_name().expect("a file").to_string_lossy();
        let recording = directory.join(name.trim_end_matches(".zst"));
        fs::write(&recording, thinned).expect("writes");
        Self { recording, ..self.clone() }
    }

    /// Scores one pose for each row.
    ///
    /// # Panics
    /// If a scored row has no pose, or there is none at all.
    pub fn score(&self, poses: &[PoseLine]) -> TrialScore {
        assert_eq!(self.truth.len(), poses.len(), "one pose for each row");
        let (mut scored, mut total, mut inclination, mut within) = (0.0, 0.0, 0.0, 0.0);
        for (pose, truth) in poses.iter().zip(&self.truth) {
            let Some(truth) = truth else { continue };
            let estimate = pose.orientation.expect("a pose where poses are scored").normalize();
            let error = estimate * truth.conjugate();
            let upright = error.w.hypot(error.z).min(1.0);
            let heading_deg = 2.0 * (error.z / error.w).atan().to_degrees();
            scored += 1.0;
            total += (2.0 * error.w.abs().min(1.0).acos()).powi(2);
            inclination += (2.0 * upright.acos()).powi(2);
            let sigma_deg = pose.heading_sigma_deg.expect("a sigma where poses are scored");
            within += f64::from(heading_deg.abs() < 3.0 * sigma_deg);
        }
        let disturbed = |pose: &&PoseLine| {
            Status::from_bits_retain(pose.status).contains(Status::MAGNETIC_DISTURBANCE)
        };
        let rms_deg = |squares: f64| (squares / scored).sqrt().to_degrees();
        TrialScore {
            total_deg: rms_deg(total),
            inclination_deg: rms_deg(inclination),
            within_3_sigma: within / scored,
            called_disturbed: poses.iter().filter(disturbed).count() as f64 / poses.len() as f64,
        }
    }
}
