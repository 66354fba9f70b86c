//! How well the heading is known with a calibration.
//!
//! A reading `m` becomes the field `B = A⁻¹ (m − b)`. Errors of the calibration, `A Exp(δ)` and `δb`,
//! turn it by `δB = −δ u − A⁻¹ δb`, `u = Rᵀ h`, and the heading by the east component of `R δB`
//! over the horizontal field.

use std::f64::consts::TAU;

use glam::{DMat3, DQuat, DVec3};
use nalgebra::{RowVector3, SMatrix};

use crate::linear::matrix;
use crate::solve::GlobalBlock;
use crate::solve::parameters::{Globals, HARD, HARD_SLOPE, SOFT};

/// Headings on the circle.
const HEADINGS: u32 = 24;
/// Soft iron, hard iron and its slope.
const PARAMETERS: usize = 15;

/// What the heading's error needs of a fit.
pub(crate) struct HeadingError<'a> {
    globals: &'a Globals,
    correction: DMat3,
    covariance: SMatrix<f64, PARAMETERS, PARAMETERS>,
}

impl<'a> HeadingError<'a> {
    pub(crate) fn new(globals: &'a Globals, covariance: &GlobalBlock) -> Self {
        let correction = globals.soft_iron().inverse();
        let covariance = covariance.fixed_view::<PARAMETERS, PARAMETERS>(SOFT, SOFT).into_owned();
        Self { globals, correction, covariance }
    }

    /// Root mean square over attitudes, each turned through the full circle, and temperatures, K
    /// above the reference; rad.
    pub(crate) fn over(&self, attitudes: &[(DQuat, f64)]) -> f64 {
        let circle = (0..HEADINGS).map(|k| TAU * f64::from(k) / f64::from(HEADINGS));
        let sum: f64 = circle
            .flat_map(|turn| attitudes.iter().map(move |&(attitude, t)| (turn, attitude, t)))
            .map(|(turn, attitude, t)| self.variance(DQuat::from_rotation_z(turn) * attitude, t))
            .sum();
        (sum / (f64::from(HEADINGS) * attitudes.len().max(1) as f64)).sqrt()
    }

    /// The same for a camera with a direction of its own up.
    pub(crate) fn level(&self, up: DVec3) -> f64 {
        self.over(&[(DQuat::from_rotation_arc(up, DVec3::Z), 0.0)])
    }

    fn variance(&self, attitude: DQuat, warmer_k: f64) -> f64 {
        let jacobian = self.jacobian(attitude, warmer_k);
        (jacobian * self.covariance * jacobian.transpose())[0]
    }

    /// Of the heading's error, rad, by soft iron, hard iron and slope.
    pub(crate) fn jacobian(&self, attitude: DQuat, warmer_k: f64) -> SMatrix<f64, 1, PARAMETERS> {
        let field = self.globals.field();
        let u = attitude.inverse() * field;
        let to_world = DMat3::from_quat(attitude);
        let east_of_field = matrix(to_world).row(0) / -field.y;
        let east = matrix(to_world * self.correction).row(0) / -field.y;
        let mut jacobian = SMatrix::<f64, 1, PARAMETERS>::zeros();
        let by_row = RowVector3::new(u.x, u.y, u.z);
        for row in 0..3 {
            let part = by_row * east_of_field[row];
            jacobian.fixed_columns_mut::<3>(SOFT + 3 * row).copy_from(&part);
        }
        jacobian.fixed_columns_mut::<3>(HARD).copy_from(&east);
        jacobian.fixed_columns_mut::<3>(HARD_SLOPE).copy_from(&(east * warmer_k));
        jacobian
    }
}
