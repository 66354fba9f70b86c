//! Which movements the geometry does not tell.

use std::fmt;

use glam::DVec3;
use nalgebra::{Matrix6, SymmetricEigen, Vector6};

use super::matches::Match;
use super::prior::{halves, matrix3};
use crate::covariance::cross_matrix;

/// A movement of the cloud as a whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// Its turn about the middle of the points, a vector about the world's axes, times their distance from it.
    pub turn: DVec3,
    /// Its shift in the world; together with the turn it has length 1.
    pub shift: DVec3,
}

impl fmt::Display for Direction {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        const SMALL: f64 = 0.5;
        let (turn, shift) = (self.turn.length(), self.shift.length());
        let turning = turn > SMALL;
        if turning {
            write!(out, "a turn about {}", axis(self.turn))?;
        }
        if turning && shift > SMALL {
            write!(out, " together with ")?;
        }
        if shift > SMALL || !turning {
            write!(out, "a shift along {}", axis(self.shift))?;
        }
        Ok(())
    }
}

/// The world's axis if it is one within some degrees.
fn axis(v: DVec3) -> String {
    const NAMED: f64 = 0.97;
    let unit = v.normalize_or_zero();
    let names = [(DVec3::X, "east"), (DVec3::Y, "north"), (DVec3::Z, "up")];
    let named = names.iter().find(|(axis, _)| axis.dot(unit).abs() > NAMED);
    match named {
        Some((_, name)) => (*name).to_owned(),
        None => format!("[{:.2} {:.2} {:.2}] (east north up)", unit.x, unit.y, unit.z),
    }
}

/// Which movements the geometry tells.
///
/// Movements are taken about the middle of the points, and turns measured by how far they move them, so
/// that turns and shifts compare and do not depend on where the camera stands. In those terms an
/// eigenvalue of the mean of `j jᵀ` over unit normals is the share of points that face the movement
/// (Zhang, Kaess, Singh 2016, "On degeneracy of optimization-based state estimation problems", whose
/// solution remapping this is).
#[derive(Clone, Debug)]
pub(super) struct Degeneracy {
    /// Step of the correction for a movement about the middle.
    to_correction: Matrix6<f64>,
    /// Projects a step of the correction on the movements seen.
    seen: Matrix6<f64>,
    unseen: Vec<Direction>,
}

/// Smallest share of points that must face a movement.
const SMALLEST_SHARE: f64 = 0.01;
/// Normals that are wrong by chance face every movement a little; this many times that must be surpassed.
const ABOVE_CHANCE: f64 = 4.0;

impl Degeneracy {
    /// `weights`: what each match counts; `tilt_variance`: of a match's normal, rad².
    pub(super) fn of(
        matches: &[Match],
        weights: &[f64],
        tilt_variance: impl Fn(&Match) -> f64,
    ) -> Self {
        let (middle, radius) = extent(matches, weights);
        let to_correction = about_body(middle, radius);
        let (mut mean, mut chance, mut total) = (Matrix6::zeros(), 0.0, f64::MIN_POSITIVE);
        for (of, weight) in matches.iter().zip(weights) {
            let row = to_correction.tr_mul(&(of.jacobian * of.sigma_m));
            mean.syger(*weight, &row, &row, 1.0);
            chance += weight * tilt_variance(of);
            total += weight;
        }
        mean.fill_upper_triangle_with_lower_triangle();
        let least = SMALLEST_SHARE + ABOVE_CHANCE * chance / total;
        let (seen, unseen) = split(mean / total, least);
        let from_correction = about_body(-middle / radius, radius.recip());
        Self { to_correction, seen: to_correction * seen * from_correction, unseen }
    }

    /// Leaves of a normal matrix and a gradient what the geometry tells; the rest is the prior's.
    pub(super) fn remap(
        &self,
        information: &Matrix6<f64>,
        gradient: &Vector6<f64>,
    ) -> (Matrix6<f64>, Vector6<f64>) {
        if self.unseen.is_empty() {
            return (*information, *gradient);
        }
        let kept = self.seen.tr_mul(&(information * self.seen));
        (kept, self.seen.tr_mul(gradient))
    }

    /// Covariance of a correction whose every movement is uncertain by `sigma_m` at the points.
    pub(super) fn uncertain(&self, sigma_m: f64) -> Matrix6<f64> {
        self.to_correction * self.to_correction.transpose() * (sigma_m * sigma_m)
    }

    /// Movements that the geometry leaves open.
    pub(super) fn unseen(&self) -> &[Direction] {
        &self.unseen
    }
}

/// The projection on the eigenvectors whose eigenvalue is large enough, and the others.
fn split(mean: Matrix6<f64>, least: f64) -> (Matrix6<f64>, Vec<Direction>) {
    let eigen = SymmetricEigen::new(mean);
    let (mut seen, mut unseen) = (Matrix6::zeros(), Vec::new());
    for (share, movement) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        if *share >= least {
            seen += movement * movement.transpose();
        } else {
            let (turn, shift) = halves(&movement.into_owned());
            unseen.push(Direction { turn, shift });
        }
    }
    (seen, unseen)
}

/// Middle of the points, from the body, and the root mean square of their distance to it, m.
fn extent(matches: &[Match], weights: &[f64]) -> (DVec3, f64) {
    let pairs = || matches.iter().zip(weights);
    let total: f64 = weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let middle = pairs().map(|(of, weight)| of.arm * *weight).sum::<DVec3>() / total;
    let square: f64 = pairs().map(|(of, weight)| weight * of.arm.distance_squared(middle)).sum();
    (middle, (square / total).sqrt().max(SMALLEST_RADIUS_M))
}

/// Smallest extent of a cloud that is scaled by, m.
const SMALLEST_RADIUS_M: f64 = 0.01;

/// Step of the correction, about the body, for a movement about `middle` with turns scaled by `radius`:
/// the body moves with the shift, and against the turn of the middle.
fn about_body(middle: DVec3, radius: f64) -> Matrix6<f64> {
    let mut step = Matrix6::identity();
    let cross = matrix3(cross_matrix(middle)) / radius;
    step.fixed_view_mut::<3, 3>(0, 0).fill_diagonal(radius.recip());
    step.fixed_view_mut::<3, 3>(3, 0).copy_from(&cross);
    step
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn about_the_middle_and_back_is_nothing() {
        let (middle, radius) = (DVec3::new(1.0, -2.0, 3.0), 2.5);
        let there = about_body(middle, radius);
        let back = about_body(-middle / radius, radius.recip());
        assert!((there * back - Matrix6::identity()).norm() < 1e-12);
        // A pure turn about the middle leaves the middle where it is.
        let (turn, shift) = halves(&(there * Vector6::z()));
        assert!((turn.cross(middle) + shift).length() < 1e-12);
    }

    #[test]
    fn directions_are_said_in_words() {
        let slide = Direction { turn: DVec3::X * 0.1, shift: DVec3::Y * -0.99 };
        assert_eq!(slide.to_string(), "a shift along north");
        let heading = Direction { turn: DVec3::Z, shift: DVec3::ZERO };
        assert_eq!(heading.to_string(), "a turn about up");
        let both = Direction { turn: DVec3::Z * 0.7, shift: DVec3::new(0.5, 0.5, 0.0) };
        assert_eq!(
            both.to_string(),
            "a turn about up together with a shift along [0.71 0.71 0.00] (east north up)"
        );
    }
}
