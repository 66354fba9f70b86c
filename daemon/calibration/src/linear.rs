//! From glam's vectors to nalgebra's blocks.

use glam::{DMat3, DVec3};
use nalgebra::{Matrix3, Vector3};

/// The same matrix.
pub(crate) fn matrix(m: DMat3) -> Matrix3<f64> {
    Matrix3::from_column_slice(&m.to_cols_array())
}

/// The same vector.
pub(crate) fn vector(v: DVec3) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

/// The same vector.
pub(crate) fn dvec(v: Vector3<f64>) -> DVec3 {
    DVec3::new(v.x, v.y, v.z)
}
