//! The accelerometer's residual: `r = u + b_a − a`, with `u` gravity's reaction turned into the
//! sensor (eq:Accelerometer, at rest or with accelerations that come and go).

use glam::{DMat3, DVec3};

use super::arrow::Residual;
use super::parameters::{ACCEL, DELAY, GRAVITY, Globals, Knot};
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
    let value = u + globals.vector(ACCEL) - reading;
    let mut residual = mean.residual(DMat3::IDENTITY, value, warmer_k);
    let global = &mut residual.global;
    global.fixed_columns_mut::<3>(ACCEL).copy_from(&matrix(DMat3::IDENTITY));
    let up = mean.back * (knot.attitude.inverse() * DVec3::Z);
    global.set_column(GRAVITY, &vector(up));
    residual
}
