//! Two cameras of which one was measured against the other: how far their errors are apart since.
//!
//! With the follower's tie, `δ_B = M a + own` ([`crate::tie`]), and an anchor whose error has moved on by u
//! since the fix, both now, what a relative pose sees of them is
//!
//! ```text
//! e_θ = δθ_B − δθ_A = (M_θ − E) a + own_θ − E u,                            E = [1 0]
//! e_p = δp_B − δp_A + [d]× δθ_A = (M_p − J) a + own_p − J u,                J = [−[d]× 1]
//! ```
//!
//! with d from the anchor to the follower now. While neither corrects itself, `M` is what makes the first
//! terms zero, also where the follower has gone on meanwhile: an error of the heading turns its way.
//! A chain of ties adds up, and so do two cameras with one anchor: `e_B − e_A` of two that were measured
//! against the same camera, or against ones that lead there, is what they are apart.

use glam::{DMat3, DVec3};

use super::{Distance, Relative, Station, relative, symmetric};
use crate::covariance::{ORIENTATION, POSITION};
use crate::drift::{Drift, Drifted};
use crate::so3;
use crate::state::State;

#[cfg(test)]
mod tests;

/// What a camera says of its tie to its anchor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tied {
    /// Whom.
    pub anchor: u16,
    /// How its orientation's and its position's error hang on the anchor's orientation and position.
    pub shares: [[DMat3; 2]; 2],
    /// Covariance of what its orientation, rad², and its position, m², have of their own.
    pub own: [DMat3; 2],
    /// Covariance of the anchor's orientation, rad², and position, m², at the last fix.
    pub anchor_covariance: [DMat3; 2],
    /// What the anchor had drifted by then.
    pub mark: Drift,
}

/// How far a camera's error is from another one's, of which it knows: covariances in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Apart {
    /// Of `e_θ`, rad².
    pub orientation: DMat3,
    /// Of `e_p`, m².
    pub position: DMat3,
}

impl Tied {
    /// The tie of a state, if it has one.
    pub(crate) fn of(state: &State) -> Option<Self> {
        let tie = state.tie.as_ref()?;
        let blocks = [ORIENTATION, POSITION];
        Some(Self {
            anchor: tie.anchor,
            shares: blocks.map(|block| [0, 1].map(|which| tie.shares.block(block, which))),
            own: blocks.map(|block| tie.own(&state.covariance, block)),
            anchor_covariance: tie.covariance,
            mark: tie.mark,
        })
    }

    /// How far the camera is from its anchor, which has drifted since; `arm_m` from there to here.
    pub fn apart(&self, drifted: &Drifted, arm_m: DVec3) -> Apart {
        let by_turn = so3::skew(-arm_m);
        let as_one = [[DMat3::IDENTITY, DMat3::ZERO], [by_turn, DMat3::IDENTITY]];
        let moved = [drifted.orientation_rad2, drifted.position_m2].map(DMat3::from_diagonal);
        let [orientation, position] = [0, 1].map(|block| {
            let of_anchor = |which: usize| {
                let left = self.shares[block][which] - as_one[block][which];
                let by_drift = as_one[block][which];
                mapped(left, self.anchor_covariance[which]) + mapped(by_drift, moved[which])
            };
            symmetric(self.own[block] + of_anchor(0) + of_anchor(1))
        });
        Apart { orientation, position }
    }
}

impl Apart {
    /// A camera from itself.
    pub const NOTHING: Self = Self { orientation: DMat3::ZERO, position: DMat3::ZERO };

    /// A camera from another one, by way of the one that this is from: `next` is how far that is from the
    /// other one, and `arm_m` leads from it to the camera.
    #[must_use]
    pub fn then(&self, next: &Self, arm_m: DVec3) -> Self {
        Self {
            orientation: self.orientation + next.orientation,
            position: self.position + next.position + mapped(so3::skew(arm_m), next.orientation),
        }
    }
}

/// Camera b as camera a has it, where both are known against one camera; that may be either of them. No
/// less surely than by their places in the world.
pub fn relative_by(a: &Station, b: &Station, [by_a, by_b]: [&Apart; 2]) -> Relative {
    let in_world = relative(a, b);
    let to_body = a.orientation.matrix().transpose();
    let turned = |m: DMat3| symmetric(mapped(to_body, m));
    let orientation = turned(by_a.orientation + by_b.orientation);
    let by_turn = mapped(so3::skew(b.position - a.position), by_a.orientation);
    let position = turned(by_a.position + by_b.position + by_turn);
    let distance = in_world.distance.map(|distance| Distance {
        covariance: smaller(position, distance.covariance),
        ..distance
    });
    let orientation_covariance = smaller(orientation, in_world.orientation_covariance);
    Relative { orientation_covariance, distance, ..in_world }
}

/// Of two covariances of one error the one that says more. (Their errors are the same one: nothing is
/// gained by taking both.)
fn smaller(one: DMat3, other: DMat3) -> DMat3 {
    let trace = |m: DMat3| m.x_axis.x + m.y_axis.y + m.z_axis.z;
    if trace(one) < trace(other) { one } else { other }
}

fn mapped(by: DMat3, m: DMat3) -> DMat3 {
    by * m * by.transpose()
}
