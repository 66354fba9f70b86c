//! What the gyroscope says of two neighbouring knots: `r = Log(ΔRᵀ R_kᵀ R_{k+1})` (Forster et al.,
//! TRO 2017, eq. 37), and the random walk of its bias.

use glam::DMat3;
use lodestone_fusion::so3;
use nalgebra::SMatrix;

use super::arrow::Residual;
use super::parameters::{GLOBALS, GYRO, GYRO_SLOPE, Knot, LOCALS, SCALE};
use super::segments::{Segment, Turn};
use crate::linear::{matrix, vector};

/// A residual with its Jacobian by the next knot.
pub(crate) struct Link {
    pub(crate) residual: Residual<3>,
    pub(crate) next: SMatrix<f64, 3, LOCALS>,
}

/// The rotation, rad, for a noise density of 1 rad/s/√Hz.
pub(crate) fn rotation(knot: &Knot, next: &Knot, turn: &Turn, segment: &Segment) -> Link {
    let between = DMat3::from_quat(knot.attitude.inverse() * next.attitude);
    let back = turn.rotation.transpose();
    let left = back * between;
    let error = so3::log(glam::DQuat::from_mat3(&left).normalize());
    let by_next = inverse_right_jacobian(error);
    let by_turn = -(by_next * left.transpose());
    let mut local = SMatrix::<f64, 3, LOCALS>::zeros();
    let mut global = SMatrix::<f64, 3, GLOBALS>::zeros();
    let by_bias = matrix(by_turn * turn.by_bias);
    local.fixed_columns_mut::<3>(0).copy_from(&matrix(by_turn * back));
    local.fixed_columns_mut::<3>(3).copy_from(&by_bias);
    global.fixed_columns_mut::<3>(GYRO).copy_from(&by_bias);
    global.fixed_columns_mut::<3>(GYRO_SLOPE).copy_from(&(by_bias * segment.warmer_k));
    global.fixed_columns_mut::<3>(SCALE).copy_from(&matrix(by_turn * turn.by_scale));
    let mut after = SMatrix::<f64, 3, LOCALS>::zeros();
    after.fixed_columns_mut::<3>(0).copy_from(&matrix(by_next));
    let residual =
        Residual { value: vector(error), local, global, weight: segment.duration_s.recip() };
    Link { residual, next: after }
}

/// The bias, rad/s, for a random walk of 1 rad/s²/√Hz.
pub(crate) fn bias(knot: &Knot, next: &Knot, segment: &Segment) -> Link {
    let mut local = SMatrix::<f64, 3, LOCALS>::zeros();
    let mut after = SMatrix::<f64, 3, LOCALS>::zeros();
    local.fixed_columns_mut::<3>(3).copy_from(&-matrix(DMat3::IDENTITY));
    after.fixed_columns_mut::<3>(3).copy_from(&matrix(DMat3::IDENTITY));
    let value = vector(next.bias - knot.bias);
    let weight = segment.duration_s.recip();
    Link { residual: Residual { value, local, global: SMatrix::zeros(), weight }, next: after }
}

/// `Log(Exp(θ) Exp(δ)) = θ + J δ` (Solà, eq. 144), to the third order: links fit well.
fn inverse_right_jacobian(angle: glam::DVec3) -> DMat3 {
    let cross = so3::skew(angle);
    DMat3::IDENTITY + cross * 0.5 + cross * cross * (1.0 / 12.0)
}
