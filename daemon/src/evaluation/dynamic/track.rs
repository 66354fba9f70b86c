//! Where a camera was, and how far an estimate is off.

use glam::DVec3;
use lodestone_fusion::{Body, Rotation, World};

use crate::evaluation::statistics::root_mean_square;

/// A pose along a way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackPoint {
    /// Time since the end of the rest, s.
    pub time_s: f64,
    /// Position in W from where the rest ended, m.
    pub position_m: DVec3,
    /// Body to world.
    pub orientation: Rotation<World, Body>,
}

/// Poses in the order of time, the first of them at the end of the rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Track(pub Vec<TrackPoint>);

/// How far an estimate is off at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseError {
    /// Time since the end of the rest, s.
    pub time_s: f64,
    /// Estimated less true position in W, m.
    pub position_m: DVec3,
    /// Estimated less true roll, pitch and yaw, ±180°.
    pub roll_pitch_yaw_deg: [f64; 3],
}

impl Track {
    /// The same with positions counted from the first one.
    #[must_use]
    pub fn from_its_start(mut self) -> Self {
        let start = self.0.first().map_or(DVec3::ZERO, |point| point.position_m);
        for point in &mut self.0 {
            point.position_m -= start;
        }
        self
    }

    /// The errors against the truth, which has a pose at each of these instants.
    pub fn errors(&self, truth: &Self) -> Vec<PoseError> {
        self.0.iter().zip(&truth.0).map(|(ours, truth)| PoseError::of(ours, truth)).collect()
    }
}

impl TrackPoint {
    /// Roll, pitch and yaw, degrees.
    pub fn roll_pitch_yaw_deg(&self) -> [f64; 3] {
        let (yaw, pitch, roll) = self.orientation.to_yaw_pitch_roll();
        [roll, pitch, yaw].map(f64::to_degrees)
    }
}

impl PoseError {
    fn of(ours: &TrackPoint, truth: &TrackPoint) -> Self {
        let (a, b) = (ours.roll_pitch_yaw_deg(), truth.roll_pitch_yaw_deg());
        Self {
            time_s: truth.time_s,
            position_m: ours.position_m - truth.position_m,
            roll_pitch_yaw_deg: [0, 1, 2].map(|axis| wrapped_deg(a[axis] - b[axis])),
        }
    }
}

/// The length of the position's error at the instant nearest to a time, m; `None` beyond the end.
pub fn distance_at(errors: &[PoseError], time_s: f64) -> Option<f64> {
    let last = errors.last()?.time_s;
    let after = errors.partition_point(|error| error.time_s < time_s);
    let near = errors[after.saturating_sub(1)..].iter().take(2);
    let away = |error: &&PoseError| (error.time_s - time_s).abs();
    let nearest = near.min_by(|a, b| away(a).total_cmp(&away(b)))?;
    (time_s <= last + 0.05).then(|| nearest.position_m.length())
}

/// Root mean square of the errors of roll, pitch and yaw, degrees; `None` of no errors.
pub fn orientation_rms_deg(errors: &[PoseError]) -> Option<[f64; 3]> {
    let axis = |axis: usize| {
        let all: Vec<f64> = errors.iter().map(|e| e.roll_pitch_yaw_deg[axis]).collect();
        root_mean_square(&all)
    };
    Some([axis(0)?, axis(1)?, axis(2)?])
}

/// The same angle in ±180°.
pub fn wrapped_deg(angle_deg: f64) -> f64 {
    (angle_deg + 180.0).rem_euclid(360.0) - 180.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(time_s: f64, x: f64, yaw_deg: f64) -> TrackPoint {
        TrackPoint {
            time_s,
            position_m: DVec3::X * x,
            orientation: Rotation::from_yaw_pitch_roll(yaw_deg.to_radians(), 0.1, 0.2),
        }
    }

    #[test]
    fn errors_are_estimate_less_truth_and_angles_go_the_short_way() {
        let ours = Track(vec![point(0.0, 5.0, 179.0), point(0.5, 8.0, 10.0)]).from_its_start();
        let truth = Track(vec![point(0.0, 0.0, -179.0), point(0.5, 1.0, 7.0)]);
        let errors = ours.errors(&truth);
        assert!((errors[0].roll_pitch_yaw_deg[2] + 2.0).abs() < 1e-9, "{errors:?}");
        assert!(errors[0].position_m.length() < 1e-12);
        assert!((errors[1].position_m.x - 2.0).abs() < 1e-12);
        let rms = orientation_rms_deg(&errors).unwrap();
        assert!(rms[0] < 1e-9 && rms[1] < 1e-9 && (rms[2] - 6.5_f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn a_time_beyond_the_end_has_no_error() {
        let truth = Track(vec![point(0.0, 0.0, 0.0), point(0.5, 0.0, 0.0), point(1.0, 0.0, 0.0)]);
        let ours = Track(vec![point(0.0, 0.0, 0.0), point(0.5, 1.0, 0.0), point(1.0, 3.0, 0.0)]);
        let errors = ours.errors(&truth);
        assert_eq!(distance_at(&errors, 0.6), Some(1.0));
        assert_eq!(distance_at(&errors, 1.0), Some(3.0));
        assert_eq!(distance_at(&errors, 2.0), None);
        assert_eq!(distance_at(&[], 0.0), None);
    }
}
