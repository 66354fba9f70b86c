//! The metric of BROAD (Laidig, Caruso, Cereatti and Seel 2021, doi 10.3390/data6070072).

use std::path::{Path, PathBuf};

use glam::DQuat;

use super::{PoseLine, table};

/// One trial: its recording, and which of its rows are scored against which truth.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The recording.
    pub recording: PathBuf,
    /// Times of all rows, s.
    pub times_s: Vec<f64>,
    /// Body to world for each row that is scored.
    pub truth: Vec<Option<DQuat>>,
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
}

/// Root mean square of the total angle between estimate and truth over the rows that are scored,
/// degrees; nothing is aligned.
///
/// # Panics
/// If a scored row has no pose, or there is none at all.
pub fn orientation_rmse_deg(truth: &[Option<DQuat>], poses: &[PoseLine]) -> f64 {
    assert_eq!(truth.len(), poses.len(), "one pose for each row");
    let mut squares = Vec::new();
    for (pose, truth) in poses.iter().zip(truth) {
        let Some(truth) = truth else { continue };
        let estimate = pose.orientation.expect("a pose where poses are scored").normalize();
        let error = estimate * truth.conjugate();
        squares.push((2.0 * error.w.abs().min(1.0).acos()).powi(2));
    }
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt().to_degrees()
}
