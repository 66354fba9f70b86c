//! The one rigid motion that lays a whole cloud best on a surface.
//!
//! What is left after it is what a consumer sees that wants clouds to lie on each other and does not care where in
//! the world they are.

use glam::{DMat3, DQuat, DVec3};
use nalgebra::{Matrix6, Vector6};

/// Most steps of the search.
const STEPS: usize = 40;
/// A step below this (rad, m) changes nothing any more.
const DONE: f64 = 1e-7;
/// Distances from which the direction to the surface is told, by differences of this width, m.
const DIFFERENCE_M: f64 = 1e-3;
/// Damping where there is no other hold.
const DAMPING: f64 = 1e-9;

/// A rotation about a centre, then a shift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidMotion {
    rotation: DQuat,
    centre: DVec3,
    shift: DVec3,
}

impl RigidMotion {
    /// Where a point comes to, m.
    pub fn apply(&self, point: DVec3) -> DVec3 {
        self.rotation * (point - self.centre) + self.centre + self.shift
    }

    /// The turn, rad.
    pub fn angle_rad(&self) -> f64 {
        self.rotation.to_scaled_axis().length()
    }

    /// How far the centre of the points was moved, m.
    pub fn shift_m(&self) -> f64 {
        self.shift.length()
    }

    fn after(&self, step: &Vector6<f64>) -> Self {
        let turn = DQuat::from_scaled_axis(DVec3::new(step[0], step[1], step[2]));
        let shift = DVec3::new(step[3], step[4], step[5]);
        Self { rotation: (turn * self.rotation).normalize(), shift: self.shift + shift, ..*self }
    }
}

/// Finds the motion with the least sum of weighted squared distances (m, not negative) from the points to a
/// surface, near the identity: Gauss-Newton, each step halved until it gains.
///
/// `None` without points.
pub fn fit(points: &[(DVec3, f64)], distance_m: impl Fn(DVec3) -> f64) -> Option<RigidMotion> {
    let total: f64 = points.iter().map(|(_, weight)| weight).sum();
    let centre = points.iter().map(|(point, weight)| *point * *weight).sum::<DVec3>() / total;
    if !centre.is_finite() {
        return None;
    }
    let cost = |motion: &RigidMotion| {
        let each =
            |(point, weight): &(DVec3, f64)| weight * distance_m(motion.apply(*point)).powi(2);
        points.iter().map(each).sum::<f64>()
    };
    let mut motion = RigidMotion { rotation: DQuat::IDENTITY, centre, shift: DVec3::ZERO };
    let mut least = cost(&motion);
    for _ in 0..STEPS {
        let Some(step) = step(points, &motion, &distance_m) else { break };
        let halves = (0..8).map(|n| motion.after(&(step / f64::from(1 << n))));
        let better = halves.map(|m| (cost(&m), m)).find(|(cost, _)| *cost < least);
        let Some((cost, found)) = better else { break };
        (least, motion) = (cost, found);
        if step.amax() < DONE {
            break;
        }
    }
    Some(motion)
}

/// One step of Gauss-Newton: the turn (about the moved centre) and the shift.
fn step(
    points: &[(DVec3, f64)],
    motion: &RigidMotion,
    distance_m: &impl Fn(DVec3) -> f64,
) -> Option<Vector6<f64>> {
    let (mut normal, mut gradient) = (Matrix6::zeros(), Vector6::zeros());
    let pivot = motion.centre + motion.shift;
    for (point, weight) in points {
        let moved = motion.apply(*point);
        let away = distance_m(moved);
        // On the surface itself the direction away from it cannot be told, and nothing pulls.
        if away < 2.0 * DIFFERENCE_M {
            continue;
        }
        let slope = slope(moved, distance_m);
        let lever = (moved - pivot).cross(slope);
        let row = Vector6::new(lever.x, lever.y, lever.z, slope.x, slope.y, slope.z);
        normal += row * row.transpose() * *weight;
        gradient += row * (*weight * away);
    }
    normal += Matrix6::identity() * (DAMPING * normal.trace().max(f64::MIN_POSITIVE));
    normal.cholesky().map(|factor| -factor.solve(&gradient))
}

/// The direction in which the distance grows, by central differences.
fn slope(point: DVec3, distance_m: &impl Fn(DVec3) -> f64) -> DVec3 {
    let along = |axis: DVec3| {
        let step = axis * DIFFERENCE_M;
        (distance_m(point + step) - distance_m(point - step)) / (2.0 * DIFFERENCE_M)
    };
    let columns = DMat3::IDENTITY;
    DVec3::new(along(columns.x_axis), along(columns.y_axis), along(columns.z_axis))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distance to the inside of a box.
    fn to_walls(point: DVec3) -> f64 {
        (DVec3::new(3.0, 2.0, 1.0) - point.abs()).abs().min_element()
    }

    /// Points on the walls, turned and shifted.
    fn moved(turn: DQuat, shift: DVec3) -> Vec<(DVec3, f64)> {
        let on = |n: i32| {
            let (i, j) = (f64::from(n % 20) / 10.0 - 0.95, f64::from(n / 20 % 20) / 10.0 - 0.95);
            match n / 400 {
                0 => DVec3::new(3.0, 2.0 * i, j),
                1 => DVec3::new(-3.0, 2.0 * i, j),
                2 => DVec3::new(3.0 * i, 2.0, j),
                _ => DVec3::new(3.0 * i, 2.0 * j, -1.0),
            }
        };
        (0..1600).map(|n| (turn * on(n) + shift, f64::from(1 + n % 3))).collect()
    }

    #[test]
    fn a_moved_room_is_moved_back() {
        let turn = DQuat::from_scaled_axis(DVec3::new(0.01, -0.02, 0.04));
        let points = moved(turn, DVec3::new(0.05, -0.03, 0.02));
        let motion = fit(&points, to_walls).unwrap();
        let worst = points.iter().map(|(p, _)| to_walls(motion.apply(*p))).fold(0.0, f64::max);
        assert!(worst < 3e-3, "{worst}");
        assert!((motion.angle_rad() - turn.to_scaled_axis().length()).abs() < 2e-3);
    }

    #[test]
    fn a_room_that_fits_stays() {
        let motion = fit(&moved(DQuat::IDENTITY, DVec3::ZERO), to_walls).unwrap();
        assert!(motion.angle_rad() < 1e-9 && motion.shift_m() < 1e-9);
        assert!(fit(&[], to_walls).is_none());
    }
}
