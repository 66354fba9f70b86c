//! A pose that was measured against another camera's, the anchor's, and is given in the world by it.
//!
//! With `z` from the anchor's pose as published, errors about and along the world's axes, and `d` from the
//! anchor to the measured point, the pose errs by its own noise ε and by the anchor's error a:
//!
//! ```text
//! Log(R_true R_zᵀ) = ε_θ + a_θ        p_true − z = ε_p + a_p − [d]× a_θ        (= ε + J a)
//! ```
//!
//! so the residuals of [`super::fix`] are `H δ − J a − ε`. The gain counts ε alone: the pose is taken over as
//! well as it was measured, and the two cameras fit each other, wherever in the world both are. It is not
//! the gain of the smallest error in the world, and need not be. With the tie's `δ = M a + own`
//! ([`crate::tie`]) and an anchor that has drifted by u since the last fix, which is the follower's own error
//! against the anchor's present one,
//!
//! ```text
//! P_own ← P_own + M U Mᵀ             K = P_own Hᵀ (H P_own Hᵀ + R)⁻¹
//! P_own⁺ = P_own − K H P_own         M⁺ = M − K (H M − J)         P⁺ = P_own⁺ + M⁺ P_a M⁺ᵀ
//! ```
//!
//! Without a tie `M` is zero, and all is the camera's own.

use glam::{DMat3, DVec3};

use super::vector::inverse_root;
use crate::aiding::Anchor;
use crate::covariance::{Row, STATES};
use crate::so3;
use crate::state::State;
use crate::tie::{Part, Shares, Tie};

/// Six numbers measured together, of independent errors and unit variance: position, then orientation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AnchoredPose {
    rows: [Row; 6],
    residual: [f64; 6],
    /// `J`, on the anchor's orientation and position.
    by_anchor: [Part; 6],
    anchor: Anchor,
}

/// Rows of both Jacobians and both residuals of a pose, as [`super::fix`] has them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    pub(crate) rows: [[Row; 3]; 2],
    pub(crate) residuals: [DVec3; 2],
    /// From the anchor to the measured point, m in the world.
    pub(crate) arm_m: DVec3,
}

/// The covariance that the anchor's error gives a measured position and orientation.
pub(crate) fn by_anchor(anchor: &Anchor, arm_m: DVec3) -> [DMat3; 2] {
    let turn = so3::skew(-arm_m);
    let turned = turn * anchor.orientation_covariance * turn.transpose();
    [anchor.position_covariance + turned, anchor.orientation_covariance]
}

impl AnchoredPose {
    /// A pose with its own covariances of position and orientation; `None` if one is none.
    pub(crate) fn new(seen: &Seen, covariances: [DMat3; 2], anchor: Anchor) -> Option<Self> {
        let mut pose =
            Self { rows: [[0.0; STATES]; 6], residual: [0.0; 6], by_anchor: [[0.0; 6]; 6], anchor };
        let by_anchor = jacobian(seen.arm_m);
        for (which, covariance) in covariances.into_iter().enumerate() {
            let whiten = inverse_root(covariance)?;
            let residual = (whiten * seen.residuals[which]).to_array();
            let by_anchor = &by_anchor[3 * which..3 * which + 3];
            for (k, residual) in residual.into_iter().enumerate() {
                let weights = whiten.row(k).to_array();
                let at = 3 * which + k;
                pose.rows[at] = combined(&weights, &seen.rows[which]);
                pose.by_anchor[at] = combined(&weights, by_anchor);
                pose.residual[at] = residual;
            }
        }
        Some(pose)
    }

    /// Takes the pose over, and the anchor's error with it.
    pub(crate) fn apply(&self, state: &mut State) {
        let mut shares = self.taken_off(state);
        self.correct(state, &mut shares);
        let (anchor, mark) = (self.anchor.id, self.anchor.drift);
        let covariance = [self.anchor.orientation_covariance, self.anchor.position_covariance];
        let tie = Tie { anchor, shares, covariance, mark, age_s: 0.0 };
        tie.put_on(&mut state.covariance, 1.0);
        state.tie = Some(tie);
    }

    /// Leaves the state with what is its own against the anchor's present error; gives `M`. The tie to
    /// another anchor, or to one that has begun anew, ends: all is the state's own.
    fn taken_off(&self, state: &mut State) -> Shares {
        let tie = state.tie.take().filter(|tie| tie.anchor == self.anchor.id);
        let drifted = tie.as_ref().and_then(|tie| self.anchor.drift.since(&tie.mark));
        let Some((tie, drifted)) = tie.zip(drifted) else { return Shares::NONE };
        tie.put_on(&mut state.covariance, -1.0);
        let moved = [drifted.orientation_rad2.to_array(), drifted.position_m2.to_array()];
        for (k, variance) in moved.as_flattened().iter().enumerate() {
            state.covariance.add_square(1.0, &tie.shares.column(k, libm::sqrt(*variance)));
        }
        tie.shares
    }

    /// Corrects by one number after the other, and lets `M` follow.
    fn correct(&self, state: &mut State, shares: &mut Shares) {
        let mut correction = [0.0; STATES];
        for (k, row) in self.rows.iter().enumerate() {
            let ph = state.covariance.times(row);
            let variance = super::dot(row, &ph) + 1.0;
            let gain = ph.map(|x| x / variance);
            let left = self.residual[k] - super::dot(row, &correction);
            state.covariance.deflate(&ph, variance);
            let seen = shares.seen_by(row);
            shares.take(&gain, &core::array::from_fn(|j| seen[j] - self.by_anchor[k][j]));
            for (sum, gain) in correction.iter_mut().zip(&gain) {
                *sum += gain * left;
            }
        }
        state.correct(&correction);
    }
}

/// Corrections of the anchor beyond which its follower is left alone: no linear map reaches that far.
const FARTHEST_TURN_RAD: f64 = 0.1;

/// Lets a state go along with the corrections that its anchor has made since the last time: both stay as
/// they are to each other, and the error in common is the anchor's present one.
pub(crate) fn follow(state: &mut State, anchor: &Anchor) {
    let Some(mut tie) = state.tie.take_if(|tie| tie.anchor == anchor.id) else { return };
    // One that has begun anew is another one, and what was common is now the state's own.
    if tie.mark.began != anchor.drift.began {
        return;
    }
    let corrections = anchor.drift.corrections_since(&tie.mark);
    if corrections[0].length_squared() > FARTHEST_TURN_RAD * FARTHEST_TURN_RAD {
        return;
    }
    state.correct(&tie.by(corrections));
    tie.put_on(&mut state.covariance, -1.0);
    tie.mark = tie.mark.corrected_as(&anchor.drift);
    tie.covariance = [anchor.orientation_covariance, anchor.position_covariance];
    tie.put_on(&mut state.covariance, 1.0);
    state.tie = Some(tie);
}

/// How position and orientation hang on the anchor's orientation and position.
fn jacobian(arm_m: DVec3) -> [Part; 6] {
    let by_turn = so3::skew(-arm_m);
    core::array::from_fn(|at| {
        let mut part = [0.0; 6];
        if at < 3 {
            part[..3].copy_from_slice(&by_turn.row(at).to_array());
            part[3 + at] = 1.0;
        } else {
            part[at - 3] = 1.0;
        }
        part
    })
}

fn combined<const N: usize>(weights: &[f64; 3], rows: &[[f64; N]]) -> [f64; N] {
    core::array::from_fn(|i| weights.iter().zip(rows).map(|(weight, row)| weight * row[i]).sum())
}
