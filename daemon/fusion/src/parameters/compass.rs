//! Heading by the magnetometer.

/// How the magnetometer steers the heading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HeadingMode {
    /// Every reading counts.
    Continuous,
    /// A reading counts the less, the worse its strength and dip fit the reference; one that does
    /// not fit at all is refused.
    #[default]
    Adaptive,
    /// Only the initial alignment uses the magnetometer.
    InitialOnly,
}

/// Heading by the magnetometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompassParameters {
    /// What neither turning nor walking averages away, as a heading, 1σ, rad: iron that the
    /// calibration left. It is not estimated, only counted in what is published. Default 1.5°.
    pub systematic_sigma_rad: f64,
    /// Usual deviation of the field in a room from the earth's, as an angle, 1σ, rad. Default 2°.
    pub deviation_sigma_rad: f64,
    /// Turn after which the deviation is a new one, rad. Default 3.
    pub deviation_turn_rad: f64,
    /// Way after which the deviation is a new one, m. Default 0.4.
    pub deviation_way_m: f64,
    /// Time after which the deviation is a new one even at rest, s. Default 300.
    pub deviation_time_s: f64,
    /// Delay of the magnetometer against the gyroscope that is known beforehand, s; negative where the
    /// gyroscope passes a filter that the magnetometer does not. Default 0.
    pub delay_s: f64,
    /// Unknown delay of the magnetometer against that, 1σ, s; it is learnt while the camera
    /// turns. Default 0.02.
    pub delay_sigma_s: f64,
    /// Uncertainty of a single reading's time around that delay, 1σ, s. Default 0.005.
    pub timing_sigma_s: f64,
    /// Change of the field in the world, µT, by which the deviation counts as changed. Small doubts the
    /// compass at every noise, large misses disturbances that come on in small steps. Default 2.
    pub change_ut: f64,
    /// Variance of the deviation for each squared mismatch, both as fields, µT²/µT². A half if a
    /// disturbance has no favourite direction. Large trusts a misfitting field less. Default 3:
    /// what can be seen of a disturbance is often the lesser part.
    pub mismatch_weight: f64,
    /// Smoothed mismatch of strength and dip against the reference beyond which the field is called
    /// disturbed, µT; below six tenths of it the disturbance has ended. Default 3.5.
    pub mismatch_limit_ut: f64,
    /// Time constant of that smoothing, s. Default 0.3.
    pub mismatch_time_constant_s: f64,
    /// Time constant with which the reference follows the field, s. Default 30.
    pub reference_time_constant_s: f64,
    /// Seconds over which readings are averaged before an update. Default 0.02.
    pub interval_s: f64,
    /// Normalised innovation beyond which an update is weakened, and beyond twice which it is refused.
    /// Default 1.5.
    pub gate_sigma: f64,
    /// Time after which innovations are no longer refused, only weakened, s. Long withstands long
    /// disturbances, short finds back sooner from a wrong heading. Default 120.
    pub patience_s: f64,
}

impl Default for CompassParameters {
    fn default() -> Self {
        Self {
            systematic_sigma_rad: 0.026,
            deviation_sigma_rad: 0.035,
            deviation_turn_rad: 3.0,
            deviation_way_m: 0.4,
            deviation_time_s: 300.0,
            delay_s: 0.0,
            delay_sigma_s: 0.02,
            timing_sigma_s: 0.005,
            change_ut: 2.0,
            mismatch_weight: 3.0,
            mismatch_limit_ut: 3.5,
            mismatch_time_constant_s: 0.3,
            reference_time_constant_s: 30.0,
            interval_s: 0.02,
            gate_sigma: 1.5,
            patience_s: 120.0,
        }
    }
}
