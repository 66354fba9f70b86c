//! The magnetometer's residual: `r = A u + b + b₁ (T − T₀) − m`, with `u` the field turned into
//! the sensor (maths.md, eq:CalibrationMagnetometer the other way round).

use glam::{DMat3, DVec3};

use super::arrow::Residual;
use super::parameters::{DELAY, FIELD, Globals, HARD, HARD_SLOPE, Knot, MAG_DELAY, SOFT};
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
    let mut residual = mean.residual(soft_iron, value, warmer_k);
    let global = &mut residual.global;
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
    global.set_column(MAG_DELAY, &vector(soft_iron * mean.by_delay));
    residual
}
