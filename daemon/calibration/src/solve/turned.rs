//! A vector of the world as the sensor sees it, averaged over a bin.

use glam::{DMat3, DVec3};
use lodestone_fusion::so3;
use nalgebra::SMatrix;

use super::arrow::Residual;
use super::parameters::{DELAY, GLOBALS, GYRO, GYRO_SLOPE, LOCALS, SCALE};
use super::segments::Turn;
use crate::linear::{matrix, vector};

/// Mean of `u = ΔRᵀ v` over readings, with its derivatives; `v` is the vector at the knot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turned {
    v: DVec3,
    count: usize,
    u: DVec3,
    back: DMat3,
    by_bias: DMat3,
    by_scale: DMat3,
    by_delay: DVec3,
}

/// The mean, and its derivatives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeanVector {
    /// Readings averaged.
    pub(crate) count: usize,
    /// Mean of `u`, without delay.
    pub(crate) u: DVec3,
    /// Mean of `ΔRᵀ`.
    pub(crate) back: DMat3,
    /// By the knot's rotation, in its sensor frame.
    pub(crate) by_rotation: DMat3,
    /// By the gyro bias.
    pub(crate) by_bias: DMat3,
    /// By the errors of the gyro's scale.
    pub(crate) by_scale: DMat3,
    /// By the delay of the reading.
    pub(crate) by_delay: DVec3,
}

impl MeanVector {
    /// A residual that sees the mean through a matrix, with the derivatives that every such residual
    /// has: by the knot, and by the gyro's bias, slope, scale and delay.
    pub(crate) fn residual(&self, through: DMat3, value: DVec3, warmer_k: f64) -> Residual<3> {
        let mut local = SMatrix::<f64, 3, LOCALS>::zeros();
        let mut global = SMatrix::<f64, 3, GLOBALS>::zeros();
        let by_bias = matrix(through * self.by_bias);
        local.fixed_columns_mut::<3>(0).copy_from(&matrix(through * self.by_rotation));
        local.fixed_columns_mut::<3>(3).copy_from(&by_bias);
        global.fixed_columns_mut::<3>(GYRO).copy_from(&by_bias);
        global.fixed_columns_mut::<3>(GYRO_SLOPE).copy_from(&(by_bias * warmer_k));
        global.fixed_columns_mut::<3>(SCALE).copy_from(&matrix(through * self.by_scale));
        global.set_column(DELAY, &vector(through * self.by_delay));
        Residual { value: vector(value), local, global, weight: self.count as f64 }
    }
}

impl Turned {
    pub(crate) const fn new(v: DVec3) -> Self {
        let zero = DMat3::ZERO;
        Self {
            v,
            count: 0,
            u: DVec3::ZERO,
            back: zero,
            by_bias: zero,
            by_scale: zero,
            by_delay: DVec3::ZERO,
        }
    }

    /// Takes the instant of one reading. `u` turns with `R Exp(φ)` by `u × φ`.
    pub(crate) fn add(&mut self, turn: &Turn) {
        let back = turn.rotation.transpose();
        let u = back * self.v;
        let cross = so3::skew(u);
        self.count += 1;
        self.u += u;
        self.back += back;
        self.by_bias += cross * turn.by_bias;
        self.by_scale += cross * turn.by_scale;
        self.by_delay += u.cross(turn.rate);
    }

    /// `None` if there was no reading.
    pub(crate) fn mean(&self) -> Option<MeanVector> {
        if self.count == 0 {
            return None;
        }
        let part = (self.count as f64).recip();
        let back = self.back * part;
        Some(MeanVector {
            count: self.count,
            u: self.u * part,
            back,
            by_rotation: back * so3::skew(self.v),
            by_bias: self.by_bias * part,
            by_scale: self.by_scale * part,
            by_delay: self.by_delay * part,
        })
    }
}
