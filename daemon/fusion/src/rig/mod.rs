//! A rigid rig of several cameras: one virtual IMU, one magnetometer array, one pose.
//!
//! ```text
//! members' steps ─> voting ─> virtual IMU ─> Estimator ─> pose of the rig, of each member
//!                      └───── magnetometers ─> gradient filter ─> velocity ──┘
//! ```

mod array;
#[cfg(feature = "blocks")]
mod blocks;
mod derive;
mod estimator;
mod geometry;
mod gradient;
mod harmonic;
mod magnetism;
mod symmetric;
mod virtual_imu;
mod voting;

pub(crate) use symmetric::eigen;

pub use array::FieldFit;
#[cfg(feature = "blocks")]
pub use blocks::RigBlocks;
pub use derive::Point;
pub use estimator::{MemberStatus, RigEstimator, RigParameters, RigReport};
pub use geometry::{Geometry, GeometryError, MAX_MEMBERS, Mounting};
pub use gradient::{GradientParameters, GradientReport, GradientVerdict};
pub use magnetism::MagnetismParameters;
pub use voting::{Exclusion, VotingParameters};
