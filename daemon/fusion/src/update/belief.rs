//! Whether a standstill can be believed.
//!
//! To inertial sensors a vehicle that glides at a constant speed, or speeds up evenly, is nearly as quiet
//! as one that stands. Two things tell them apart: the velocity that the filter has followed so far, and
//! how quiet the sensors were when the camera stood for certain. They are weighed as odds:
//!
//! ```text
//! 2 ln N(v̂; 0, P) / (density of the speeds that vehicles drive at)
//! ```
//!
//! in the horizontal plane, so that a surely known velocity decides and an unsure one decides little.
//! A filter that is wrong about its velocity must find back, so lasting quiet weighs too, unless the
//! velocity is measured by others.

use glam::{DMat2, DVec2};

use crate::covariance::VELOCITY;
use crate::rest::WindowStatistics;
use crate::state::State;

/// `20² m²/s² / 2`: vehicles drive up to 20 m/s, in any direction.
const PLANE_M2_S2: f64 = 200.0;
/// Weight of the velocity that needs no further witness: it is e⁵ times as likely of a standing camera.
const CERTAIN: f64 = 10.0;
/// Weight that a second of quiet adds: standstills last longer than smooth roads.
const PER_SECOND: f64 = 1.0;
/// Quiet after which the filter gives in whatever it believes, s.
const PATIENCE_S: f64 = 60.0;
/// How much less quiet than at a certain standstill a camera may be that stands.
const AS_QUIET: f64 = 1.4;
/// Share by which a standstill's quiet counts for what was learnt before.
const LEARNING: f64 = 0.05;

/// Scatter of rate, rad/s, and force, m/s², within a window.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Scatter {
    rate: f64,
    force: f64,
}

/// What is known of standstills.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Belief {
    doubted_s: f64,
    usual: Option<Scatter>,
}

impl Belief {
    pub(crate) const NEW: Self = Self { doubted_s: 0.0, usual: None };

    /// Whether a camera stands whose sensors were quiet over a window; `sigma_m_s` is the standstill's own.
    pub(crate) fn holds(
        &mut self,
        state: &mut State,
        window: &WindowStatistics,
        sigma_m_s: f64,
        (span_s, velocity_is_measured): (f64, bool),
    ) -> bool {
        let weight = weight(state, sigma_m_s);
        let patience = if velocity_is_measured { 0.0 } else { self.doubted_s };
        let scatter = Scatter { rate: window.rate_deviation, force: window.force_deviation };
        if weight > CERTAIN {
            self.learn(scatter);
        } else if !(self.is_usual(scatter) && weight + PER_SECOND * patience > 0.0) {
            self.doubted_s += span_s;
            if patience < PATIENCE_S {
                return false;
            }
            let off = state.velocity.length_squared();
            state.covariance.add_variances(VELOCITY, glam::DVec3::splat(off));
        }
        self.doubted_s = 0.0;
        true
    }

    /// The camera moves for all to see.
    pub(crate) const fn end_doubt(&mut self) {
        self.doubted_s = 0.0;
    }

    fn is_usual(&self, now: Scatter) -> bool {
        self.usual.is_none_or(|usual| {
            now.rate < AS_QUIET * usual.rate && now.force < AS_QUIET * usual.force
        })
    }

    fn learn(&mut self, now: Scatter) {
        let usual = self.usual.get_or_insert(now);
        usual.rate += LEARNING * (now.rate - usual.rate);
        usual.force += LEARNING * (now.force - usual.force);
    }
}

/// Twice the logarithm of how much likelier the velocity is of a standing camera than of a driving one.
fn weight(state: &State, sigma_m_s: f64) -> f64 {
    let block = state.covariance.block(VELOCITY, VELOCITY);
    let own = sigma_m_s * sigma_m_s;
    let covariance = DMat2::from_cols(
        DVec2::new(block.x_axis.x + own, block.x_axis.y),
        DVec2::new(block.y_axis.x, block.y_axis.y + own),
    );
    let velocity = state.velocity.truncate();
    let nis = velocity.dot(covariance.inverse() * velocity);
    // Of an unbelievable covariance nothing is said.
    let spread = libm::sqrt(covariance.determinant().max(f64::MIN_POSITIVE));
    2.0 * libm::log(PLANE_M2_S2 / spread) - nis
}
