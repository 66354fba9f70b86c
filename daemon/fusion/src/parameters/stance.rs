//! Detection of a foot's stances.

use super::rest::Stillness;

/// Detection of a foot's stance, for a sensor that is mounted on it.
///
/// A stance lasts some tenths of a second, and in it the foot rolls on. How still it gets depends on the
/// gait, so a threshold alone fits one gait: what a stance is worth falls with its statistic T,
/// `σ² = σ₀² (1 + (T / T₀)²)`, and the threshold only keeps out what cannot be one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StanceParameters {
    /// Length of the window, s. Short finds short stances, long is rarely fooled by a slow swing.
    /// Default 0.05.
    pub window_s: f64,
    /// How still a foot is that stands.
    pub stillness: Stillness,
    /// Largest statistic of a stance. Small loses those of a fast gait, and the position with them; large
    /// lets swings slow the foot down. Default 150.
    pub threshold: f64,
    /// Statistic T₀ from which a stance is worth less. Default 10.
    pub statistic_scale: f64,
    /// Velocity of the stillest stance, 1σ, m/s, per axis and update. Default 0.03.
    pub velocity_sigma_m_s: f64,
}

impl Default for StanceParameters {
    fn default() -> Self {
        Self {
            window_s: 0.05,
            stillness: Stillness { rate_sigma_rad_s: 0.11, force_sigma_m_s2: 0.5 },
            threshold: 150.0,
            statistic_scale: 10.0,
            velocity_sigma_m_s: 0.03,
        }
    }
}
