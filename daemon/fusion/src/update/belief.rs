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
//!
//! Once a standstill is believed, the velocity is zero because it was said so, and witnesses nothing. A
//! gentle start shows in the force: it leaves its mean. So does the end of a gentle braking, and quiet
//! counts as lasting only from there on.

use glam::{DMat2, DVec2, DVec3};

use crate::covariance::VELOCITY;
use crate::rest::WindowStatistics;
use crate::state::State;

/// `20² m²/s² / 2`: vehicles drive up to 20 m/s, in any direction.
const PLANE_M2_S2: f64 = 200.0;
/// Weight of the velocity that needs no further witness: known to a quarter of a metre per second, it is e⁸
/// times as likely of a standing camera.
const CERTAIN: f64 = 16.0;
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

/// Change of the mean force that ends a standstill, m/s², beside what the scatter explains: a start by that
/// much is noticed at two centimetres per second.
const START_M_S2: f64 = 0.02;
/// Part of the scatter by which a window's mean may wander.
const WANDER: f64 = 0.3;
/// Share by which a window's mean force counts for the standstill's.
const FOLLOWING: f64 = 0.1;
/// Time for a start to show in the velocity before the next standstill is believed, s.
const SETTLE_S: f64 = 1.0;

/// Time in which the force must not have changed before a standstill is believed, s: a braking that ends
/// gently still changes it.
const STEADY_S: f64 = 0.3;

/// What is known of standstills.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Belief {
    doubted_s: f64,
    usual: Option<Scatter>,
    /// Mean force of the present quiet, m/s² in the body.
    steady: Option<DVec3>,
    steady_s: f64,
    /// The present quiet is believed to be a standstill.
    believed: bool,
    /// Time since a standstill was seen to end, s.
    since_start_s: f64,
}

impl Belief {
    pub(crate) const NEW: Self = Self {
        doubted_s: 0.0,
        usual: None,
        steady: None,
        steady_s: STEADY_S,
        believed: false,
        since_start_s: f64::INFINITY,
    };

    /// Whether a camera stands whose sensors were quiet over a window; `sigma_m_s` is the standstill's own.
    pub(crate) fn holds(
        &mut self,
        state: &mut State,
        window: &WindowStatistics,
        sigma_m_s: f64,
        (span_s, velocity_is_measured): (f64, bool),
    ) -> bool {
        self.since_start_s += span_s;
        let scatter = Scatter { rate: window.rate_deviation, force: window.force_deviation };
        if self.changes(window.force, scatter) {
            if core::mem::take(&mut self.believed) {
                self.since_start_s = 0.0;
            }
            self.steady = None;
            self.doubted_s = 0.0;
            self.steady_s = 0.0;
        }
        let steady = self.steady.get_or_insert(window.force);
        *steady += FOLLOWING * (window.force - *steady);
        self.steady_s += span_s;
        if self.since_start_s < SETTLE_S || (!self.believed && self.steady_s < STEADY_S) {
            return false;
        }
        let patience = if velocity_is_measured { 0.0 } else { self.doubted_s };
        let weight = weight(state, sigma_m_s) + PER_SECOND * patience;
        if weight > CERTAIN {
            self.learn(scatter);
        } else if !(self.is_usual(scatter) && weight > 0.0) {
            self.doubted_s += span_s;
            if patience < PATIENCE_S {
                return false;
            }
            let off = state.velocity.length_squared();
            state.covariance.add_variances(VELOCITY, DVec3::splat(off));
        }
        self.doubted_s = 0.0;
        self.believed = true;
        true
    }

    /// Whether quiet ends: the force leaves its mean, or scatters more than at a standstill.
    fn changes(&self, force: DVec3, now: Scatter) -> bool {
        let Some((steady, usual)) = self.steady.zip(self.usual) else { return false };
        let off = (force - steady).abs().max_element();
        off > START_M_S2 + WANDER * usual.force || (self.believed && !self.is_usual(now))
    }

    /// The camera moves for all to see.
    pub(crate) const fn end_quiet(&mut self) {
        self.doubted_s = 0.0;
        self.steady = None;
        self.steady_s = 0.0;
        self.believed = false;
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
