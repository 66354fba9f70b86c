//! The search: match, linearise, step, and closer again.

use nalgebra::{Matrix6, Vector6};

use super::correction::Correction;
use super::error::RegistrationError;
use super::linear::{Geometry, PriorTerm, step};
use super::matches::{Match, Reach, find};
use super::prior::PosePrior;
use super::settings::RegistrationSettings;
use super::source::SourcePoint;
use super::surface::SurfaceMap;

/// What is compared.
#[derive(Clone, Copy, Debug)]
pub(super) struct Problem<'a> {
    pub(super) target: &'a SurfaceMap,
    pub(super) source: &'a [SourcePoint],
    pub(super) prior: &'a PosePrior,
    pub(super) inverse_covariance: Matrix6<f64>,
    pub(super) settings: &'a RegistrationSettings,
}

/// Where a search ended.
#[derive(Clone, Debug)]
pub(super) struct Rest {
    pub(super) correction: Correction,
    pub(super) matches: Vec<Match>,
    pub(super) geometry: Geometry,
    pub(super) prior: PriorTerm,
    pub(super) iterations: usize,
}

/// Standard deviations of a pair within which planes are looked for: enough that a prior which is wrong is
/// found to be so, not left without a match.
const SIGMAS: f64 = 5.0;
/// Clouds that are misaligned by so much of the target's spacing have come close.
const CLOSE: f64 = 0.25;
/// What of the misalignment is taken to be left after a step.
const SHRINKING: f64 = 0.7;
/// Until the clouds are close, one point of so many does.
const COARSE: usize = 4;
/// A step of so many standard deviations of the result is rest.
const REST_SIGMA: f64 = 0.1;
/// Full steps between clouds that are close; then half ones, so that points which change planes to and fro
/// come to rest in between.
const FULL_STEPS: usize = 4;
/// Fewest matches that are linearised at all.
const FEWEST_MATCHES: usize = 50;

impl Problem<'_> {
    /// Gauss-Newton steps with Tukey's weights and a shrinking reach. The prior is in the normal
    /// equations as the measurement that it is, so they are positive whatever the geometry, and no
    /// damping is needed.
    pub(super) fn search(&self) -> Result<Rest, RegistrationError> {
        let coarse: Vec<SourcePoint> = self.source.iter().step_by(COARSE).copied().collect();
        let mut correction = Correction::none(self.prior.world_from_body.origin());
        let mut reach = Reach { misaligned_m: self.misalignment(), sigmas: SIGMAS };
        let (mut step_sigma, mut close) = (f64::INFINITY, 0);
        for iteration in 1..=self.settings.iterations {
            let closing = reach.misaligned_m > CLOSE * self.target.spacing_m();
            let source = if closing { &coarse } else { self.source };
            let rest = self.linearise(&correction, source, reach, iteration)?;
            let (information, gradient) = rest.total();
            let step = step(&information, &gradient).ok_or(RegistrationError::UnusablePrior)?;
            step_sigma = step.dot(&(information * step)).sqrt();
            if !closing && step_sigma < REST_SIGMA {
                return self.with_overlap(rest);
            }
            correction = correction.plus(&(step * if close < FULL_STEPS { 1.0 } else { 0.5 }));
            close += usize::from(!closing);
            reach.misaligned_m *= if closing { SHRINKING } else { 0.0 };
        }
        Err(RegistrationError::NotConverged { iterations: self.settings.iterations, step_sigma })
    }

    fn linearise(
        &self,
        correction: &Correction,
        source: &[SourcePoint],
        reach: Reach,
        iterations: usize,
    ) -> Result<Rest, RegistrationError> {
        let matches = find(source, self.target, correction, reach);
        if matches.len() < FEWEST_MATCHES {
            return Err(self.no_overlap(matches.len() as f64 / source.len() as f64));
        }
        let prior = PriorTerm::at(correction, &self.inverse_covariance);
        let geometry = Geometry::of(&matches, self.target, &prior, reach.smallest_scale());
        Ok(Rest { correction: *correction, matches, geometry, prior, iterations })
    }

    /// Standard deviation of what the prior moves a point by, m.
    fn misalignment(&self) -> f64 {
        let covariance = self.prior.covariance;
        let body = self.prior.world_from_body.origin();
        let square: f64 = self.source.iter().map(|p| p.position.distance_squared(body)).sum();
        let mean_square = square / self.source.len() as f64;
        let turn = crate::covariance::trace(&covariance.orientation_rad2) * mean_square;
        let away = (turn + crate::covariance::trace(&covariance.position_m2)).sqrt();
        away.min(self.settings.reach_m / SIGMAS)
    }

    fn with_overlap(&self, rest: Rest) -> Result<Rest, RegistrationError> {
        let overlap = rest.overlap(self.source.len());
        if overlap < self.settings.overlap { Err(self.no_overlap(overlap)) } else { Ok(rest) }
    }

    const fn no_overlap(&self, found: f64) -> RegistrationError {
        RegistrationError::NoOverlap { found, needed: self.settings.overlap }
    }
}

impl Rest {
    /// Geometry and prior together.
    pub(super) fn total(&self) -> (Matrix6<f64>, Vector6<f64>) {
        let information = self.geometry.information + self.prior.information;
        (information, self.geometry.gradient + self.prior.gradient)
    }

    /// Fraction of the source's points that count.
    pub(super) fn overlap(&self, points: usize) -> f64 {
        self.counting().count() as f64 / points as f64
    }

    /// Median noise of the matches that count, m.
    pub(super) fn typical_sigma_m(&self) -> f64 {
        let mut sigmas: Vec<f64> = self.counting().map(|of| of.sigma_m).collect();
        let middle = sigmas.len() / 2;
        if sigmas.is_empty() {
            0.0
        } else {
            *sigmas.select_nth_unstable_by(middle, f64::total_cmp).1
        }
    }

    /// The matches that count.
    pub(super) fn counting(&self) -> impl Iterator<Item = &Match> {
        self.matches
            .iter()
            .zip(&self.geometry.weights)
            .filter(|(_, weight)| **weight > 0.0)
            .map(|(of, _)| of)
    }
}
