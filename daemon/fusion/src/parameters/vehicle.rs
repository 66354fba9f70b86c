//! A road vehicle that carries the camera.

use glam::DVec3;

use crate::frame::{Body, Rotation, Vehicle};

/// A road vehicle that carries the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VehicleParameters {
    /// The camera's attitude on the vehicle.
    pub vehicle_from_body: Rotation<Vehicle, Body>,
    /// From the camera's body origin to the vehicle's, in the body, m. The vehicle's origin is in the
    /// middle of the axle that does not steer.
    pub origin_m: DVec3,
    /// How well that is known, 1σ, m. Default 0.05.
    pub origin_sigma_m: f64,
    /// How well the camera's pitch and yaw on the vehicle are known, 1σ, rad. Default 1°.
    pub mounting_sigma_rad: f64,
    /// Whether the vehicle moves neither sideways nor up and down. Default true.
    pub non_holonomic: bool,
    /// Sideways velocity of a vehicle that drives straight on, 1σ, m/s. Default 0.05.
    pub sideways_sigma_m_s: f64,
    /// Upward velocity against the vehicle's own floor at low speed, 1σ, m/s. Default 0.1.
    pub upward_sigma_m_s: f64,
    /// Slip angle of the tyres for each m/s² of sideways acceleration, 1σ, rad. Default 6 mrad, that of
    /// a passenger car.
    pub slip_rad_per_m_s2: f64,
    /// Pitch of the body on its springs at constant speed, 1σ, rad. Default 4 mrad.
    pub sway_rad: f64,
    /// Pitch of the body for each m/s² of throttle or braking, 1σ, rad. Default 6 mrad, that of a
    /// passenger car.
    pub sway_rad_per_m_s2: f64,
    /// Time over which the pitch on the springs hangs together, s: that of a braking. Default 3.
    pub sway_correlation_s: f64,
    /// Turn rate beyond which it may skid, rad/s. Default 1.5.
    pub max_turn_rad_s: f64,
    /// Seconds between two uses of the constraint. Default 0.1.
    pub constraint_interval_s: f64,
    /// Time over which its errors hang together, s. Default 0.5.
    pub constraint_correlation_s: f64,
    /// Scale error of the speed, 1σ, a part of one. Default 1 %.
    pub speed_scale_sigma: f64,
    /// Noise of a speed that does not say its own, 1σ, m/s. Default 0.1.
    pub speed_sigma_m_s: f64,
    /// Least noise that a speed is believed to have, 1σ, m/s. Default 0.02.
    pub speed_floor_m_s: f64,
    /// Time over which errors of the speed hang together, s. Default 0.1.
    pub speed_correlation_s: f64,
}

impl VehicleParameters {
    /// A vehicle on which the camera sits like this.
    pub const fn mounted(vehicle_from_body: Rotation<Vehicle, Body>, origin_m: DVec3) -> Self {
        Self {
            vehicle_from_body,
            origin_m,
            origin_sigma_m: 0.05,
            mounting_sigma_rad: 0.0175,
            non_holonomic: true,
            sideways_sigma_m_s: 0.05,
            upward_sigma_m_s: 0.1,
            slip_rad_per_m_s2: 6e-3,
            sway_rad: 4e-3,
            sway_rad_per_m_s2: 6e-3,
            sway_correlation_s: 3.0,
            max_turn_rad_s: 1.5,
            constraint_interval_s: 0.1,
            constraint_correlation_s: 0.5,
            speed_scale_sigma: 0.01,
            speed_sigma_m_s: 0.1,
            speed_floor_m_s: 0.02,
            speed_correlation_s: 0.1,
        }
    }
}
