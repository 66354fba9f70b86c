//! A rigid body that carries cameras.

use serde::{Deserialize, Serialize};

/// A rigid body that carries cameras: a vehicle, or a rig.
///
/// Its frame is x forward, y left, z up. [`super::Camera::body`] names the body that a camera sits
/// on, and [`super::Camera::mounting`] is the camera's pose in the body's frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RigidBody {
    /// Its name, unlike any other body's and any camera's.
    pub name: String,
    /// Whether it is a road vehicle: x is the direction in which it drives, the origin is in the
    /// middle of the axle that does not steer, where it moves neither sideways nor up and down.
    pub vehicle: bool,
    /// Where its antenna is, m: what position fixes without an orientation say the place of. The
    /// camera itself if absent.
    pub antenna_m: Option<[f64; 3]>,
    /// Whether the gradient of the magnetic field between its cameras tells the velocity, where it is
    /// strong enough; it needs three cameras that are not in a line.
    pub gradient: bool,
    /// Processor that the thread of the cameras' common lane stays on; any if absent.
    pub cpu: Option<u16>,
}

impl Default for RigidBody {
    /// No road vehicle; the gradient counts where it can.
    fn default() -> Self {
        Self { name: String::new(), vehicle: false, antenna_m: None, gradient: true, cpu: None }
    }
}
