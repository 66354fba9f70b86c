//! Measurements by others.

/// Measurements by others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AidingParameters {
    /// How long a source must be refused without pause before it is believed after all, s. Short gives in
    /// to outliers, long stays wrong longer. Default 5.
    pub patience_s: f64,
}

impl Default for AidingParameters {
    fn default() -> Self {
        Self { patience_s: 5.0 }
    }
}
