//! The magnetometer's residual: `r = A u + b + b₁ (T − T₀) − m`, with `u` the field turned into
//! the sensor (maths.md, eq:CalibrationMagnetometer the other way round).

use glam::{DMat3, DVec3};
use nalgebra::SMatrix;

use super::arrow::Residual;
use super::parameters::{
    DELAY, FIELD, GLOBALS, GYRO, GYRO_SLOPE, Globals, HARD, HARD_SLOPE, Knot, LOCALS, MAG_DELAY,
    SCALE, SOFT,
};
use super::turned::MeanVector;
use crate::linear::{matrix, vector};

/// The residual of a bin's mean reading, µT; its weight is that of one reading with σ = 1.
pub(crate) fn residual(
    globals: &Globals,
    knot: &Knot,
    mean: &MeanVector,
    reading: DVec3,
    warmer_k: f64,
) -> Residual<3> {
    let soft_iron = globals.soft_iron();
    let u = mean.u + mean.by_delay * (globals.0[DELAY] + globals.0[MAG_DELAY]);
    let value = soft_iron * u + globals.hard_iron(warmer_k) - reading;
    let mut local = SMatrix::<f64, 3, LOCALS>::zeros();
    let mut global = SMatrix::<f64, 3, GLOBALS>::zeros();
    let by_bias = matrix(soft_iron * mean.by_bias);
    local.fixed_columns_mut::<3>(0).copy_from(&matrix(soft_iron * mean.by_rotation));
    local.fixed_columns_mut::<3>(3).copy_from(&by_bias);
    for (n, part) in u.to_array().into_iter().enumerate() {
        // A (I + δ) u: the element (i, n) of δ adds column i of A, as often as u has in n.
        for i in 0..3 {
            global.set_column(SOFT + 3 * i + n, &vector(soft_iron.col(i) * part));
        }
    }
    global.fixed_columns_mut::<3>(HARD).copy_from(&matrix(DMat3::IDENTITY));
    global.fixed_columns_mut::<3>(HARD_SLOPE).copy_from(&matrix(DMat3::IDENTITY * warmer_k));
    let by_field = soft_iron * mean.back * DMat3::from_quat(knot.attitude.inverse());
    global.set_column(FIELD, &vector(by_field.y_axis));
    global.set_column(FIELD + 1, &vector(-by_field.z_axis));
    global.fixed_columns_mut::<3>(GYRO).copy_from(&by_bias);
    global.fixed_columns_mut::<3>(GYRO_SLOPE).copy_from(&(by_bias * warmer_k));
    global.fixed_columns_mut::<3>(SCALE).copy_from(&matrix(soft_iron * mean.by_scale));
    for delay in [DELAY, MAG_DELAY] {
        global.set_column(delay, &vector(soft_iron * mean.by_delay));
    }
    Residual { value: vector(value), local, global, weight: mean.count as f64 }
}
