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
//! the gain of the smallest error in the world, and need not be: for any gain K, with the tie's
//! `δ = M a + own` ([`crate::tie`]), and an anchor that has drifted by u since the last fix,
//!
//! ```text
//! M⁺ = (I − K H) M + K J                                                              = N + K J
//! P_own⁺ = (I − K H) P_own (I − K H)ᵀ + K R Kᵀ + N U Nᵀ,        P⁺ = P_own⁺ + M⁺ P_a M⁺ᵀ
//! ```
//!
//! The drift u is one of the anchor's error, which is taken over with it; between two fixes it looks like
//! noise, and the gain counts it as such.

use glam::{DMat3, DVec3};

use super::vector::inverse_root;
use crate::aiding::Anchor;
use crate::covariance::{Row, STATES};
use crate::drift::Drifted;
use crate::so3;
use crate::state::State;
use crate::tie::{Part, Shares, Tie};

/// Six numbers measured together, of independent errors and unit variance: position, then orientation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AnchoredPose {
    rows: [Row; 6],
    residual: [f64; 6],
    /// How each number hangs on the errors of the measured position, m, and orientation, rad.
    whitening: [Part; 6],
    /// `J`, on the anchor's orientation and position.
    by_anchor: [Part; 6],
    anchor: Anchor,
    /// `U`, and what the gain counts of it.
    drifted: Option<Drifted>,
    counted: Part,
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
    pub(crate) fn new(
        state: &State,
        seen: &Seen,
        covariances: [DMat3; 2],
        anchor: Anchor,
    ) -> Option<Self> {
        let tie = state.tie.as_ref().filter(|tie| tie.anchor == anchor.id);
        let drifted = tie.and_then(|tie| anchor.drift.since(&tie.mark));
        let counted = drifted.map_or([0.0; 6], |drifted| counted(&drifted, seen.arm_m));
        let mut pose = Self {
            rows: [[0.0; STATES]; 6],
            residual: [0.0; 6],
            whitening: [[0.0; 6]; 6],
            by_anchor: jacobian(seen.arm_m),
            anchor,
            drifted,
            counted,
        };
        for (which, covariance) in covariances.into_iter().enumerate() {
            let extra = DVec3::from_slice(&counted[3 * which..3 * which + 3]);
            let whiten = inverse_root(covariance + DMat3::from_diagonal(extra))?;
            let residual = (whiten * seen.residuals[which]).to_array();
            for k in 0..3 {
                let weights = whiten.row(k).to_array();
                let at = 3 * which + k;
                pose.rows[at] = combined(&weights, &seen.rows[which]);
                pose.residual[at] = residual[k];
                pose.whitening[at][3 * which..3 * which + 3].copy_from_slice(&weights);
            }
        }
        Some(pose)
    }

    /// Takes the pose over, and the anchor's error with it.
    pub(crate) fn apply(&self, state: &mut State) {
        let mut left_over = Shares::NONE;
        // The tie to another anchor, or to one that has begun anew, ends: all is the state's own.
        if let Some(tie) = state.tie.take().filter(|_| self.drifted.is_some()) {
            tie.put_on(&mut state.covariance, -1.0);
            left_over = tie.shares;
        }
        let gains = self.correct(state, &mut left_over);
        self.account(state, &gains, &left_over);
        let mut shares = left_over;
        shares.add(&gains, &self.by_anchor);
        let covariance = [self.anchor.orientation_covariance, self.anchor.position_covariance];
        let tie = Tie { anchor: self.anchor.id, shares, covariance, mark: self.anchor.drift };
        tie.put_on(&mut state.covariance, 1.0);
        state.tie = Some(tie);
    }

    /// Corrects by one number after the other; gives `K`, and lets `N` follow.
    fn correct(&self, state: &mut State, left_over: &mut Shares) -> Shares {
        let mut gains = Shares::NONE;
        let mut correction = [0.0; STATES];
        for (k, row) in self.rows.iter().enumerate() {
            let ph = state.covariance.times(row);
            let variance = super::dot(row, &ph) + 1.0;
            let gain = ph.map(|x| x / variance);
            let left = self.residual[k] - super::dot(row, &correction);
            state.covariance.deflate(&ph, variance);
            left_over.take(&gain, &left_over.seen_by(row));
            let seen = gains.seen_by(row);
            gains.take(&gain, &core::array::from_fn(|j| seen[j] - self.whitening[k][j]));
            for (sum, gain) in correction.iter_mut().zip(&gain) {
                *sum += gain * left;
            }
        }
        state.correct(&correction);
        gains
    }

    /// What the gain counted of the anchor's drift is no noise of the state's own; what it leaves of the
    /// error from before the drift is.
    fn account(&self, state: &mut State, gains: &Shares, left_over: &Shares) {
        let Some(drifted) = self.drifted else { return };
        let drifted = parts([drifted.orientation_rad2, drifted.position_m2]);
        for k in 0..6 {
            let counted = gains.column(k, libm::sqrt(self.counted[k]));
            state.covariance.add_square(-1.0, &counted);
            let left = left_over.column(k, libm::sqrt(drifted[k]));
            state.covariance.add_square(1.0, &left);
        }
    }
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

/// Variances of position and orientation that cover a drift of the anchor.
fn counted(drifted: &Drifted, arm_m: DVec3) -> Part {
    let turned = drifted.orientation_rad2.max_element() * arm_m.length_squared();
    parts([drifted.position_m2 + turned, drifted.orientation_rad2])
}

fn parts([first, second]: [DVec3; 2]) -> Part {
    let (a, b) = (first.to_array(), second.to_array());
    [a[0], a[1], a[2], b[0], b[1], b[2]]
}

fn combined(weights: &[f64; 3], rows: &[Row; 3]) -> Row {
    core::array::from_fn(|i| (0..3).map(|k| weights[k] * rows[k][i]).sum())
}
