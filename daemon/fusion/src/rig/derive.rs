//! Pose and motion of another point of the rig, out of those of the filter point.
//!
//! With `R` rig to world and `l` the point from the filter point, in the rig's axes:
//!
//! ```text
//! p' = p + R l          δp' = δp − [R l]× δθ
//! v' = v + R (ω × l)    δv' = δv − [R (ω × l)]× δθ
//! f' = f + α × l + ω × (ω × l)
//! ```

use glam::{DMat3, DVec3};

use super::virtual_imu::lever_arm;
use crate::aiding::Measurement;
use crate::covariance::{Block, Covariance, ORIENTATION, POSITION, VELOCITY};
use crate::estimator::Estimate;
use crate::frame::{Body, Rotation, Vehicle};
use crate::so3;

/// A point of the rig with axes of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// From the filter point, in the rig's axes, m.
    pub(crate) arm_m: DVec3,
    /// Its axes to the rig's.
    pub(crate) rotation: Rotation<Vehicle, Body>,
}

impl Point {
    /// A point that is placed on another one, m in that one's own axes.
    #[must_use]
    pub fn offset(self, by_m: DVec3) -> Self {
        Self { arm_m: self.arm_m + self.rotation.apply(by_m), ..self }
    }

    /// What others measured at this point, as the rig's filter takes it: a lever from its own origin, the
    /// orientation of its own axes.
    pub fn measured(&self, measurement: Measurement) -> Measurement {
        let lever = |own_m: DVec3| self.offset(own_m).arm_m;
        match measurement {
            Measurement::Speed { .. } => measurement,
            Measurement::Velocity { velocity_m_s, covariance, lever_m } => {
                Measurement::Velocity { velocity_m_s, covariance, lever_m: lever(lever_m) }
            }
            Measurement::Position { position_m, covariance, lever_m } => {
                Measurement::Position { position_m, covariance, lever_m: lever(lever_m) }
            }
            Measurement::Pose {
                position_m,
                covariance,
                lever_m,
                orientation,
                orientation_covariance,
            } => {
                let turn = orientation.quaternion() * self.rotation.quaternion().conjugate();
                Measurement::Pose {
                    position_m,
                    covariance,
                    lever_m: lever(lever_m),
                    orientation: Rotation::from_unit(turn),
                    orientation_covariance,
                }
            }
        }
    }
}

/// The estimate at a point, while the rig's angular acceleration is `swing`, rad/s².
pub(crate) fn at(point: &Point, of: &Estimate, covariance: &Covariance, swing: DVec3) -> Estimate {
    let turn = of.orientation.quaternion();
    let arm = turn * point.arm_m;
    let turning = turn * of.angular_rate.cross(point.arm_m);
    let to_own = point.rotation.quaternion().conjugate();
    let felt = of.specific_force + lever_arm(of.angular_rate, swing, point.arm_m);
    Estimate {
        orientation: Rotation::from_unit(so3::renormalise(turn * point.rotation.quaternion())),
        position: of.position + arm,
        velocity: of.velocity + turning,
        angular_rate: to_own * of.angular_rate,
        specific_force: to_own * felt,
        position_covariance: moved(covariance, POSITION, arm),
        velocity_covariance: moved(covariance, VELOCITY, turning),
        ..*of
    }
}

/// The covariance of `δx − [arm]× δθ`.
fn moved(p: &Covariance, block: Block, arm: DVec3) -> DMat3 {
    let by_turn = so3::skew(-arm);
    let cross = by_turn * p.block(ORIENTATION, block);
    let turned = by_turn * p.block(ORIENTATION, ORIENTATION) * by_turn.transpose();
    p.block(block, block) + turned + cross + cross.transpose()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Normal, attitudes, moved as moved_state, state_at, unit};

    /// A covariance with every correlation there is.
    fn full(random: &mut Normal) -> Covariance {
        let mut p = Covariance::ZERO;
        for block in [ORIENTATION, VELOCITY, POSITION] {
            p.add_variances(block, DVec3::splat(0.01));
        }
        let m = DMat3::from_cols(random.vector(1.0), random.vector(1.0), random.vector(1.0));
        p.shear(POSITION, m, ORIENTATION);
        p.shear(VELOCITY, m.transpose(), ORIENTATION);
        p
    }

    #[test]
    fn a_points_covariance_is_that_of_its_errors() {
        // Given states and points, when the errors are carried over by central differences, then so is the
        // covariance.
        let mut random = Normal::seeded(4);
        for orientation in attitudes() {
            let (state, p) = (state_at(orientation, &mut random), full(&mut random));
            let (arm, rate) = (random.vector(0.5), random.vector(1.0));
            let place = |s: &crate::State| s.position + s.orientation * arm;
            let speed = |s: &crate::State| s.velocity + s.orientation * rate.cross(arm);
            for (block, h) in [(POSITION, &place as &dyn Fn(&_) -> DVec3), (VELOCITY, &speed)] {
                let slope = |j: usize| {
                    let at = |d: f64| h(&moved_state(&state, &unit(j, d)));
                    (at(1e-6) - at(-1e-6)) / 2e-6
                };
                let jacobian =
                    |of: Block| DMat3::from_cols(slope(of.0), slope(of.0 + 1), slope(of.0 + 2));
                let (own, turn) = (jacobian(block), jacobian(ORIENTATION));
                let exact = own * p.block(block, block) * own.transpose()
                    + turn * p.block(ORIENTATION, ORIENTATION) * turn.transpose()
                    + turn * p.block(ORIENTATION, block) * own.transpose()
                    + own * p.block(block, ORIENTATION) * turn.transpose();
                let world_arm = if block == POSITION {
                    orientation * arm
                } else {
                    orientation * rate.cross(arm)
                };
                assert!(moved(&p, block, world_arm).abs_diff_eq(exact, 1e-8));
            }
        }
    }
}
