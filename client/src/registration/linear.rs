//! One linearisation: what geometry and prior say about the next step.

use nalgebra::{Matrix6, Vector6};

use super::correction::Correction;
use super::degeneracy::Degeneracy;
use super::independence::Independence;
use super::matches::Match;
use super::robust::{Tukey, after};
use super::surface::SurfaceMap;

/// Normal matrix and gradient of the geometry at a correction, in true units of information: weighted,
/// scaled by the residuals' variance, and counted by independent points.
#[derive(Clone, Debug)]
pub(super) struct Geometry {
    pub(super) information: Matrix6<f64>,
    pub(super) gradient: Vector6<f64>,
    pub(super) degeneracy: Degeneracy,
    pub(super) independent_points: f64,
    pub(super) patches: usize,
    pub(super) weights: Vec<f64>,
}

/// The prior at a correction: `(J δ + x)ᵀ P⁻¹ (J δ + x)`.
#[derive(Clone, Debug)]
pub(super) struct PriorTerm {
    pub(super) information: Matrix6<f64>,
    pub(super) gradient: Vector6<f64>,
}

impl PriorTerm {
    pub(super) fn at(correction: &Correction, inverse_covariance: &Matrix6<f64>) -> Self {
        let jacobian = correction.vector_jacobian();
        let weighted = jacobian.transpose() * inverse_covariance;
        Self { information: weighted * jacobian, gradient: weighted * correction.vector() }
    }
}

impl Geometry {
    /// Evaluates matches twice: first plainly; then with the spread and the correlation of what the
    /// first step would leave, so that a misalignment is not taken for noise.
    pub(super) fn of(
        matches: &[Match],
        target: &SurfaceMap,
        prior: &PriorTerm,
        smallest_scale: f64,
    ) -> Self {
        let tukey = Tukey::of(matches.iter().map(|m| m.residual), smallest_scale);
        let weights: Vec<f64> = matches.iter().map(|m| tukey.weight(m.residual)).collect();
        let (information, gradient) = sums(matches, &weights);
        let first = step(&(information + prior.information), &(gradient + prior.gradient));

        let left = after(matches, &first.unwrap_or_default());
        let tukey = Tukey::of(left.iter().copied(), smallest_scale);
        let weights: Vec<f64> = left.iter().map(|&r| tukey.weight(r)).collect();
        let scores: Vec<f64> = left.iter().zip(&weights).map(|(r, w)| r * w).collect();
        let independence = Independence::of(matches, &scores, &weights, target.patch_count());
        let shared = |(m, w): (&Match, &f64)| w * independence.share(m.patch);
        let counted: Vec<f64> = matches.iter().zip(&weights).map(shared).collect();
        let (information, gradient) = sums(matches, &counted);
        let dispersion = tukey.dispersion(left.iter().copied());
        let degeneracy =
            Degeneracy::of(matches, &weights, |m| target.plane(m.plane).tilt_variance_rad2);
        Self {
            information: information / dispersion,
            gradient: gradient / dispersion,
            degeneracy,
            independent_points: independence.points(),
            patches: independence.patches(),
            weights,
        }
    }
}

impl Geometry {
    /// Information and gradient without those of movements that are not seen.
    ///
    /// The search itself takes all there is: with the prior it stands firm, and a threshold in its steps
    /// would make it swing where a movement is barely seen.
    pub(super) fn remapped(&self) -> (Matrix6<f64>, Vector6<f64>) {
        self.degeneracy.remap(&self.information, &self.gradient)
    }
}

fn sums(matches: &[Match], weights: &[f64]) -> (Matrix6<f64>, Vector6<f64>) {
    let (mut information, mut gradient) = (Matrix6::zeros(), Vector6::zeros());
    for (of, weight) in matches.iter().zip(weights) {
        information.syger(*weight, &of.jacobian, &of.jacobian, 1.0);
        gradient += of.jacobian * (weight * of.residual);
    }
    information.fill_upper_triangle_with_lower_triangle();
    (information, gradient)
}

/// The step to where the gradient vanishes; `None` if the matrix is not positive.
pub(super) fn step(information: &Matrix6<f64>, gradient: &Vector6<f64>) -> Option<Vector6<f64>> {
    information.cholesky().map(|factor| -factor.solve(gradient))
}
