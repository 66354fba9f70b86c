//! Why a cloud is not laid over another.

use super::degeneracy::Direction;

/// Why a registration was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RegistrationError {
    /// One of the clouds holds too little.
    #[error("the {cloud} has {found} usable points; needed: {needed}")]
    TooFewPoints {
        /// Which cloud: `source` or `target`.
        cloud: &'static str,
        /// Points that are finite, in front of the lens, and in the target on a plane.
        found: usize,
        /// Fewest that do.
        needed: usize,
    },
    /// The target is too large for its index.
    #[error("the target cannot be indexed: {what}")]
    Index {
        /// What the index says.
        what: String,
    },
    /// The pose that the search begins at is not usable.
    #[error(
        "the prior's covariance is not usable; needed: finite, symmetric, with all variances above zero"
    )]
    UnusablePrior,
    /// The clouds hardly share a surface.
    #[error(
        "no overlap: {:.0} % of the source lie on the target; needed: {:.0} %",
        .found * 100.0, .needed * 100.0
    )]
    NoOverlap {
        /// Fraction of the source's points that lie on a plane of the target.
        found: f64,
        /// Smallest fraction that will do.
        needed: f64,
    },
    /// The search did not come to rest.
    #[error("not converged after {iterations} iterations: the last step was {step_sigma:.2} σ")]
    NotConverged {
        /// How often the clouds were compared.
        iterations: usize,
        /// Length of the last step in standard deviations of the result.
        step_sigma: f64,
    },
    /// The surfaces that both clouds show leave a movement open.
    #[error("degenerate: the geometry does not tell {}", words(.unseen))]
    Degenerate {
        /// The movements it leaves open.
        unseen: Vec<Direction>,
    },
    /// The geometry and the pose exclude each other.
    #[error(
        "contradicts the prior: {distance:.1} σ apart where {allowed:.2} σ are allowed (99.73 % in six dimensions, as 3 σ in one)"
    )]
    ContradictsPrior {
        /// Mahalanobis distance of the two poses.
        distance: f64,
        /// Largest allowed.
        allowed: f64,
    },
}

fn words(unseen: &[Direction]) -> String {
    let each: Vec<_> = unseen.iter().map(ToString::to_string).collect();
    each.join(", ")
}
