//! How the cameras' estimated poses differ from the truth, each for itself and against each other.

use glam::{DQuat, DVec3};
use serde::Serialize;

use super::result::{MeanPose, SeenCamera};

/// Errors of one camera's heading in the world, clockwise, degrees.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeadingError {
    /// The camera.
    pub camera: String,
    /// By its own poses.
    pub own_deg: f64,
    /// Standard deviation of that as published, degrees.
    pub own_sigma_deg: f64,
    /// After ICP.
    pub refined_deg: Option<f64>,
    /// Without the magnetometer.
    pub without_magnetometer_deg: Option<f64>,
}

/// Error of the second camera's pose as seen from the first.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RelativeError {
    /// Difference of the heading's errors, clockwise, degrees.
    pub heading_deg: f64,
    /// Angle between estimated and true orientation, degrees.
    pub angle_deg: f64,
    /// Distance between estimated and true place, m.
    pub place_m: f64,
}

/// The same by each of the poses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RelativeErrors {
    /// By the cameras' own poses.
    pub own: RelativeError,
    /// After ICP.
    pub refined: Option<RelativeError>,
    /// Without the magnetometer.
    pub without_magnetometer: Option<RelativeError>,
}

/// A camera's errors; `None` without a truth.
pub fn heading_error(camera: &SeenCamera) -> Option<HeadingError> {
    let truth = camera.truth?;
    Some(HeadingError {
        camera: camera.name.clone(),
        own_deg: clockwise_deg(&camera.own, &truth),
        own_sigma_deg: camera.heading_sigma_deg,
        refined_deg: camera.refined.map(|pose| clockwise_deg(&pose, &truth)),
        without_magnetometer_deg: camera.without_magnetometer.map(|p| clockwise_deg(&p, &truth)),
    })
}

/// Errors of the second camera against the first; `None` without a truth.
pub fn relative_errors(first: &SeenCamera, second: &SeenCamera) -> Option<RelativeErrors> {
    let truth = (&first.truth?, &second.truth?);
    let refined = first.refined.as_ref().zip(second.refined.as_ref());
    let without = first.without_magnetometer.as_ref().zip(second.without_magnetometer.as_ref());
    Some(RelativeErrors {
        own: relative_error((&first.own, &second.own), truth),
        refined: refined.map(|poses| relative_error(poses, truth)),
        without_magnetometer: without.map(|poses| relative_error(poses, truth)),
    })
}

type Pair<'a> = (&'a MeanPose, &'a MeanPose);

fn relative_error(found: Pair<'_>, truth: Pair<'_>) -> RelativeError {
    let (found_turn, found_place) = second_in_first(found);
    let (true_turn, true_place) = second_in_first(truth);
    let heading_deg = clockwise_deg(found.1, truth.1) - clockwise_deg(found.0, truth.0);
    RelativeError {
        heading_deg: wrapped_deg(heading_deg),
        angle_deg: found_turn.angle_between(true_turn).to_degrees(),
        place_m: found_place.distance(true_place),
    }
}

fn second_in_first((first, second): Pair<'_>) -> (DQuat, DVec3) {
    let back = DQuat::from_array(first.orientation).conjugate();
    let turn = back * DQuat::from_array(second.orientation);
    (turn, back * (place(second) - place(first)))
}

fn place(pose: &MeanPose) -> DVec3 {
    DVec3::from_array(pose.position_m)
}

/// Headings run clockwise, yaw does not.
fn clockwise_deg(found: &MeanPose, truth: &MeanPose) -> f64 {
    wrapped_deg((truth.yaw_rad() - found.yaw_rad()).to_degrees())
}

fn wrapped_deg(degrees: f64) -> f64 {
    (degrees + 180.0).rem_euclid(360.0) - 180.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(heading_deg: f64, east_m: f64) -> MeanPose {
        let yaw = (90.0 - heading_deg).to_radians();
        let orientation = (DQuat::from_rotation_z(yaw) * DQuat::from_rotation_y(0.1)).to_array();
        MeanPose { position_m: [east_m, 0.0, 0.0], orientation, heading_spread_deg: 0.0 }
    }

    fn camera(name: &str, own: MeanPose, truth: MeanPose) -> SeenCamera {
        SeenCamera {
            name: name.into(),
            lost: 0,
            heading_sigma_deg: 1.0,
            own,
            refined: Some(truth),
            without_magnetometer: None,
            truth: Some(truth),
        }
    }

    #[test]
    fn headings_that_err_alike_agree() {
        // Given two cameras that are both turned clockwise by a degree, one of them across north
        let front = camera("front", pose(51.0, 0.0), pose(50.0, 0.0));
        let rear = camera("rear", pose(0.5, 3.0), pose(359.5, 3.0));
        let errors = relative_errors(&front, &rear).unwrap();
        // Then each is wrong by that, and their difference is not
        assert!((heading_error(&front).unwrap().own_deg - 1.0).abs() < 1e-9);
        assert!((heading_error(&rear).unwrap().own_deg - 1.0).abs() < 1e-9);
        assert!(errors.own.heading_deg.abs() < 1e-9 && errors.own.angle_deg < 1e-5);
        // The rear one is 3 m away, and that way has turned with the front one.
        assert!((errors.own.place_m - 3.0 * 2.0 * 0.5_f64.to_radians().sin()).abs() < 1e-9);
        assert!(errors.refined.unwrap().place_m < 1e-12);
    }

    #[test]
    fn headings_that_err_apart_do_not() {
        let front = camera("front", pose(50.3, 0.0), pose(50.0, 0.0));
        let rear = camera("rear", pose(299.6, 3.0), pose(300.0, 3.0));
        let errors = relative_errors(&front, &rear).unwrap();
        assert!((errors.own.heading_deg + 0.7).abs() < 1e-9, "{errors:?}");
        assert!((errors.own.angle_deg - 0.7).abs() < 1e-6, "{errors:?}");
    }

    #[test]
    fn without_a_truth_nothing_is_said() {
        let front = SeenCamera { truth: None, ..camera("front", pose(1.0, 0.0), pose(1.0, 0.0)) };
        assert!(heading_error(&front).is_none() && relative_errors(&front, &front).is_none());
    }
}
