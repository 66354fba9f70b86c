//! Position, orientation and velocity in the world, by others' measurements.
//!
//! Position of a point at lever arm `l` in the body (an antenna): `z = p + R l`, residual
//! `z − p̂ − R̂ l`, Jacobian `I` on the position error and `−[R l]×` on the orientation error (Groves,
//! ch. 14.3). Velocity of such a point: `z = v + R (ω × l)`, Jacobian `I` on the velocity error,
//! `−[R (ω × l)]×` on the orientation error and `R [l]×` on the gyroscope's bias. Orientation: residual
//! `Log(R_z R̂ᵀ)`, Jacobian `I` on the orientation error. All at the time of validity, carried to the
//! present by [`crate::history`].
//!
//! The gate is the joint innovation of each three numbers, [`super::vector::GATE`]; what a gate refuses for
//! long is believed after all, [`crate::aiding`].

use glam::{DMat3, DQuat, DVec3};

use crate::covariance::{Block, GYRO_BIAS, ORIENTATION, POSITION, Row, STATES, VELOCITY};
use crate::history::Past;
use crate::so3;

/// Measured minus expected position, m in the world.
pub(crate) fn position_residual(past: &Past, measured: DVec3, lever_m: DVec3) -> DVec3 {
    measured - past.position - past.orientation * lever_m
}

/// Rows of the Jacobian of a position.
pub(crate) fn position_rows(past: &Past, lever_m: DVec3) -> [Row; 3] {
    let by_turn = so3::skew(past.orientation * -lever_m);
    core::array::from_fn(|k| {
        let mut row = unit_row(POSITION, k);
        row[ORIENTATION.0..ORIENTATION.0 + 3].copy_from_slice(&by_turn.row(k).to_array());
        row
    })
}

/// Turn from the expected to the measured orientation about the world axes, rad.
pub(crate) fn orientation_residual(past: &Past, measured: DQuat) -> DVec3 {
    so3::log(measured * past.orientation.conjugate())
}

/// Angle about up from the expected to the measured orientation, rad: the twist of their difference.
pub(crate) fn heading_residual(past: &Past, measured: DQuat) -> f64 {
    let turn = measured * past.orientation.conjugate();
    2.0 * libm::atan2(turn.z, turn.w)
}

/// Rows of the Jacobian of an orientation.
pub(crate) fn orientation_rows() -> [Row; 3] {
    core::array::from_fn(|k| unit_row(ORIENTATION, k))
}

/// Measured minus expected velocity, m/s in the world.
pub(crate) fn velocity_residual(past: &Past, measured: DVec3, lever_m: DVec3) -> DVec3 {
    measured - past.velocity - past.orientation * past.rate.cross(lever_m)
}

/// Rows of the Jacobian of a velocity.
pub(crate) fn velocity_rows(past: &Past, lever_m: DVec3) -> [Row; 3] {
    let by_turn = so3::skew(past.orientation * -past.rate.cross(lever_m));
    let by_bias = DMat3::from_quat(past.orientation) * so3::skew(lever_m);
    core::array::from_fn(|k| {
        let mut row = unit_row(VELOCITY, k);
        row[ORIENTATION.0..ORIENTATION.0 + 3].copy_from_slice(&by_turn.row(k).to_array());
        row[GYRO_BIAS.0..GYRO_BIAS.0 + 3].copy_from_slice(&by_bias.row(k).to_array());
        row
    })
}

fn unit_row(block: Block, axis: usize) -> Row {
    let mut row = [0.0; STATES];
    row[block.0 + axis] = 1.0;
    row
}
