//! Correcting the clouds of cameras by laying them over what other cameras have seen.
//!
//! One camera is the anchor: its clouds go into the map as its poses place them. Every other camera's
//! clouds are registered now and then, on a thread of their own, against what the anchor, and cameras
//! that were accepted before, have seen lately. What is found moves all following clouds of that camera,
//! until the next registration. A camera's clouds are held back until the first one is accepted, or for
//! some seconds, so that the map does not begin with double walls.
//!
//! A registration always begins at the pose as it is published, with its covariance, never at an earlier
//! correction: a pose that meanwhile has been aided needs none, and is found to need none.

mod drift;
mod memory;
mod refiner;
mod report;
mod settings;
#[cfg(test)]
mod tests;
mod worker;

pub use refiner::{CloudFix, CloudRefiner, Placement, RefineError};
pub use report::{RefineReport, Refusals};
pub use settings::RefineSettings;
