//! Detection of standstill.

/// Scatter of the sensors without motion: the unit in which a window's statistic measures it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stillness {
    /// Angular rate about the bias, 1σ, rad/s, per axis and step. Default 0.02; a foot's stance 0.11.
    pub rate_sigma_rad_s: f64,
    /// Specific force about gravity, 1σ, m/s², per axis and step. Default 0.15; a foot's stance 0.5.
    pub force_sigma_m_s2: f64,
}

/// Detection of standstill over a sliding window, and what a standstill is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestParameters {
    /// Whether a standstill corrects the filter. False for what is never known to stand, such as a camera
    /// aboard a ship, and to see what the filter does by itself. Default true.
    pub enabled: bool,
    /// Length of the window, s; a tenth of it lies between two decisions. Short reacts fast, long is
    /// rarely fooled by slow motion. Default 0.5.
    pub window_s: f64,
    /// How still a standing camera is.
    pub stillness: Stillness,
    /// Largest statistic of a standing camera. Small misses standstills on a running engine, large
    /// stops a slow camera. Default 1.
    pub threshold: f64,
    /// Largest mean angular rate after the bias estimate, rad/s. A steady turn below it is taken for
    /// bias; a bias that changes by more in motion delays the next standstill. Default 0.004.
    pub mean_rate_rad_s: f64,
    /// Velocity noise of a zero-velocity update, 1σ, m/s. Default 0.01.
    pub velocity_sigma_m_s: f64,
    /// Least noise of a zero-rate update, 1σ, rad/s. Default 2e-4.
    pub turn_sigma_rad_s: f64,
}

impl Default for RestParameters {
    fn default() -> Self {
        Self {
            enabled: true,
            window_s: 0.5,
            stillness: Stillness { rate_sigma_rad_s: 0.02, force_sigma_m_s2: 0.15 },
            threshold: 1.0,
            mean_rate_rad_s: 0.004,
            velocity_sigma_m_s: 0.01,
            turn_sigma_rad_s: 2e-4,
        }
    }
}

impl RestParameters {
    /// Time between two decisions, s.
    pub(crate) fn interval_s(&self) -> f64 {
        0.1 * self.window_s
    }

    /// How still a foot gets on which somebody stands, and how sure one may be then that it does not turn.
    pub(super) const FOOT: Self = Self {
        enabled: true,
        window_s: 0.5,
        stillness: Stillness { rate_sigma_rad_s: 0.05, force_sigma_m_s2: 0.2 },
        threshold: 2.0,
        mean_rate_rad_s: 0.02,
        velocity_sigma_m_s: 0.01,
        turn_sigma_rad_s: 4.0e-3,
    };
}
