//! Why a recording is refused.

use crate::Coverage;

/// A recording that cannot tell, and what it lacks.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}", sentence(.missing))]
pub struct Refusal {
    /// What is missing, the most important first; never empty.
    pub missing: Vec<Missing>,
    /// Expected heading σ of what there is, degrees; `None` if no fit was possible.
    pub heading_sigma_deg: Option<f64>,
    /// What was seen.
    pub coverage: Coverage,
}

/// One thing that a recording lacks. Its text says what to do.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Missing {
    /// It is too short.
    #[error("record for longer: {seen_s:.0} s seen, at least {needed_s:.0} s needed")]
    Duration {
        /// Seconds of usable samples.
        seen_s: f64,
        /// Seconds needed.
        needed_s: f64,
    },
    /// There are no or too few readings of the magnetometer.
    #[error("the magnetometer must deliver: {seen} readings seen, at least {needed} needed")]
    Magnetometer {
        /// Readings.
        seen: usize,
        /// Readings needed.
        needed: usize,
    },
    /// It does not turn far enough about the vertical.
    #[error("turn through a whole circle: only {seen_deg:.0}° seen, {needed_deg:.0}° needed")]
    Circle {
        /// Headings seen, degrees of the circle.
        seen_deg: f64,
        /// Headings needed.
        needed_deg: f64,
    },
    /// It does not tilt enough.
    #[error(
        "tilt to each side while turning, by at least {needed_deg:.0}°: only {seen_deg:.1}° seen; \
         the heading would be uncertain by {heading_sigma_deg:.1}° (1σ)"
    )]
    Tilt {
        /// Tilt seen, root mean square from the mean direction, degrees.
        seen_deg: f64,
        /// Tilt that is enough.
        needed_deg: f64,
        /// Expected heading σ, degrees.
        heading_sigma_deg: f64,
    },
    /// It moves well but not for long enough.
    #[error(
        "go on turning: the heading would be uncertain by {heading_sigma_deg:.2}° (1σ), at most \
         {needed_deg:.2}° is needed"
    )]
    Precision {
        /// Expected heading σ, degrees.
        heading_sigma_deg: f64,
        /// Largest that is good enough.
        needed_deg: f64,
    },
    /// The field did not stay the same.
    #[error(
        "keep away from iron: the field changed between {from_s:.1} s and {to_s:.1} s \
         ({percent:.0} % of the readings do not fit)"
    )]
    Disturbance {
        /// First reading that does not fit, s after the first sample.
        from_s: f64,
        /// Last one.
        to_s: f64,
        /// Part of all readings, percent.
        percent: f64,
    },
    /// The readings contradict each other: wrong axes, wrong units, a broken sensor.
    #[error(
        "the sensors contradict each other ({residual_ut:.1} µT left, {expected_ut:.1} µT \
         expected, or soft iron beyond reason): check axes and units"
    )]
    Contradiction {
        /// What the fit leaves, µT per axis.
        residual_ut: f64,
        /// Noise that was expected, µT.
        expected_ut: f64,
    },
}

fn sentence(missing: &[Missing]) -> String {
    missing.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}
