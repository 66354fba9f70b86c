//! Velocity of a vehicle's origin along the vehicle's own axes: what speed and constraint look at.
//!
//! The origin is where the vehicle moves neither sideways nor up and down, in the middle of the axle
//! that does not steer, at `l` from the camera in the body. With the mounting `R_VB` and its error
//! `m` about y and z,
//!
//! ```text
//! v_V = Exp(m) R_VB (Rᵀ v + (ω_m − b_g) × l)
//! ```
//!
//! and the Jacobian (Dissanayake et al. 2001; Groves, ch. 15.4), errors about the world axes:
//!
//! ```text
//! ∂v_V/∂v = C    ∂v_V/∂θ = C [v]×    ∂v_V/∂b_g = Exp(m) R_VB [l]×    ∂v_V/∂m = −[v_V]×    C = Exp(m) R_VB Rᵀ
//! ```

use glam::{DMat3, DVec3};

use crate::covariance::{GYRO_BIAS, MOUNTING, ORIENTATION, Row, STATES, VELOCITY};
use crate::history::Past;
use crate::parameters::VehicleParameters;
use crate::so3;
use crate::state::State;

/// Velocity of the vehicle's origin in the vehicle's axes, m/s.
pub(crate) fn velocity(state: &State, past: &Past, p: &VehicleParameters) -> DVec3 {
    let at_origin = past.orientation.conjugate() * past.velocity + past.rate.cross(p.origin_m);
    vehicle_from_body(state, p) * at_origin
}

/// Rows of the Jacobian of [`velocity`] about the errors at the time of validity.
pub(crate) fn rows(state: &State, past: &Past, p: &VehicleParameters) -> [Row; 3] {
    let turn = vehicle_from_body(state, p);
    let by_velocity = turn * DMat3::from_quat(past.orientation).transpose();
    let by_angle = by_velocity * so3::skew(past.velocity);
    let by_bias = turn * so3::skew(p.origin_m);
    let by_mounting = so3::skew(-velocity(state, past, p)) * mounting_slopes(state);
    core::array::from_fn(|k| {
        let mut row = [0.0; STATES];
        let mut put = |first: usize, v: DVec3| row[first..first + 3].copy_from_slice(&v.to_array());
        put(ORIENTATION.0, by_angle.row(k));
        put(VELOCITY.0, by_velocity.row(k));
        put(GYRO_BIAS.0, by_bias.row(k));
        row[MOUNTING] = by_mounting.y_axis[k];
        row[MOUNTING + 1] = by_mounting.z_axis[k];
        row
    })
}

fn vehicle_from_body(state: &State, p: &VehicleParameters) -> DMat3 {
    DMat3::from_quat(so3::exp(mounting(state))) * p.vehicle_from_body.matrix()
}

fn mounting(state: &State) -> DVec3 {
    DVec3::new(0.0, state.mounting_rad[0], state.mounting_rad[1])
}

/// How the vehicle turns about its own axes for a change of the mounting's angles: the left Jacobian of
/// the exponential map, to third order (Solà, eq. 145).
fn mounting_slopes(state: &State) -> DMat3 {
    let skew = so3::skew(mounting(state));
    let twice = skew * skew;
    DMat3::IDENTITY + 0.5 * skew + twice * (1.0 / 6.0) + twice * skew * (1.0 / 24.0)
}
