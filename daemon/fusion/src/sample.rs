//! One calibrated sample, as the lane hands it to the grid.

use crate::frame::Body;
use crate::quantity::{Accel, Gyro, Mag};
use crate::time::SensorTime;

/// A sample in the body frame with the camera's calibration applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuSample {
    /// When it was taken.
    pub time: SensorTime,
    /// Angular rate.
    pub gyro: Gyro<Body>,
    /// Specific force.
    pub accel: Accel<Body>,
    /// Magnetic field, where the sample brings a new reading.
    pub mag: Option<Mag<Body>>,
    /// At least one axis is at the end of its range.
    pub saturated: bool,
}
