//! The filter's parameters.

use serde::{Deserialize, Serialize};

/// How the magnetometer steers the heading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HeadingMode {
    /// Every reading counts.
    Continuous,
    /// Readings that do not fit are refused, and accepted again when they do.
    #[default]
    Adaptive,
    /// Only the initial alignment uses the magnetometer.
    InitialOnly,
}

/// What carries the sensor, which decides how still a standstill is and how long the alignment has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// A vehicle or a hand.
    #[default]
    Carried,
    /// A foot, which stands for some tenths of a second in each step.
    Foot,
}

/// The filter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Estimator {
    /// What carries the sensor.
    pub preset: Preset,
    /// How the magnetometer steers the heading.
    pub heading: HeadingMode,
    /// Rest needed before the initial alignment, s.
    pub alignment_rest_s: f64,
    /// Time after which a camera that does not come to rest is aligned coarsely, s; 0 never.
    pub alignment_motion_s: f64,
    /// Whether a magnet that was mounted on the camera is learnt while running.
    pub hard_iron_refinement: bool,
    /// When values are called valid.
    pub validity: ValidityBounds,
}

impl Default for Estimator {
    fn default() -> Self {
        Self {
            preset: Preset::Carried,
            heading: HeadingMode::Adaptive,
            alignment_rest_s: 1.0,
            alignment_motion_s: 1.8,
            hard_iron_refinement: true,
            validity: ValidityBounds::default(),
        }
    }
}

/// A value whose standard deviation is above its bound loses its validity flag.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ValidityBounds {
    /// Roll and pitch, degrees.
    pub tilt_sigma_deg: f64,
    /// Heading, degrees.
    pub heading_sigma_deg: f64,
    /// Velocity, m/s per axis.
    pub velocity_sigma_m_s: f64,
    /// Position, m per axis.
    pub position_sigma_m: f64,
}

impl Default for ValidityBounds {
    fn default() -> Self {
        Self {
            tilt_sigma_deg: 5.0,
            heading_sigma_deg: 20.0,
            velocity_sigma_m_s: 1.0,
            position_sigma_m: 1.0,
        }
    }
}
