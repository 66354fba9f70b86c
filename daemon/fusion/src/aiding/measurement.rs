//! What others measure, and whether it can be a measurement at all.

use glam::{DMat3, DVec3};

use crate::aid_status::AidKind;
use crate::drift::Drift;
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
        /// 1σ, m/s; [`crate::VehicleParameters::speed_sigma_m_s`] if absent.
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

/// A camera against which another one was measured, at that instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    /// Tells one from another.
    pub id: u16,
    /// Position in the world, m.
    pub position_m: DVec3,
    /// Covariance of its orientation about the world's axes, all of it, rad².
    pub orientation_covariance: DMat3,
    /// Covariance of its position, m².
    pub position_covariance: DMat3,
    /// What it has drifted so far.
    pub drift: Drift,
}

impl Anchor {
    /// Whether every number is one that an anchor can have. It may know all about itself.
    fn is_sound(&self) -> bool {
        let diagonal = |c: DMat3| DVec3::new(c.x_axis.x, c.y_axis.y, c.z_axis.z);
        let covariance = |c: DMat3| c.is_finite() && diagonal(c).min_element() >= 0.0;
        self.position_m.length() <= FARTHEST_M
            && covariance(self.orientation_covariance)
            && covariance(self.position_covariance)
    }
}

/// What lies further from the origin is no place in a world with one vertical, nor could a kept world hold it, m.
const FARTHEST_M: f64 = 1e7;
/// Nothing that carries a camera is faster, m/s.
const FASTEST_M_S: f64 = 1e3;
/// No point on what carries a camera is further from it, m.
const FARTHEST_LEVER_M: f64 = 1e3;

impl Measurement {
    /// Which aid it is.
    pub const fn kind(&self) -> AidKind {
        match self {
            Self::Speed { .. } => AidKind::Speed,
            Self::Velocity { .. } => AidKind::Velocity,
            Self::Position { .. } => AidKind::PositionFix,
            Self::Pose { .. } => AidKind::PoseFix,
        }
    }

    /// Whether every number is one that a measurement can have.
    pub fn is_sound(&self) -> bool {
        // A number that is none is within no bound.
        let vector = |v: DVec3, most: f64, c: DMat3, lever_m: DVec3| {
            let within = v.length() <= most && lever_m.length() <= FARTHEST_LEVER_M;
            within && inverse_root(c).is_some()
        };
        let fix = |p, c, lever_m| vector(p, FARTHEST_M, c, lever_m);
        match *self {
            Self::Speed { speed_m_s, sigma_m_s } => {
                let sigma = sigma_m_s.unwrap_or(1.0);
                speed_m_s.abs() <= FASTEST_M_S && sigma.is_finite() && sigma > 0.0
            }
            Self::Velocity { velocity_m_s, covariance, lever_m } => {
                vector(velocity_m_s, FASTEST_M_S, covariance, lever_m)
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
    /// The camera against which a pose was measured, and whose own gives it in the world: its covariances are
    /// then those of the measurement alone. Nothing else can have one.
    pub anchor: Option<Anchor>,
}

impl Aid {
    /// Whether every number is one that a measurement can have.
    pub(crate) fn is_sound(&self) -> bool {
        let is_pose = matches!(self.measurement, Measurement::Pose { .. });
        self.measurement.is_sound() && self.anchor.is_none_or(|anchor| is_pose && anchor.is_sound())
    }
}
