//! A small movement of a cloud as a whole, and its manifold.

use glam::{DMat3, DQuat, DVec3};
use nalgebra::{Matrix6, Vector6};

use super::prior::{halves, matrix3, stack};
use crate::covariance::cross_matrix;
use crate::frame::{Rotation, World};
use crate::transform::Transform;

/// A movement within the world: turned by `rotation` about `pivot_m`, then shifted.
///
/// The pivot is the prior's position of the body. So a step `δ = (φ, τ)`, rotation `Exp(φ) R` and
/// translation `t + τ`, is the error of the pose in the terms of its covariance: a rotation vector about
/// the world's axes, and a shift of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correction {
    rotation: DQuat,
    translation_m: DVec3,
    pivot_m: DVec3,
}

impl Correction {
    /// A turn about the world's axes, rad, around a pivot, m, and a shift, m.
    pub(crate) fn new(pivot_m: DVec3, turn_rad: DVec3, translation_m: DVec3) -> Self {
        Self { rotation: DQuat::from_scaled_axis(turn_rad), translation_m, pivot_m }
    }

    /// The opposite of [`Correction::vector`].
    pub(crate) fn about(pivot_m: DVec3, vector: &Vector6<f64>) -> Self {
        let (turn, shift) = halves(vector);
        Self::new(pivot_m, turn, shift)
    }

    /// No movement.
    pub(super) const fn none(pivot_m: DVec3) -> Self {
        Self { rotation: DQuat::IDENTITY, translation_m: DVec3::ZERO, pivot_m }
    }

    /// The rotation as a vector about the world's axes, rad.
    pub fn rotation_rad(&self) -> DVec3 {
        let shortest = if self.rotation.w < 0.0 { -self.rotation } else { self.rotation };
        shortest.to_scaled_axis()
    }

    /// How far the body moves, m.
    pub const fn translation_m(&self) -> DVec3 {
        self.translation_m
    }

    /// The movement as a transform of world coordinates.
    pub fn transform(&self) -> Transform<World, World> {
        let shift = self.pivot_m + self.translation_m - self.rotation * self.pivot_m;
        Transform::new(Rotation::from_unit(self.rotation), shift)
    }

    /// Where a point goes, m.
    pub(super) fn apply(&self, point: DVec3) -> DVec3 {
        self.pivot_m + self.translation_m + self.arm(point)
    }

    /// From the moved body to the moved point, m.
    pub(super) fn arm(&self, point: DVec3) -> DVec3 {
        self.turn(point - self.pivot_m)
    }

    /// Which way a direction is turned.
    pub(super) fn turn(&self, direction: DVec3) -> DVec3 {
        self.rotation * direction
    }

    /// `x ⊞ δ`.
    pub(super) fn plus(&self, step: &Vector6<f64>) -> Self {
        let (turn, shift) = halves(step);
        let rotation = (DQuat::from_scaled_axis(turn) * self.rotation).normalize();
        Self { rotation, translation_m: self.translation_m + shift, ..*self }
    }

    /// `(Log R, t)`: how far it is from no movement.
    pub(crate) fn vector(&self) -> Vector6<f64> {
        stack(self.rotation_rad(), self.translation_m)
    }

    /// How [`Correction::vector`] changes with a step: `J_l⁻¹(Log R)` and identity (Solà, Deray,
    /// Atchuthan 2018, "A micro Lie theory", eq. 146).
    pub(super) fn vector_jacobian(&self) -> Matrix6<f64> {
        let mut jacobian = Matrix6::identity();
        let turn = matrix3(left_jacobian_inverse(self.rotation_rad()));
        jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&turn);
        jacobian
    }
}

fn left_jacobian_inverse(turn: DVec3) -> DMat3 {
    let (angle, cross) = (turn.length(), cross_matrix(turn));
    // The limit of (1/θ² - (1 + cos θ) / (2 θ sin θ)) at zero; next term θ²/720.
    let second = if angle < 1e-3 {
        1.0 / 12.0
    } else {
        angle.powi(-2) - (1.0 + angle.cos()) / (2.0 * angle * angle.sin())
    };
    DMat3::IDENTITY - cross * 0.5 + cross * cross * second
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn corrections() -> impl Strategy<Value = Correction> {
        let vector = || prop::array::uniform3(-1.0..1.0_f64).prop_map(DVec3::from_array);
        (vector(), vector(), vector()).prop_map(|(turn, shift, pivot)| {
            Correction::none(pivot * 10.0).plus(&stack(turn * 1.5, shift))
        })
    }

    proptest! {
        #[test]
        fn the_transform_does_what_the_correction_does(c in corrections(), x in -5.0..5.0_f64) {
            let point = DVec3::new(x, 1.0, -2.0);
            prop_assert!(c.transform().apply(point).abs_diff_eq(c.apply(point), 1e-9));
        }

        #[test]
        fn jacobian_of_the_vector_is_its_central_difference(c in corrections()) {
            let jacobian = c.vector_jacobian();
            for axis in 0..6 {
                let step = Vector6::ith(axis, 1e-6);
                let slope = (c.plus(&step).vector() - c.plus(&-step).vector()) / 2e-6;
                prop_assert!((slope - jacobian.column(axis)).norm() < 1e-7);
            }
        }
    }

    #[test]
    fn near_no_rotation_the_jacobian_is_smooth() {
        for angle in [0.0, 1e-9, 0.999e-3, 1.001e-3] {
            let c = Correction::none(DVec3::ZERO).plus(&stack(DVec3::Z * angle, DVec3::ZERO));
            let step = Vector6::ith(0, 1e-6);
            let slope = (c.plus(&step).vector() - c.plus(&-step).vector()) / 2e-6;
            assert!((slope - c.vector_jacobian().column(0)).norm() < 1e-8, "{angle}");
        }
    }
}
