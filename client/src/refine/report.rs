//! What became of registrations.

use glam::DVec3;

use crate::registration::{RegistrationError, RegistrationStatistics};

/// Refused registrations, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Refusals {
    /// Too few points, in the cloud or in what others saw.
    pub too_few_points: u64,
    /// Hardly anything that both saw.
    pub no_overlap: u64,
    /// The geometry leaves a movement open.
    pub degenerate: u64,
    /// Pose and geometry exclude each other.
    pub contradicts_prior: u64,
    /// The search did not come to rest, or the pose's covariance is not usable.
    pub other: u64,
}

impl Refusals {
    /// All of them.
    pub const fn total(&self) -> u64 {
        let Self { too_few_points, no_overlap, degenerate, contradicts_prior, other } = *self;
        too_few_points + no_overlap + degenerate + contradicts_prior + other
    }

    pub(super) const fn count(&mut self, why: &RegistrationError) {
        let count = match why {
            RegistrationError::TooFewPoints { .. } => &mut self.too_few_points,
            RegistrationError::NoOverlap { .. } => &mut self.no_overlap,
            RegistrationError::Degenerate { .. } => &mut self.degenerate,
            RegistrationError::ContradictsPrior { .. } => &mut self.contradicts_prior,
            RegistrationError::NotConverged { .. }
            | RegistrationError::UnusablePrior
            | RegistrationError::Index { .. } => &mut self.other,
        };
        *count += 1;
    }
}

/// What became of one camera's registrations and clouds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RefineReport {
    /// Registrations that were accepted.
    pub accepted: u64,
    /// Those that were not.
    pub refused: Refusals,
    /// Why the last of them was not.
    pub last_refusal: Option<RegistrationError>,
    /// Clouds left out while the first registration was waited for.
    pub held: u64,
    /// Clouds that went into the map without a correction, for want of one.
    pub unrefined: u64,
    /// How the last accepted registration went.
    pub last: Option<RegistrationStatistics>,
    /// The correction in use: a turn about the world's axes, rad, and a shift of the body, m.
    pub correction: Option<(DVec3, DVec3)>,
}
