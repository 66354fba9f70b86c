//! Levelling by gravity.

/// Levelling: the leaky velocity of a carried camera stays small.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevellingParameters {
    /// Time constant of the leak, s. Long averages more of the motion away, short forgets errors of
    /// the specific force sooner. Default 3.
    pub time_constant_s: f64,
    /// Usual size of the leaky velocity, 1σ, m/s, per axis. Small trusts gravity more. Default 0.3.
    pub sigma_m_s: f64,
    /// Time over which the usual size is learnt where it is larger, s. Default 10.
    pub memory_s: f64,
    /// Part of its mean square that the variance of the leaky velocity is at least. Large distrusts
    /// gravity in a vehicle, and after every error of the tilt. Default 0.7.
    pub liveliness: f64,
    /// Seconds between two updates. Default 0.1.
    pub interval_s: f64,
    /// Normalised innovation beyond which an update is weakened. Default 3.
    pub gate_sigma: f64,
}

impl Default for LevellingParameters {
    fn default() -> Self {
        Self {
            time_constant_s: 3.0,
            sigma_m_s: 0.3,
            memory_s: 10.0,
            liveliness: 0.7,
            interval_s: 0.1,
            gate_sigma: 3.0,
        }
    }
}
