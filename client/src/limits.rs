//! How far a lookup may go beyond the poses themselves.

use core::time::Duration;

/// Bounds on interpolation and prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookupLimits {
    /// Longest time between two poses that is interpolated; default 100 ms.
    ///
    /// Small: lost poses show as [`crate::LookupError::Gap`]. Large: motion between far poses is
    /// guessed.
    pub bridge: Duration,
    /// Longest time ahead of the newest pose that is predicted; default 50 ms, 0 forbids it.
    ///
    /// Small: lookups for very recent times fail with [`crate::LookupError::TooNew`]. Large: σ
    /// grows with the square of the time.
    pub prediction: Duration,
    /// How σ grows while predicting.
    pub noise: PredictionNoise,
}

impl Default for LookupLimits {
    fn default() -> Self {
        Self {
            bridge: Duration::from_millis(100),
            prediction: Duration::from_millis(50),
            noise: PredictionNoise::default(),
        }
    }
}

/// What a prediction does not know, as standard deviations per axis.
///
/// The defaults fit a camera carried by hand or on a vehicle over rough ground. Larger values give
/// larger σ sooner; they never change the predicted pose itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictionNoise {
    /// Error of the angular rate, rad/s; default 0.005.
    pub angular_rate_rad_s: f64,
    /// Angular acceleration, which is taken as zero, rad/s²; default 5.
    pub angular_acceleration_rad_s2: f64,
    /// Error of the acceleration (specific force and gravity), m/s²; default 0.05.
    pub acceleration_m_s2: f64,
    /// Jerk, which is taken as zero, m/s³; default 50.
    pub jerk_m_s3: f64,
}

impl Default for PredictionNoise {
    fn default() -> Self {
        Self {
            angular_rate_rad_s: 0.005,
            angular_acceleration_rad_s2: 5.0,
            acceleration_m_s2: 0.05,
            jerk_m_s3: 50.0,
        }
    }
}
