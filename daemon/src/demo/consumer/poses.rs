//! Where a camera was at a cloud's time, by each of the sources that are compared.

use glam::{DMat3, DQuat, DVec3};
use lodestone_client::{
    Body, CameraNameError, CameraPose, Client, PoseStream, Rotation, Time, Transform, World,
};

use crate::demo::result::MeanPose;
use crate::demo::setup::without_magnetometer;

/// A camera's place in the world.
pub(super) type Place = Transform<World, Body>;

/// The poses of one camera beside its own.
#[derive(Debug)]
pub(super) struct OtherPoses {
    without_magnetometer: PoseStream,
    truth: PoseStream,
}

impl OtherPoses {
    pub(super) fn open(client: &Client, camera: &str) -> Result<Self, CameraNameError> {
        let twin = without_magnetometer(camera);
        Ok(Self {
            without_magnetometer: client.pose_stream(&twin)?.open(),
            truth: client.pose_stream(camera)?.truth().open(),
        })
    }

    /// By the poses without the magnetometer. Nobody vouches for their heading, which counts from wherever it
    /// was at the start: it is used all the same, because nothing better is there.
    pub(super) fn without_magnetometer(&mut self, time_ns: i64) -> Option<Place> {
        let pose = self.without_magnetometer.lookup(Time::Monotonic(time_ns)).ok()?;
        let orientation: Rotation<World, Body> = pose.orientation()?;
        Some(Transform::new(orientation, pose.position_m()?))
    }

    pub(super) fn truth(&mut self, time_ns: i64) -> Option<Place> {
        let pose = self.truth.lookup(Time::Monotonic(time_ns)).ok()?;
        pose.world_from_body().ok()
    }

    /// What is not there yet.
    pub(super) fn missing(&mut self) -> Option<&'static str> {
        let known = |pose: CameraPose| pose.orientation().is_some() && pose.position_m().is_some();
        if !self.without_magnetometer.latest().is_ok_and(known) {
            return Some("poses without the magnetometer");
        }
        (!self.truth.latest().is_ok_and(known)).then_some("the truth to compare with")
    }
}

/// Gathers poses for their mean.
#[derive(Clone, Copy, Debug)]
pub(super) struct PoseMean {
    count: f64,
    position_sum: DVec3,
    matrix_sum: DMat3,
    first: Option<DQuat>,
    yaw_sum: f64,
    yaw_square_sum: f64,
}

impl Default for PoseMean {
    /// Of no poses. A sum of matrices begins at zero, which is not the default of a matrix.
    fn default() -> Self {
        Self {
            count: 0.0,
            position_sum: DVec3::ZERO,
            matrix_sum: DMat3::ZERO,
            first: None,
            yaw_sum: 0.0,
            yaw_square_sum: 0.0,
        }
    }
}

impl PoseMean {
    pub(super) fn add(&mut self, place: &Place) {
        let orientation = place.rotation().quaternion();
        let first = *self.first.get_or_insert(orientation);
        // Turned since the first one, so that it never jumps by a whole turn.
        let yaw = (orientation * first.conjugate()).to_scaled_axis().z;
        self.count += 1.0;
        self.position_sum += place.origin();
        self.matrix_sum += DMat3::from_quat(orientation);
        self.yaw_sum += yaw;
        self.yaw_square_sum += yaw * yaw;
    }

    /// `None` before the first. The mean rotation is the one nearest to the mean of matrices (Markley et al. 2007);
    /// for poses within some degrees its columns, made orthogonal again, are that.
    pub(super) fn mean(&self) -> Option<MeanPose> {
        self.first?;
        let x = self.matrix_sum.x_axis.normalize();
        let y = (self.matrix_sum.y_axis - x * self.matrix_sum.y_axis.dot(x)).normalize();
        let orientation = DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y)));
        let yaw = self.yaw_sum / self.count;
        let variance = (self.yaw_square_sum / self.count - yaw * yaw).max(0.0);
        Some(MeanPose {
            position_m: (self.position_sum / self.count).to_array(),
            orientation: orientation.normalize().to_array(),
            heading_spread_deg: variance.sqrt().to_degrees(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_poses_around_one_is_that_one() {
        let middle = DQuat::from_rotation_z(3.1) * DQuat::from_rotation_y(0.1);
        let mut mean = PoseMean::default();
        for n in -5..=5 {
            let turned = DQuat::from_rotation_z(f64::from(n) * 0.01) * middle;
            let rotation = Rotation::from_quaternion(turned).unwrap();
            mean.add(&Transform::new(rotation, DVec3::X * f64::from(n)));
        }
        let mean = mean.mean().unwrap();
        let turn = DQuat::from_array(mean.orientation) * middle.conjugate();
        // Of second order: poses that spread by 2° and are tilted by 6°.
        assert!(turn.xyz().length() < 1e-4, "{turn}");
        assert!(mean.position_m.iter().all(|p| p.abs() < 1e-12));
        assert!((mean.heading_spread_deg.to_radians() - 0.01 * 10_f64.sqrt()).abs() < 1e-9);
        assert!((mean.yaw_rad() - 3.1).abs() < 1e-5);
    }

    #[test]
    fn without_poses_there_is_no_mean() {
        assert!(PoseMean::default().mean().is_none());
    }
}
