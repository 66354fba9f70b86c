//! What others measure, and whether it can be a measurement at all.

use glam::{DMat3, DVec3};

use crate::aid_status::AidKind;
use crate::frame::{Body, Rotation, World};
use crate::time::SensorTime;
use crate::update::vector::inverse_root;

/// What a measurement says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measurement {
    /// Speed of the vehicle's origin along the vehicle's x axis.
    Speed {
        /// m/s, backwards negative.
        speed_m_s: f64,
        /// 1σ, m/s; [`VehicleParameters::speed_sigma_m_s`] if absent.
        sigma_m_s: Option<f64>,
    },
    /// Velocity in the world of a point on the camera.
    Velocity {
        /// m/s.
        velocity_m_s: DVec3,
        /// (m/s)².
        covariance: DMat3,
        /// The point, from the body's origin in the body, m.
        lever_m: DVec3,
    },
    /// Position in the world of a point on the camera, an antenna.
    Position {
        /// m.
        position_m: DVec3,
        /// m².
        covariance: DMat3,
        /// The point, from the body's origin in the body, m.
        lever_m: DVec3,
    },
    /// Position in the world of a point on the camera, and its orientation.
    Pose {
        /// m.
        position_m: DVec3,
        /// m².
        covariance: DMat3,
        /// The point, from the body's origin in the body, m.
        lever_m: DVec3,
        /// Body to world.
        orientation: Rotation<World, Body>,
        /// Of a small turn about the world's axes, rad².
        orientation_covariance: DMat3,
    },
}

impl Measurement {
    /// Which aid it is.
    pub const fn kind(&self) -> AidKind {
        match self {
            Self::Speed { .. } => AidKind::Speed,
            Self::Velocity { .. } => AidKind::Gradient,
            Self::Position { .. } => AidKind::PositionFix,
            Self::Pose { .. } => AidKind::PoseFix,
        }
    }

    /// Whether every number is one that a measurement can have.
    pub fn is_sound(&self) -> bool {
        let fix = |p: DVec3, c: DMat3, lever_m: DVec3| {
            p.is_finite() && lever_m.is_finite() && inverse_root(c).is_some()
        };
        match *self {
            Self::Speed { speed_m_s, sigma_m_s } => {
                let sigma = sigma_m_s.unwrap_or(1.0);
                speed_m_s.is_finite() && sigma.is_finite() && sigma > 0.0
            }
            Self::Velocity { velocity_m_s, covariance, lever_m } => {
                fix(velocity_m_s, covariance, lever_m)
            }
            Self::Position { position_m, covariance, lever_m } => {
                fix(position_m, covariance, lever_m)
            }
            Self::Pose { position_m, covariance, lever_m, orientation, orientation_covariance } => {
                let turned = orientation.quaternion();
                let unit = (turned.length_squared() - 1.0).abs() < 1e-6;
                fix(position_m, covariance, lever_m)
                    && unit
                    && inverse_root(orientation_covariance).is_some()
            }
        }
    }
}

/// A measurement by others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aid {
    /// Time of validity on the sensor's clock, up to two seconds ago.
    pub time: SensorTime,
    /// What it says.
    pub measurement: Measurement,
}
