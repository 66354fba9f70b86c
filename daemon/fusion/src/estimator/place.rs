//! Putting the camera at a place of the world.
//!
//! The alignment finds the attitude in the world, not the place: each filter begins in the origin of
//! its own. Where the place is known from elsewhere (the camera is at the world's origin, stood where
//! it stands, was there before), the position is set, with what is not known of it.

use glam::{DMat3, DVec3};

use super::Estimator;
use crate::covariance::POSITION;
use crate::predict::follow;

/// Standard deviation of a position of which nothing is known, m, per axis. Far beyond any place that a
/// camera goes to, and small enough that a fix of a centimetre is not lost to rounding.
pub const UNKNOWN_POSITION_SIGMA_M: f64 = 1e5;

/// A position whose standard deviation is above this, m, on any axis, is not known.
const KNOWN_BELOW_M: f64 = 0.3 * UNKNOWN_POSITION_SIGMA_M;

/// Whether a covariance of a position, m², is that of one of which something is known.
pub fn is_position_known(covariance: DMat3) -> bool {
    let diagonal =
        DVec3::new(covariance.x_axis.x, covariance.y_axis.y, covariance.z_axis.z).max_element();
    diagonal < KNOWN_BELOW_M * KNOWN_BELOW_M
}

impl Estimator {
    /// Puts the body origin at a position in the world, m, with its covariance, m², independent of
    /// everything else; nothing before the alignment.
    pub fn place(&mut self, position: DVec3, covariance: DMat3) {
        let Some(state) = &mut self.state else { return };
        // What the covariance lags behind belongs to the old position.
        follow(state, &mut self.pending, &self.noise);
        state.position = position;
        state.covariance.set_independent(POSITION, covariance);
    }

    /// Declares that nothing is known of the position.
    pub fn forget_place(&mut self) {
        let variance = UNKNOWN_POSITION_SIGMA_M * UNKNOWN_POSITION_SIGMA_M;
        self.place(DVec3::ZERO, DMat3::from_diagonal(DVec3::splat(variance)));
    }
}
