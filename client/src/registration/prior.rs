//! What is known of a pose before clouds are compared, and how surely.

use glam::{DMat3, DVec3};
use nalgebra::{Matrix3, Matrix6, Vector6};

use crate::covariance::cross_matrix;
use crate::error::NotValid;
use crate::frame::{Body, World};
use crate::pose::CameraPose;
use crate::transform::Transform;

/// Covariance of a pose: of its orientation as a small rotation vector about the world's axes, and of
/// its position in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseCovariance {
    /// Of the orientation, rad².
    pub orientation_rad2: DMat3,
    /// Of position (rows) with orientation (columns), m rad.
    pub cross_m_rad: DMat3,
    /// Of the position, m².
    pub position_m2: DMat3,
}

impl PoseCovariance {
    /// Orientation and position that have nothing to do with each other.
    pub const fn independent(orientation_rad2: DMat3, position_m2: DMat3) -> Self {
        Self { orientation_rad2, cross_m_rad: DMat3::ZERO, position_m2 }
    }

    /// Of a pose that is the product of this one and an independent other error.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            orientation_rad2: self.orientation_rad2 + other.orientation_rad2,
            cross_m_rad: self.cross_m_rad + other.cross_m_rad,
            position_m2: self.position_m2 + other.position_m2,
        }
    }

    /// What the same error is for something rigidly fixed to the pose, `arm_m` away from it in the world's
    /// axes: a turn moves it by `φ × arm`.
    pub(crate) fn at_arm(&self, arm_m: DVec3) -> Self {
        let lever = -cross_matrix(arm_m);
        let turned = lever * self.orientation_rad2;
        let mixed = lever * self.cross_m_rad.transpose();
        let position_m2 = self.position_m2 + turned * lever.transpose() + mixed + mixed.transpose();
        let cross_m_rad = self.cross_m_rad + turned;
        Self { orientation_rad2: self.orientation_rad2, cross_m_rad, position_m2 }
    }

    /// Orientation first, then position.
    pub(crate) fn matrix(&self) -> Matrix6<f64> {
        let mut all = Matrix6::zeros();
        let cross = matrix3(self.cross_m_rad);
        all.fixed_view_mut::<3, 3>(0, 0).copy_from(&matrix3(self.orientation_rad2));
        all.fixed_view_mut::<3, 3>(3, 0).copy_from(&cross);
        all.fixed_view_mut::<3, 3>(0, 3).copy_from(&cross.transpose());
        all.fixed_view_mut::<3, 3>(3, 3).copy_from(&matrix3(self.position_m2));
        all
    }

    pub(super) fn from_matrix(all: &Matrix6<f64>) -> Self {
        let block = |row, column| dmat3(&all.fixed_view::<3, 3>(row, column).into_owned());
        Self { orientation_rad2: block(0, 0), cross_m_rad: block(3, 0), position_m2: block(3, 3) }
    }
}

/// The pose at which a registration begins, as a measurement with its covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PosePrior {
    /// Where the camera is believed to be.
    pub world_from_body: Transform<World, Body>,
    /// How surely.
    pub covariance: PoseCovariance,
}

impl TryFrom<&CameraPose> for PosePrior {
    type Error = NotValid;

    /// Takes the daemon's word; its poses carry no covariance between orientation and position.
    fn try_from(pose: &CameraPose) -> Result<Self, NotValid> {
        let world_from_body = pose.world_from_body()?;
        let missing = || NotValid(lodestone_schema::Validity::HEADING);
        let orientation = pose.orientation_covariance_rad2().ok_or_else(missing)?;
        let position = pose.position_covariance_m2().ok_or_else(missing)?;
        let covariance = PoseCovariance::independent(orientation, position);
        Ok(Self { world_from_body, covariance })
    }
}

pub(super) fn matrix3(m: DMat3) -> Matrix3<f64> {
    Matrix3::from_column_slice(&m.to_cols_array())
}

fn dmat3(m: &Matrix3<f64>) -> DMat3 {
    DMat3::from_cols_array(&core::array::from_fn(|i| m[(i % 3, i / 3)]))
}

/// Rotation first, then translation.
pub(super) fn stack(rotation: DVec3, translation: DVec3) -> Vector6<f64> {
    let (r, t) = (rotation, translation);
    Vector6::new(r.x, r.y, r.z, t.x, t.y, t.z)
}

/// The two halves of [`stack`].
pub(super) fn halves(v: &Vector6<f64>) -> (DVec3, DVec3) {
    (DVec3::new(v[0], v[1], v[2]), DVec3::new(v[3], v[4], v[5]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_moves_what_is_far_away() {
        let turn = DMat3::from_diagonal(DVec3::new(0.0, 0.0, 1e-4));
        let far = PoseCovariance::independent(turn, DMat3::IDENTITY * 1e-6).at_arm(DVec3::X * 5.0);
        // 0.01 rad about up, at 5 m east: 5 cm north.
        let north = far.position_m2.y_axis.y.sqrt();
        assert!((north - 0.05).abs() < 1e-4, "{north}");
        assert!((far.position_m2.x_axis.x - 1e-6).abs() < 1e-15);
        assert!((far.cross_m_rad.z_axis.y - 5e-4).abs() < 1e-12, "{}", far.cross_m_rad);
        // And back again.
        let back = far.at_arm(DVec3::X * -5.0);
        assert!(back.position_m2.abs_diff_eq(DMat3::IDENTITY * 1e-6, 1e-12));
        assert!(back.cross_m_rad.abs_diff_eq(DMat3::ZERO, 1e-12));
    }

    #[test]
    fn blocks_and_matrix_are_inverse() {
        let blocks = PoseCovariance {
            orientation_rad2: DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0)),
            cross_m_rad: DMat3::from_cols(DVec3::X, DVec3::new(0.5, 0.1, 0.2), DVec3::ZERO),
            position_m2: DMat3::from_diagonal(DVec3::new(4.0, 5.0, 6.0)),
        };
        let matrix = blocks.matrix();
        assert_eq!(matrix, matrix.transpose());
        assert_eq!(matrix[(3, 0)], 1.0);
        assert_eq!(PoseCovariance::from_matrix(&matrix), blocks);
    }
}
