//! A vehicle moves neither sideways nor up and down.
//!
//! Residual `0 − v_V,y` and `0 − v_V,z`, Jacobian that of [`super::vehicle`] (Dissanayake et al. 2001).
//! What is not quite so counts as noise: tyres slip sideways in proportion to the sideways force, the body
//! sways on its springs in proportion to the speed, and the lever arm is known to some centimetres. These
//! hang together over about half a second, so the constraint counts once in that time.
//!
//! Gate: it is left out in turns too fast for a road vehicle that rolls, and where the joint innovation
//! of both does not fit; what does not fit for long is believed after all.

use super::vector::Whitened;
use super::vehicle;
use crate::history::Past;
use crate::parameters::VehicleParameters;
use crate::state::State;

/// Whether the vehicle may be taken to roll without skidding.
pub(crate) fn applies(past: &Past, p: &VehicleParameters) -> bool {
    p.non_holonomic && past.rate.abs().max_element() < p.max_turn_rad_s
}

/// The measurement.
pub(crate) fn measurement(state: &State, past: &Past, p: &VehicleParameters) -> Whitened<2> {
    let velocity = vehicle::velocity(state, past, p);
    let [_, sideways, upward] = vehicle::rows(state, past, p);
    let turn_rad_s = libm::sqrt(past.rate.length_squared());
    let speed = velocity.x.abs();
    let lever = p.origin_sigma_m * turn_rad_s;
    let slip = p.slip_rad_per_m_s2 * turn_rad_s * speed * speed;
    let square = |x: f64| x * x;
    let weight = libm::sqrt((p.constraint_correlation_s / p.constraint_interval_s).max(1.0));
    let sigma = |own: f64, with_speed: f64| {
        libm::sqrt(square(own) + square(lever) + square(with_speed)) * weight
    };
    Whitened::independent(
        [past.carry(&sideways), past.carry(&upward)],
        [-velocity.y, -velocity.z],
        [sigma(p.sideways_sigma_m_s, slip), sigma(p.upward_sigma_m_s, p.sway_rad * speed)],
    )
}
