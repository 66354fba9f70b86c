//! The accelerometer's residual: `r = u + b_a − a`, with `u` gravity's reaction turned into the
//! sensor (eq:Accelerometer, at rest or with accelerations that come and go).

use glam::{DMat3, DVec3};
use nalgebra::SMatrix;

use super::arrow::Residual;
use super::parameters::{
    ACCEL, DELAY, GLOBALS, GRAVITY, GYRO, GYRO_SLOPE, Globals, Knot, LOCALS, SCALE,
};
use super::turned::MeanVector;
use crate::linear::{matrix, vector};

/// The residual of a bin's mean reading, m/s²; its weight is that of one reading with σ = 1.
pub(crate) fn residual(
    globals: &Globals,
    knot: &Knot,
    mean: &MeanVector,
    reading: DVec3,
    warmer_k: f64,
) -> Residual<3> {
    let u = mean.u + mean.by_delay * globals.0[DELAY];
    let mut local = SMatrix::<f64, 3, LOCALS>::zeros();
    let mut global = SMatrix::<f64, 3, GLOBALS>::zeros();
    let by_bias = matrix(mean.by_bias);
    local.fixed_columns_mut::<3>(0).copy_from(&matrix(mean.by_rotation));
    local.fixed_columns_mut::<3>(3).copy_from(&by_bias);
    global.fixed_columns_mut::<3>(ACCEL).copy_from(&matrix(DMat3::IDENTITY));
    let up = mean.back * (knot.attitude.inverse() * DVec3::Z);
    global.set_column(GRAVITY, &vector(up));
    global.fixed_columns_mut::<3>(GYRO).copy_from(&by_bias);
    global.fixed_columns_mut::<3>(GYRO_SLOPE).copy_from(&(by_bias * warmer_k));
    global.fixed_columns_mut::<3>(SCALE).copy_from(&matrix(mean.by_scale));
    global.set_column(DELAY, &vector(mean.by_delay));
    let value = vector(u + globals.vector(ACCEL) - reading);
    Residual { value, local, global, weight: mean.count as f64 }
}
