//! Recordings of walks with a sensor on the foot, and their metric.

use std::path::{Path, PathBuf};

use glam::DVec2;

use super::{PoseLine, table};

/// A walk with its true way in the plane, which the filter is not shown.
#[derive(Clone, Debug)]
pub struct Walk {
    /// The recording.
    pub recording: PathBuf,
    /// True position for each row, m, where it is known.
    pub truth: Vec<Option<DVec2>>,
}

impl Walk {
    /// Reads the true way of a recording.
    ///
    /// # Panics
    /// If the recording cannot be read or has no true way.
    pub fn read(recording: &Path) -> Self {
        let columns = table(recording, &["px", "py"]);
        let rows = columns[0].iter().zip(&columns[1]);
        let truth = rows.map(|(x, y)| Some(DVec2::new(*x, *y)).filter(|p| p.is_finite())).collect();
        Self { recording: recording.into(), truth }
    }

    /// Root mean square of the position's error in the plane, m, both ways counted from their first
    /// row and the headings made equal.
    ///
    /// # Panics
    /// If a row has no pose.
    pub fn score_m(&self, poses: &[PoseLine]) -> f64 {
        assert_eq!(self.truth.len(), poses.len(), "one pose for each row");
        let at = |pose: &PoseLine| pose.position_m.expect("a position in each row").truncate();
        let (first, start) = (at(&poses[0]), self.truth[0].expect("a true start"));
        let known = poses.iter().zip(&self.truth);
        let ways: Vec<(DVec2, DVec2)> =
            known.filter_map(|(pose, truth)| Some((at(pose) - first, (*truth)? - start))).collect();
        let sum = |of: fn(&(DVec2, DVec2)) -> f64| ways.iter().map(of).sum::<f64>();
        let yaw = sum(|(e, t)| e.perp_dot(*t)).atan2(sum(|(e, t)| e.dot(*t)));
        let turn = DVec2::from_angle(yaw);
        let squares = ways.iter().map(|(e, t)| (turn.rotate(*e) - *t).length_squared());
        (squares.sum::<f64>() / ways.len() as f64).sqrt()
    }
}
