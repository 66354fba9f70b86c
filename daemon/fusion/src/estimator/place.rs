//! A place of which nothing is known.
//!
//! The alignment finds the attitude in the world, not the place: each filter begins in an origin of its
//! own. Where the place is known from elsewhere (the camera is at the world's origin, stood where it
//! stands, was there before), [`Estimator::place`] says so; else the position is declared unknown, by a
//! covariance that any fix overrules.

use glam::{DMat3, DVec3};

use super::Estimator;

/// Standard deviation of a position of which nothing is known, m, per axis. Far beyond any place that a
/// camera goes to, and small enough that a fix of a centimetre is not lost to rounding.
pub const UNKNOWN_POSITION_SIGMA_M: f64 = 1e4;

/// A position whose standard deviation is above this, m, on any axis, is not known.
const KNOWN_BELOW_M: f64 = 0.3 * UNKNOWN_POSITION_SIGMA_M;

/// Whether a covariance of a position, m², is that of one of which something is known.
pub fn is_position_known(covariance: DMat3) -> bool {
    let diagonal =
        DVec3::new(covariance.x_axis.x, covariance.y_axis.y, covariance.z_axis.z).max_element();
    diagonal < KNOWN_BELOW_M * KNOWN_BELOW_M
}

impl Estimator {
    /// Declares that nothing is known of the position.
    pub fn forget_place(&mut self) {
        let variance = UNKNOWN_POSITION_SIGMA_M * UNKNOWN_POSITION_SIGMA_M;
        self.place(DVec3::ZERO, DMat3::from_diagonal(DVec3::splat(variance)));
    }
}
