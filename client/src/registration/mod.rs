//! Laying one cloud over another: point-to-plane ICP with the pose as prior.
//!
//! The pose that the daemon publishes enters as the measurement that it is, with its covariance; the
//! geometry corrects what it knows better. The result is refused as a fix where the geometry leaves a
//! movement open, as in a corridor, or contradicts the pose.
//!
//! ```
//! use glam::{DMat3, DVec3};
//! use lodestone_client::registration::{
//!     DepthNoise, PoseCovariance, PosePrior, RegistrationSettings, SourceCloud, SurfaceMap, register,
//! };
//! use lodestone_client::{Transform, body_from_optical_axes};
//!
//! // The corner of a room, 5 cm apart; and the same, seen by a camera that stands 3 cm further east than it believes.
//! let corner: Vec<DVec3> = (0..6_400)
//!     .map(|i| (f64::from(i % 80) * 0.05, f64::from(i / 80) * 0.05))
//!     .flat_map(|(u, v)| [DVec3::new(4.0, u, v), DVec3::new(u, 4.0, v), DVec3::new(u, v, 0.0)])
//!     .collect();
//! let seen = corner.iter().map(|point| *point - 0.03 * DVec3::X);
//!
//! let world_from_body = Transform::IDENTITY;
//! let covariance = PoseCovariance::independent(DMat3::IDENTITY * 1e-4, DMat3::IDENTITY * 1e-2);
//! let source = SourceCloud::new(body_from_optical_axes_in_world(), seen, DepthNoise::ZED2);
//! let target = SurfaceMap::new(corner.iter().map(|point| (*point, 1.0)), &Default::default())?;
//! let prior = PosePrior { world_from_body, covariance };
//! let found = register(&target, &source, &prior, &RegistrationSettings::default())?;
//!
//! let fix = found.fix()?;
//! assert!(fix.world_from_body.origin().abs_diff_eq(0.03 * DVec3::X, 2e-3));
//! # fn body_from_optical_axes_in_world() -> Transform<lodestone_client::World, lodestone_client::Optical> {
//! #     Transform::<lodestone_client::World, lodestone_client::Body>::IDENTITY * body_from_optical_axes()
//! # }
//! # Ok::<(), lodestone_client::registration::RegistrationError>(())
//! ```

mod alignment;
mod correction;
mod degeneracy;
mod error;
mod independence;
mod linear;
mod matches;
mod plane;
mod prior;
mod residual;
mod robust;
mod search;
mod settings;
mod source;
mod surface;
#[cfg(test)]
mod tests;

pub use alignment::{Alignment, PoseEstimate, RegistrationStatistics};
pub use correction::Correction;
pub use degeneracy::Direction;
pub use error::RegistrationError;
pub use prior::{PoseCovariance, PosePrior};
pub use settings::RegistrationSettings;
pub use source::{DepthNoise, SourceCloud};
pub use surface::{SurfaceMap, SurfaceSettings};

use search::Problem;

/// Fewest source points that are compared at all.
const FEWEST_POINTS: usize = 200;

/// Lays a source over a target, beginning at the prior.
///
/// # Errors
/// [`RegistrationError`], except [`RegistrationError::Degenerate`] and
/// [`RegistrationError::ContradictsPrior`], which [`Alignment::fix`] gives.
pub fn register(
    target: &SurfaceMap,
    source: &SourceCloud,
    prior: &PosePrior,
    settings: &RegistrationSettings,
) -> Result<Alignment, RegistrationError> {
    let covariance = prior.covariance.matrix();
    let finite =
        prior.world_from_body.origin().is_finite() && covariance.iter().all(|c| c.is_finite());
    let inverse = covariance.cholesky().filter(|_| finite).map(|factor| factor.inverse());
    let inverse_covariance = inverse.ok_or(RegistrationError::UnusablePrior)?;
    if source.len() < FEWEST_POINTS {
        let (found, needed) = (source.len(), FEWEST_POINTS);
        return Err(RegistrationError::TooFewPoints { cloud: "source", found, needed });
    }
    let points = source.thinned(settings.source_points);
    let problem = Problem { target, source: &points, prior, inverse_covariance, settings };
    let rest = problem.search()?;
    Alignment::of(&problem, &rest)
}
