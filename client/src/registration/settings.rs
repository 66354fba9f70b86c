//! What a registration allows.

/// Limits and thresholds of a registration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegistrationSettings {
    /// Source points used, evenly out of all; more cost time and tell little.
    pub source_points: usize,
    /// Steps before it gives up.
    pub iterations: usize,
    /// Fraction of the source's points that must lie on the target in the end.
    pub overlap: f64,
    /// Largest distance over which a point looks for its plane in the beginning, m; the prior's
    /// covariance may ask for less.
    pub reach_m: f64,
    /// Largest Mahalanobis distance between prior and geometry that is not a contradiction.
    ///
    /// The default holds 99.73 % of all that fit, as 3 σ do in one dimension: the root of the χ²
    /// quantile for six degrees of freedom, 20.06. A deviation in one direction alone may so reach 4.48 σ.
    pub contradiction_sigma: f64,
}

impl Default for RegistrationSettings {
    fn default() -> Self {
        Self {
            source_points: 5_000,
            iterations: 40,
            overlap: 0.25,
            reach_m: 1.0,
            contradiction_sigma: 20.062_f64.sqrt(),
        }
    }
}
