//! What a registration found, and whether it may be used as a fix.

use nalgebra::{Matrix6, Vector6};

use super::correction::Correction;
use super::degeneracy::Direction;
use super::error::RegistrationError;
use super::linear::step;
use super::prior::{PoseCovariance, PosePrior};
use super::residual::distance_m;
use super::search::{Problem, Rest};
use crate::frame::{Body, World};
use crate::transform::Transform;

/// How a registration went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegistrationStatistics {
    /// How often the clouds were compared.
    pub iterations: usize,
    /// Points of the source that lie on planes of the target in the end.
    pub correspondences: usize,
    /// What they are worth in independent points.
    pub independent_points: f64,
    /// Pieces of the target's surface on which they lie.
    pub patches: usize,
    /// Fraction of the source that they are, 0 to 1.
    pub overlap: f64,
    /// Root mean square of their distances to the planes by the prior, m.
    pub rmse_before_m: f64,
    /// The same after the correction, m.
    pub rmse_after_m: f64,
}

/// A pose with its covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseEstimate {
    /// Where the camera is.
    pub world_from_body: Transform<World, Body>,
    /// How surely.
    pub covariance: PoseCovariance,
    /// The movement that leads here from the prior.
    pub correction: Correction,
}

/// The source laid over the target as well as prior and geometry together tell.
#[derive(Clone, Debug)]
pub struct Alignment {
    /// The most probable pose, given prior and geometry.
    pub posterior: PoseEstimate,
    /// Movements that the geometry leaves open: along them the posterior is the prior.
    pub unseen: Vec<Direction>,
    /// Mahalanobis distance between the prior and what the geometry says alone.
    pub distance_from_prior: f64,
    /// How it went.
    pub statistics: RegistrationStatistics,
    geometry: Option<PoseEstimate>,
    contradiction_sigma: f64,
}

impl Alignment {
    /// What the geometry says alone: a measurement that may be given to whoever made the prior without
    /// counting the prior twice. Where the map as a whole is wrong in the world, so is this: its covariance is
    /// that of the pose relative to the map.
    ///
    /// # Errors
    /// [`RegistrationError::Degenerate`] if the geometry leaves any movement open,
    /// [`RegistrationError::ContradictsPrior`] if one of the two must be wrong.
    pub fn fix(&self) -> Result<PoseEstimate, RegistrationError> {
        let unseen = || RegistrationError::Degenerate { unseen: self.unseen.clone() };
        let geometry = self.geometry.ok_or_else(unseen)?;
        let (distance, allowed) = (self.distance_from_prior, self.contradiction_sigma);
        if distance > allowed {
            return Err(RegistrationError::ContradictsPrior { distance, allowed });
        }
        Ok(geometry)
    }

    pub(super) fn of(problem: &Problem<'_>, rest: &Rest) -> Result<Self, RegistrationError> {
        let unusable = RegistrationError::UnusablePrior;
        let (own, pull) = rest.geometry.remapped();
        let information = own + rest.prior.information;
        let gradient = pull + rest.prior.gradient;
        let towards = step(&information, &gradient).ok_or(unusable.clone())?;
        let posterior = estimate(problem.prior, rest, &towards, &information).ok_or(unusable)?;
        let alone = step(&own, &pull).filter(|_| rest.geometry.degeneracy.unseen().is_empty());
        let geometry = alone.and_then(|away| estimate(problem.prior, rest, &away, &own));
        Ok(Self {
            distance_from_prior: distance_from_prior(problem, &posterior, geometry.as_ref()),
            posterior,
            unseen: rest.geometry.degeneracy.unseen().to_vec(),
            statistics: statistics(problem, rest),
            geometry,
            contradiction_sigma: problem.settings.contradiction_sigma,
        })
    }
}

/// What all planes of a map may have in common, as a share of a pair's noise: the bias of planes through
/// noisy points, towards the inside of corners and with the noise's growth along a wall. It does not
/// average out, neither over points nor over registrations against the same map.
const SHARED_OF_NOISE: f64 = 0.05;

fn estimate(
    prior: &PosePrior,
    rest: &Rest,
    step: &Vector6<f64>,
    information: &Matrix6<f64>,
) -> Option<PoseEstimate> {
    let correction = rest.correction.plus(step);
    let systematic = rest.geometry.degeneracy.uncertain(SHARED_OF_NOISE * rest.typical_sigma_m());
    let covariance = PoseCovariance::from_matrix(&(information.cholesky()?.inverse() + systematic));
    let pose = correction.transform() * prior.world_from_body;
    Some(PoseEstimate { world_from_body: pose, covariance, correction })
}

/// `x ᵀ (P + C)⁻¹ x`, with `x` where the geometry alone leads and `C` its covariance; where it leaves
/// movements open, `x ᵀ P⁻¹ x` of the posterior, along which it has not moved there.
fn distance_from_prior(
    problem: &Problem<'_>,
    posterior: &PoseEstimate,
    geometry: Option<&PoseEstimate>,
) -> f64 {
    let Some(alone) = geometry else {
        let x = posterior.correction.vector();
        return x.dot(&(problem.inverse_covariance * x)).sqrt();
    };
    let both = problem.prior.covariance.matrix() + alone.covariance.matrix();
    let x = alone.correction.vector();
    both.cholesky().map_or(f64::INFINITY, |factor| x.dot(&factor.solve(&x)).sqrt())
}

fn statistics(problem: &Problem<'_>, rest: &Rest) -> RegistrationStatistics {
    let none = Correction::none(problem.prior.world_from_body.origin());
    let rms = |correction: &Correction| {
        let square = |of: &super::matches::Match| {
            let point = problem.source[of.point as usize].position;
            distance_m(correction, point, problem.target.plane(of.plane)).powi(2)
        };
        let count = rest.counting().count().max(1) as f64;
        (rest.counting().map(square).sum::<f64>() / count).sqrt()
    };
    RegistrationStatistics {
        iterations: rest.iterations,
        correspondences: rest.counting().count(),
        independent_points: rest.geometry.independent_points,
        patches: rest.geometry.patches,
        overlap: rest.overlap(problem.source.len()),
        rmse_before_m: rms(&none),
        rmse_after_m: rms(&rest.correction),
    }
}
