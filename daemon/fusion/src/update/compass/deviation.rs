//! How the field of a place deviates from the earth's, and when it becomes another deviation.

use crate::covariance::DEVIATION;
use crate::parameters::CompassParameters;
use crate::state::State;

/// Reasons for the deviation to be another one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Moved {
    pub(super) way_m: f64,
    pub(super) turn_rad: f64,
    pub(super) time_s: f64,
}

impl Moved {
    /// Mean angular rate.
    pub(super) fn rate_rad_s(&self) -> f64 {
        if self.time_s > 0.0 { self.turn_rad / self.time_s } else { 0.0 }
    }
}

/// Lets the deviation become another one, as far as there is reason to: the camera turned, went
/// on, time passed, or the field changed.
///
/// A deviation that is renewed is drawn towards zero with the variance that the present field
/// deserves: what a usual room does, and what is off in the two directions that can be seen.
pub(super) fn renew(
    state: &mut State,
    moved: &Moved,
    change_ut: f64,
    mismatch_rad: f64,
    p: &CompassParameters,
) {
    let renewed = moved.way_m / p.deviation_way_m
        + moved.turn_rad / p.deviation_turn_rad
        + moved.time_s / p.deviation_time_s
        + change_ut / p.change_ut;
    let usual = p.deviation_sigma_rad * p.deviation_sigma_rad;
    let by_mismatch = p.mismatch_weight * mismatch_rad * mismatch_rad;
    let kept = libm::exp(-renewed);
    state.covariance.scale(DEVIATION, 1, kept);
    if let Some(tie) = &mut state.tie {
        tie.shares.scale(DEVIATION, kept);
    }
    state.covariance.add_variance(DEVIATION, (usual + by_mismatch) * (1.0 - kept * kept));
    state.deviation *= kept;
}
