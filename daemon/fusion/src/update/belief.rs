//! Whether a standstill can be believed.
//!
//! To inertial sensors a vehicle that glides at a constant speed, or speeds up evenly, is as quiet as one that
//! stands. What tells them apart is the velocity that the filter has followed so far: where zero is beyond
//! its gate, the quiet is a smooth road. A filter that is wrong about its velocity must find back, so after
//! long quiet it gives in, unless the velocity is measured by others.

use crate::covariance::VELOCITY;
use crate::state::State;
use glam::{DMat3, DVec3};

/// Square of the largest believable velocity of a standing camera by its covariance: five standard
/// deviations, because a filter's velocity after a minute of motion is surer than it should be.
const GATE: f64 = 25.0;
/// Quiet after which the filter gives in, s: smooth roads are shorter.
const PATIENCE_S: f64 = 60.0;

/// How long quiet has been taken for motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Belief {
    doubted_s: f64,
}

impl Belief {
    pub(crate) const NEW: Self = Self { doubted_s: 0.0 };

    /// Whether a quiet camera stands; `sigma_m_s` is the standstill's own.
    pub(crate) fn holds(
        &mut self,
        state: &mut State,
        sigma_m_s: f64,
        (span_s, velocity_is_measured): (f64, bool),
    ) -> bool {
        let own = DMat3::from_diagonal(DVec3::splat(sigma_m_s * sigma_m_s));
        let covariance = state.covariance.block(VELOCITY, VELOCITY) + own;
        let nis = state.velocity.dot(covariance.inverse() * state.velocity);
        if nis <= GATE {
            self.doubted_s = 0.0;
            return true;
        }
        self.doubted_s += span_s;
        if velocity_is_measured || self.doubted_s < PATIENCE_S {
            return false;
        }
        let off = DVec3::splat(state.velocity.length_squared());
        state.covariance.add_variances(VELOCITY, off);
        self.doubted_s = 0.0;
        true
    }
}
