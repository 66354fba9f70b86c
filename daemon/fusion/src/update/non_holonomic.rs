//! A vehicle moves neither sideways nor up and down.
//!
//! Residual `0 − v_V,y` and `0 − v_V,z`, Jacobian that of [`super::vehicle`] (Dissanayake et al. 2001).
//! What is not quite so counts as noise: tyres slip sideways in proportion to the sideways force, the body
//! pitches on its springs when it speeds up and brakes, and the lever arm is known to some centimetres.
//! These hang together, a pitch for as long as a braking lasts, and count only once in that time: taken for
//! white, they made the speed's scale wrong by 0.4 %.
//!
//! Gate: it is left out in turns too fast for a road vehicle that rolls, and where the joint innovation
//! of both does not fit; what does not fit for long is believed after all.

use glam::DVec3;

use super::vector::Whitened;
use super::vehicle;
use crate::history::Past;
use crate::parameters::VehicleParameters;
use crate::state::State;

/// Whether the vehicle may be taken to roll without skidding.
pub(crate) fn applies(past: &Past, p: &VehicleParameters) -> bool {
    p.non_holonomic && past.rate.abs().max_element() < p.max_turn_rad_s
}

/// The measurement; gravity is in the world, m/s².
pub(crate) fn measurement(
    state: &State,
    past: &Past,
    gravity: DVec3,
    p: &VehicleParameters,
) -> Whitened<2> {
    let velocity = vehicle::velocity(state, past, p);
    let [_, sideways, upward] = vehicle::rows(state, past, p);
    Whitened::independent(
        [past.carry(&sideways), past.carry(&upward)],
        [-velocity.y, -velocity.z],
        sigmas(past, velocity.x.abs(), forward_acceleration(past, gravity, p), p),
    )
}

/// Standard deviations sideways and upward, m/s, at a speed and an acceleration. What hangs together over
/// some time counts once in it.
fn sigmas(past: &Past, speed: f64, acceleration: f64, p: &VehicleParameters) -> [f64; 2] {
    let square = |x: f64| x * x;
    let times = |correlation_s: f64| (correlation_s / p.constraint_interval_s).max(1.0);
    let turn_rad_s = libm::sqrt(past.rate.length_squared());
    let lever = p.origin_sigma_m * turn_rad_s;
    let slip = p.slip_rad_per_m_s2 * turn_rad_s * speed * speed;
    let sway = (p.sway_rad + p.sway_rad_per_m_s2 * acceleration.abs()) * speed;
    let road = times(p.constraint_correlation_s);
    [
        libm::sqrt((square(p.sideways_sigma_m_s) + square(lever) + square(slip)) * road),
        libm::sqrt(
            (square(p.upward_sigma_m_s) + square(lever)) * road
                + square(sway) * times(p.sway_correlation_s),
        ),
    ]
}

/// How fast the vehicle speeds up, m/s².
fn forward_acceleration(past: &Past, gravity: DVec3, p: &VehicleParameters) -> f64 {
    let by_speed = past.force + past.orientation.conjugate() * gravity;
    p.vehicle_from_body.apply(by_speed).x
}
