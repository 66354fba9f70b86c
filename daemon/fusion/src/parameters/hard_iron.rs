//! Refinement of the hard iron while running.

/// Refinement of the hard iron while running.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HardIronParameters {
    /// Whether it is done at all. Default true.
    pub enabled: bool,
    /// Hard iron that a calibration leaves, 1σ, µT, per axis. Large believes in a new magnet sooner.
    /// Default 2.
    pub prior_sigma_ut: f64,
    /// Hard iron that is left alone, µT. Small follows what rooms feign, large leaves more of a
    /// magnet in. Default 3.5.
    pub dead_zone_ut: f64,
    /// Largest correction, µT. Default 30.
    pub bound_ut: f64,
    /// Deviation of the field in a room, 1σ, µT, per axis. Default 2.
    pub room_sigma_ut: f64,
    /// Change of hard iron and mean field from one renewal to the next, 1σ, µT. Large forgets a
    /// magnet that was taken away sooner. Default 0.1.
    pub walk_ut: f64,
    /// Turn after which the room's field is another one, rad. Default 0.5.
    pub renewal_turn_rad: f64,
    /// Way after which the room's field is another one, m. Default 0.4.
    pub renewal_way_m: f64,
    /// Fastest turn at which a reading is used, rad/s. Default 2.
    pub max_rate_rad_s: f64,
}

impl Default for HardIronParameters {
    fn default() -> Self {
        Self {
            enabled: true,
            prior_sigma_ut: 2.0,
            dead_zone_ut: 3.5,
            bound_ut: 30.0,
            room_sigma_ut: 2.0,
            walk_ut: 0.1,
            renewal_turn_rad: 0.5,
            renewal_way_m: 0.4,
            max_rate_rad_s: 2.0,
        }
    }
}
