//! Forward speed of a vehicle, from its wheels.
//!
//! `z = (1 + s) v_V,x` with a scale factor `s` (worn or warm tyres), which is a state; residual
//! `z − (1 + ŝ) v̂_V,x`, Jacobian that of [`super::vehicle`] and `v_V,x` on `s`. Reversing is a negative
//! speed. Errors of successive readings hang together (quantisation, slip), so a reading counts only for
//! its share of the time over which they do.

use super::vector::Whitened;
use super::vehicle;
use crate::covariance::SPEED_SCALE;
use crate::history::Past;
use crate::parameters::VehicleParameters;
use crate::state::State;

/// Measured minus expected speed, m/s.
pub(crate) fn residual(state: &State, past: &Past, measured: f64, p: &VehicleParameters) -> f64 {
    measured - (1.0 + state.speed_scale) * vehicle::velocity(state, past, p).x
}

/// The measurement, with the time since the last one, s.
pub(crate) fn measurement(
    state: &State,
    past: &Past,
    (measured, sigma_m_s): (f64, f64),
    (since_s, p): (f64, &VehicleParameters),
) -> Whitened<1> {
    let correlated = (p.speed_correlation_s / since_s.max(1e-3)).max(1.0);
    let sigma = sigma_m_s.max(p.speed_floor_m_s) * libm::sqrt(correlated);
    let residual = residual(state, past, measured, p);
    Whitened::independent([past.carry(&row(state, past, p))], [residual], [sigma])
}

/// Row of the Jacobian about the errors at the time of validity.
pub(crate) fn row(state: &State, past: &Past, p: &VehicleParameters) -> crate::covariance::Row {
    let mut row = vehicle::rows(state, past, p)[0].map(|x| x * (1.0 + state.speed_scale));
    row[SPEED_SCALE] = vehicle::velocity(state, past, p).x;
    row
}
