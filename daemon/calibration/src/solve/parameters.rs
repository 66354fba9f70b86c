//! What is estimated: one set for the recording, and one attitude and gyro bias for each knot.

use glam::{DMat3, DQuat, DVec3};
use lodestone_fusion::so3;
use nalgebra::{Matrix3, SVector};

use crate::linear::matrix;

/// Number of the recording's parameters.
pub(crate) const GLOBALS: usize = 32;
/// Number of a knot's parameters: rotation in the sensor frame, deviation of the gyro bias.
pub(crate) const LOCALS: usize = 6;

/// Soft iron `A`, row by row; a step `δ` takes it to `A Exp(δ)`. So a turn of the soft iron, the
/// direction that is known worst, is a straight way for the search.
pub(crate) const SOFT: usize = 0;
/// Hard iron `b`, µT.
pub(crate) const HARD: usize = 9;
/// Its slope `b₁`, µT/K.
pub(crate) const HARD_SLOPE: usize = 12;
/// Horizontal field (north) and vertical field (down), µT.
pub(crate) const FIELD: usize = 15;
/// Accelerometer bias, m/s².
pub(crate) const ACCEL: usize = 17;
/// Gyroscope bias, rad/s.
pub(crate) const GYRO: usize = 20;
/// Its slope, rad/s/K.
pub(crate) const GYRO_SLOPE: usize = 23;
/// Error of the gyroscope's scale, a ratio.
pub(crate) const SCALE: usize = 26;
/// Gravity, m/s².
pub(crate) const GRAVITY: usize = 29;
/// How much later than the integrated gyroscope accelerometer and magnetometer read, s.
pub(crate) const DELAY: usize = 30;
/// How much later than the accelerometer the magnetometer reads, s.
pub(crate) const MAG_DELAY: usize = 31;

/// A step of the recording's parameters.
pub(crate) type GlobalStep = SVector<f64, GLOBALS>;
/// A step of one knot's parameters.
pub(crate) type LocalStep = SVector<f64, LOCALS>;

/// The recording's parameters.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Globals(pub(crate) GlobalStep);

/// One knot's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Knot {
    /// Sensor to W: x east, y magnetic north, z up.
    pub(crate) attitude: DQuat,
    /// Gyro bias less that of the recording, rad/s.
    pub(crate) bias: DVec3,
}

/// A point of the search.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct State {
    pub(crate) globals: Globals,
    pub(crate) knots: Vec<Knot>,
}

impl Globals {
    /// Three neighbouring parameters as a vector.
    pub(crate) fn vector(&self, at: usize) -> DVec3 {
        DVec3::new(self.0[at], self.0[at + 1], self.0[at + 2])
    }

    /// Puts a vector in.
    pub(crate) fn set(&mut self, at: usize, v: DVec3) {
        self.0.fixed_rows_mut::<3>(at).copy_from_slice(&v.to_array());
    }

    /// Soft iron `A`.
    pub(crate) fn soft_iron(&self) -> DMat3 {
        let rows = Matrix3::from_row_slice(&self.0.as_slice()[SOFT..SOFT + 9]);
        DMat3::from_cols_slice(rows.as_slice())
    }

    /// A step: `A Exp(δ)`, the others add up.
    pub(crate) fn stepped(&self, step: &GlobalStep) -> Self {
        let delta = Matrix3::from_row_slice(&step.as_slice()[SOFT..SOFT + 9]);
        let square = delta * delta;
        let factor = Matrix3::identity() + delta + square * 0.5 + square * delta * (1.0 / 6.0);
        let soft_iron = matrix(self.soft_iron()) * factor;
        let mut stepped = Self(self.0 + step);
        stepped.0.fixed_rows_mut::<9>(SOFT).copy_from_slice(soft_iron.transpose().as_slice());
        stepped
    }

    /// The field in W, µT.
    pub(crate) fn field(&self) -> DVec3 {
        DVec3::new(0.0, self.0[FIELD], -self.0[FIELD + 1])
    }

    /// Gravity's reaction in W, m/s².
    pub(crate) fn gravity(&self) -> DVec3 {
        DVec3::new(0.0, 0.0, self.0[GRAVITY])
    }

    /// Hard iron at a temperature, µT.
    pub(crate) fn hard_iron(&self, warmer_k: f64) -> DVec3 {
        self.vector(HARD) + self.vector(HARD_SLOPE) * warmer_k
    }

    /// Gyro bias at a temperature, rad/s.
    pub(crate) fn gyro_bias(&self, warmer_k: f64) -> DVec3 {
        self.vector(GYRO) + self.vector(GYRO_SLOPE) * warmer_k
    }
}

impl Knot {
    /// A step on the manifold: the rotation acts in the sensor frame.
    pub(crate) fn stepped(&self, step: &LocalStep) -> Self {
        let rotation = DVec3::new(step[0], step[1], step[2]);
        let bias = DVec3::new(step[3], step[4], step[5]);
        Self { attitude: (self.attitude * so3::exp(rotation)).normalize(), bias: self.bias + bias }
    }
}

impl State {
    /// A step on the manifold.
    pub(crate) fn stepped(&self, globals: &GlobalStep, locals: &[LocalStep]) -> Self {
        Self {
            globals: self.globals.stepped(globals),
            knots: self.knots.iter().zip(locals).map(|(knot, step)| knot.stepped(step)).collect(),
        }
    }
}
