//! A rigid rig of several cameras: one virtual IMU, one magnetometer array, one pose.
//!
//! ```text
//! members' steps ─> voting ─> virtual IMU ─> Estimator ─> pose of the rig, of each member
//!                      └───── magnetometers ─> gradient filter ─> velocity ──┘
//! ```

mod estimator;
mod geometry;
mod gradient;
mod harmonic;
mod symmetric;
mod virtual_imu;

pub(crate) use symmetric::eigen;

pub use estimator::{RigEstimator, RigParameters, RigReport};
pub use geometry::{Geometry, GeometryError, MAX_MEMBERS, Mounting};
pub use gradient::{GradientParameters, GradientReport, GradientVerdict};
