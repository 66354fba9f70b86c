//! What a camera's errors have in common with those of another one, its anchor.
//!
//! A registration measures a camera B against another one, A. Given in the world by A's pose, it errs by
//! its own noise and by A's error at that instant, `a = (δθ_A, δp_A)`. B takes it over, and its error is
//!
//! ```text
//! δ_B = M a + own,        P_B = M P_a Mᵀ + P_own
//! ```
//!
//! with A's error and its own part independent. Whatever B's filter does to its error it does to `M`:
//! prediction maps it (`M ← F M`), an update with gain k and row h takes from it (`M ← M − k h M`). So
//! what is common is known at any time, and can be taken off before the next registration: B then
//! learns from it at the registration's own accuracy, and `P_B` stays honest in the world. This is the
//! cross-covariance of collaborative localisation (Roumeliotis and Bekey 2002), kept on the follower's
//! side alone as one factor (Luft et al. 2018), with the anchor's error as a consider state (Schmidt).

use glam::{DMat3, DVec3};

use crate::covariance::{
    ACCEL_BIAS, Block, Covariance, GYRO_BIAS, LEAKY_VELOCITY, ORIENTATION, POSITION, Row, STATES,
    VELOCITY,
};
use crate::drift::Drift;

#[cfg(test)]
mod tests;

/// One number for each of an anchor's errors: its orientation about the world's axes, its position.
pub(crate) type Part = [f64; 6];

/// How every error of the state hangs on six others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shares {
    rows: [Part; STATES],
}

/// A camera's tie to its anchor since the last fix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tie {
    /// Whom.
    pub(crate) anchor: u16,
    /// `M`.
    pub(crate) shares: Shares,
    /// `P_a`: of the anchor's orientation, rad², and of its position, m².
    pub(crate) covariance: [DMat3; 2],
    /// What the anchor had drifted by then.
    pub(crate) mark: Drift,
    /// Time since the last fix, s.
    pub(crate) age_s: f64,
}

/// Time after the last fix in which a camera is held to its anchor, s: registrations come about once a second.
/// Short goes astray where views overlap now and then, long keeps what an anchor did not know.
const HELD_S: f64 = 60.0;

impl Shares {
    /// Nothing in common.
    pub(crate) const NONE: Self = Self { rows: [[0.0; 6]; STATES] };

    /// `h M`.
    pub(crate) fn seen_by(&self, row: &Row) -> Part {
        let mut seen = [0.0; 6];
        for (weight, part) in row.iter().zip(&self.rows) {
            if *weight != 0.0 {
                (0..6).for_each(|k| seen[k] += weight * part[k]);
            }
        }
        seen
    }

    /// `M ← M − k s`: an update with a gain that takes `s` of the six for an error of its own.
    pub(crate) fn take(&mut self, gain: &Row, seen: &Part) {
        for (weight, part) in gain.iter().zip(&mut self.rows) {
            if *weight != 0.0 {
                (0..6).for_each(|k| part[k] -= weight * seen[k]);
            }
        }
    }

    /// The state's errors by one of the six.
    pub(crate) fn column(&self, k: usize, scale: f64) -> Row {
        core::array::from_fn(|i| self.rows[i][k] * scale)
    }

    /// How a block hangs on the anchor's orientation (0) or position (1).
    pub(crate) fn block(&self, block: Block, which: usize) -> DMat3 {
        let column = |c: usize| {
            let at = |r: usize| self.rows[block.0 + r][3 * which + c];
            DVec3::new(at(0), at(1), at(2))
        };
        DMat3::from_cols(column(0), column(1), column(2))
    }

    /// Part of an error of the anchor's heading that is one of the state's.
    pub(crate) fn of_heading(&self) -> f64 {
        self.rows[ORIENTATION.0 + 2][2]
    }

    /// The error model of a prediction: what [`crate::predict::follow`] does to the covariance.
    pub(crate) fn follow(&mut self, moved_s: f64, (by_tilt, turned): (DMat3, DMat3), kept: f64) {
        self.shear(POSITION, DMat3::from_diagonal(DVec3::splat(moved_s)), VELOCITY);
        for block in [VELOCITY, LEAKY_VELOCITY] {
            self.shear(block, by_tilt, ORIENTATION);
            self.shear(block, -turned, ACCEL_BIAS);
        }
        self.shear(ORIENTATION, -turned, GYRO_BIAS);
        (0..3).for_each(|k| self.scale(LEAKY_VELOCITY.0 + k, kept));
    }

