//! Static initial alignment, and the coarse one in motion.

/// Static initial alignment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlignmentParameters {
    /// Length of the window that finds rest, s. Default 0.5.
    pub window_s: f64,
    /// Rest needed, s. Short starts sooner, long averages the noise away. Default 1.
    pub rest_s: f64,
    /// Largest believable difference between the mean specific force and gravity, m/s². Default 0.6.
    pub gravity_tolerance_m_s2: f64,
    /// Largest mean angular rate that a gyroscope bias not known yet may explain, rad/s. Default 0.03.
    pub max_bias_rad_s: f64,
    /// Time after which a camera that does not come to rest is aligned coarsely, s; never if absent.
    /// Short starts sooner, long averages more of the motion away. Default 1.8.
    pub motion_s: Option<f64>,
    /// Change of a moving camera's speed in that time, 1σ, m/s, per axis. Default 2.
    pub motion_speed_sigma_m_s: f64,
    /// Speed of a camera that is aligned in motion, 1σ, m/s, per axis. Default 10.
    pub motion_start_sigma_m_s: f64,
}

impl Default for AlignmentParameters {
    fn default() -> Self {
        Self {
            window_s: 0.5,
            rest_s: 1.0,
            gravity_tolerance_m_s2: 0.6,
            max_bias_rad_s: 0.03,
            motion_s: Some(1.8),
            motion_speed_sigma_m_s: 2.0,
            motion_start_sigma_m_s: 10.0,
        }
    }
}
