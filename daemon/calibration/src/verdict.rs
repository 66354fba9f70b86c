//! Whether a recording tells enough, and what it lacks if not.

use glam::{DMat3, DVec3};

use crate::refusal::Missing;
use crate::settings::{Limits, Settings};
use crate::solve::{Fit, Left};
use crate::stream::Stream;
use crate::{Coverage, Outcome};

/// Fewest readings of the magnetometer that are worth a fit.
const LEAST_READINGS: usize = 200;
/// Tilt that shows the vertical part of the calibration, degrees.
const GOOD_TILT_DEG: f64 = 5.0;
/// Tilt below which it is to blame for a large σ, degrees.
const POOR_TILT_DEG: f64 = 4.0;
/// A bin of readings with a squared residual above this many variances does not fit: about one in
/// 10⁸ undisturbed ones does (χ², three degrees of freedom).
const MISFIT: f64 = 40.0;
/// A field that varies by less than this, root mean square, was not turned, µT.
const LEAST_VARIATION_UT: f64 = 3.0;
/// Soft iron further from none than this comes from wrong axes, not from iron.
const MOST_SOFT_IRON: f64 = 0.6;
/// A residual above this many times the expected noise is a contradiction.
const CONTRADICTION: f64 = 6.0;

/// What a fit needs.
pub(crate) fn before_fit(stream: &Stream, seen: &Coverage, limits: &Limits) -> Vec<Missing> {
    let mut missing = Vec::new();
    let (seen_s, needed_s) = (stream.duration_s(), limits.duration_s);
    if seen_s < needed_s {
        missing.push(Missing::Duration { seen_s, needed_s });
    }
    let (readings, needed) = (stream.mag_readings(), LEAST_READINGS);
    if readings < needed {
        missing.push(Missing::Magnetometer { seen: readings, needed });
    } else if missing.is_empty() && variation_ut(stream) < LEAST_VARIATION_UT {
        let (seen_deg, needed_deg) = (seen.circle_deg, limits.circle_deg);
        missing.push(Missing::Circle { seen_deg, needed_deg });
    }
    missing
}

/// Root mean square of the readings about their mean, µT.
fn variation_ut(stream: &Stream) -> f64 {
    let readings = || stream.steps.iter().filter_map(|step| step.mag);
    let count = readings().count() as f64;
    let mean = readings().sum::<DVec3>() / count;
    (readings().map(|mag| (mag - mean).length_squared()).sum::<f64>() / count).sqrt()
}

/// The readings are so far from any model that the equations have no solution.
pub(crate) fn unsolvable(settings: &Settings) -> Missing {
    Missing::Contradiction { residual_ut: f64::INFINITY, expected_ut: settings.noise.mag_sigma_ut }
}

/// What the result lacks, the cause before its effects.
pub(crate) fn after_fit(outcome: &Outcome, fit: &Fit, settings: &Settings) -> Vec<Missing> {
    let movement = movement(outcome, &settings.limits);
    let iron = disturbance(fit, settings.limits.disturbed_ratio);
    let contradiction = contradiction(fit, settings);
    let mut missing: Vec<Missing> = iron.into_iter().chain(movement).collect();
    if missing.is_empty() {
        missing.extend(contradiction);
    }
    missing
}

fn movement(outcome: &Outcome, limits: &Limits) -> Vec<Missing> {
    let Coverage { circle_deg, tilt_deg, .. } = outcome.coverage;
    let sigma = outcome.magnetometer.heading_sigma_deg;
    let mut missing = Vec::new();
    if circle_deg < limits.circle_deg {
        missing.push(Missing::Circle { seen_deg: circle_deg, needed_deg: limits.circle_deg });
    }
    let is_poor = sigma > limits.heading_sigma_deg;
    if tilt_deg < limits.tilt_deg || is_poor && tilt_deg < POOR_TILT_DEG {
        let needed_deg = GOOD_TILT_DEG;
        missing.push(Missing::Tilt { seen_deg: tilt_deg, needed_deg, heading_sigma_deg: sigma });
    } else if is_poor && missing.is_empty() {
        let needed_deg = limits.heading_sigma_deg;
        missing.push(Missing::Precision { heading_sigma_deg: sigma, needed_deg });
    }
    missing
}

fn disturbance(fit: &Fit, allowed_ratio: f64) -> Option<Missing> {
    let misfits = |left: &&Left| left.square() > MISFIT * fit.noise.mag.powi(2);
    let all: usize = fit.mag.iter().map(|left| left.count).sum();
    let misfit: usize = fit.mag.iter().filter(misfits).map(|left| left.count).sum();
    let ratio = misfit as f64 / all.max(1) as f64;
    let first = fit.mag.iter().find(misfits)?;
    let last = fit.mag.iter().rfind(misfits)?;
    (ratio > allowed_ratio).then_some(Missing::Disturbance {
        from_s: first.time_s,
        to_s: last.time_s,
        percent: 100.0 * ratio,
    })
}

fn contradiction(fit: &Fit, settings: &Settings) -> Option<Missing> {
    let (residual_ut, expected_ut) = (fit.noise.mag, settings.noise.mag_sigma_ut);
    let strange = fit.state.globals.soft_iron() - DMat3::IDENTITY;
    let is_strange = strange.to_cols_array().iter().any(|e| e.abs() > MOST_SOFT_IRON);
    (!fit.converged || is_strange || residual_ut > CONTRADICTION * expected_ut)
        .then_some(Missing::Contradiction { residual_ut, expected_ut })
}