    /// The error model `x_i += m x_j`.
    fn shear(&mut self, i: Block, m: DMat3, j: Block) {
        let source = [self.rows[j.0], self.rows[j.0 + 1], self.rows[j.0 + 2]];
        for r in 0..3 {
            let weights = m.row(r).to_array();
            for (weight, part) in weights.iter().zip(&source) {
                (0..6).for_each(|k| self.rows[i.0 + r][k] += weight * part[k]);
            }
        }
    }

    /// The error model `x ← s x` of one state.
    pub(crate) fn scale(&mut self, index: usize, s: f64) {
        self.rows[index] = self.rows[index].map(|x| x * s);
    }
}

impl Tie {
    /// Adds `M P_a Mᵀ` to a covariance, or takes it off.
    pub(crate) fn put_on(&self, covariance: &mut Covariance, sign: f64) {
        for (which, own) in self.covariance.iter().enumerate() {
            let root = root(*own);
            for c in 0..3 {
                let of = root.col(c);
                let column = core::array::from_fn(|i| {
                    let part = &self.shares.rows[i][3 * which..3 * which + 3];
                    part[0] * of.x + part[1] * of.y + part[2] * of.z
                });
                covariance.add_square(sign, &column);
            }
        }
    }

    /// What a block has of its own: `P − M P_a Mᵀ`.
    pub(crate) fn own(&self, covariance: &Covariance, block: Block) -> DMat3 {
        let mut own = covariance.block(block, block);
        for (which, of_anchor) in self.covariance.iter().enumerate() {
            let share = self.shares.block(block, which);
            own -= share * *of_anchor * share.transpose();
        }
        own
    }

    /// Whether the anchor's error is considered, not corrected (Schmidt's consider states): corrected by one
    /// camera alone, it would lead the two apart.
    pub(crate) fn holds(&self) -> bool {
        self.age_s < HELD_S
    }

    /// `P_own h`, given `P h`.
    pub(crate) fn without_anchor(&self, h: &Row, ph: &Row) -> Row {
        let seen = self.shares.seen_by(h);
        let [turned, placed] = [0, 1].map(|which| {
            let part = DVec3::from_slice(&seen[3 * which..3 * which + 3]);
            self.covariance[which] * part
        });
        let by_anchor = self.by([turned, placed]);
        core::array::from_fn(|i| ph[i] - by_anchor[i])
    }

    /// The state's errors by errors of the anchor's orientation and position.
    pub(crate) fn by(&self, [turned, shifted]: [DVec3; 2]) -> Row {
        let by = [turned.x, turned.y, turned.z, shifted.x, shifted.y, shifted.z];
        core::array::from_fn(|i| self.shares.rows[i].iter().zip(&by).map(|(a, b)| a * b).sum())
    }

    /// The state learns from a scalar measurement of its own.
    #[inline]
    pub(crate) fn learn(&mut self, row: &Row, gain: &Row) {
        let seen = self.shares.seen_by(row);
        self.shares.take(gain, &seen);
    }
}

/// `L` of a covariance `C = L Lᵀ`, lower; a direction without variance has none.
fn root(c: DMat3) -> DMat3 {
    let pivot = |x: f64| libm::sqrt(x.max(0.0));
    let over = |x: f64, pivot: f64| if pivot > 0.0 { x / pivot } else { 0.0 };
    let a = pivot(c.x_axis.x);
    let (b, d) = (over(c.x_axis.y, a), over(c.x_axis.z, a));
    let e = pivot(c.y_axis.y - b * b);
    let f = over(c.y_axis.z - b * d, e);
    let g = pivot(c.z_axis.z - d * d - f * f);
    DMat3::from_cols(DVec3::new(a, b, d), DVec3::new(0.0, e, f), DVec3::new(0.0, 0.0, g))
}
