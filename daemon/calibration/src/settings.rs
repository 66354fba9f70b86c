//! What is known before the first sample.

use glam::DVec3;

/// What to assume of sensors and place, and what to demand of the result.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settings {
    /// Noise of the sensors, and how far off they may be.
    pub noise: SensorNoise,
    /// The earth's field at the place, if known; it fixes the scale of the readings in µT and has
    /// little effect on the heading.
    pub field: Option<FieldPrior>,
    /// Unit vector that points up in sensor axes while the camera is level, for the σ of a level
    /// camera; the mean direction seen, if absent.
    pub level_up: Option<DVec3>,
    /// What the result must reach.
    pub limits: Limits,
}

/// Noise of the sensors (as densities, so that the rate does not matter) and 1σ of what the
/// calibration is to find. Defaults: a ZED 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorNoise {
    /// Gyroscope noise density, rad/s/√Hz; a lower bound, the fit raises it where the data ask for it.
    pub gyro_density_rad_s_rthz: f64,
    /// Random walk of the gyroscope bias, rad/s²/√Hz.
    pub gyro_bias_walk_rad_s2_rthz: f64,
    /// Gyroscope bias, 1σ, rad/s.
    pub gyro_bias_sigma_rad_s: f64,
    /// Error of the gyroscope's scale, 1σ, a ratio.
    pub gyro_scale_sigma: f64,
    /// Accelerometer noise density, m/s²/√Hz; a lower bound, the residuals tell the real one.
    pub accel_density_m_s2_rthz: f64,
    /// Accelerometer bias, 1σ, m/s².
    pub accel_bias_sigma_m_s2: f64,
    /// Magnetometer noise of one reading, 1σ, µT: what is expected; the residuals tell the real
    /// one.
    pub mag_sigma_ut: f64,
    /// How old gyroscope and accelerometer are against a magnetometer reading of the same time stamp, s:
    /// the group delay of their filter.
    pub imu_delay_s: f64,
    /// 1σ of that, s. In a pure cone a wrong delay cannot be told from a turn of the soft iron: small
    /// values promise more than may hold, large ones refuse cones.
    pub imu_delay_sigma_s: f64,
    /// Each element of the soft iron `A` about the identity, 1σ.
    pub soft_iron_sigma: f64,
    /// Each component of the hard iron, 1σ, µT.
    pub hard_iron_sigma_ut: f64,
}

impl Default for SensorNoise {
    fn default() -> Self {
        Self {
            gyro_density_rad_s_rthz: 1.22e-4,
            gyro_bias_walk_rad_s2_rthz: 1.0e-5,
            gyro_bias_sigma_rad_s: 0.02,
            gyro_scale_sigma: 0.01,
            accel_density_m_s2_rthz: 1.6e-3,
            accel_bias_sigma_m_s2: 0.3,
            mag_sigma_ut: 0.5,
            imu_delay_s: 0.0,
            imu_delay_sigma_s: 0.002,
            soft_iron_sigma: 0.12,
            hard_iron_sigma_ut: 200.0,
        }
    }
}

/// The earth's field at a place, each with its 1σ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldPrior {
    /// Strength, µT.
    pub strength_ut: f64,
    /// 1σ of the strength, µT.
    pub strength_sigma_ut: f64,
    /// Dip, degrees, positive downward (northern hemisphere).
    pub dip_deg: f64,
    /// 1σ of the dip, degrees.
    pub dip_sigma_deg: f64,
}

/// What the result must reach, else it is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest expected heading σ over the tilts seen, degrees. Small: refuses good recordings;
    /// large: lets pass what does not help a compass.
    pub heading_sigma_deg: f64,
    /// Least part of the full circle that must be seen, degrees.
    pub circle_deg: f64,
    /// Least tilt from the mean direction that must be seen, root mean square, degrees. In simulation
    /// less is enough; in a real unit the axes of its sensors differ by some tenths of a degree.
    pub tilt_deg: f64,
    /// Shortest recording, s.
    pub duration_s: f64,
    /// Largest part of magnetometer readings that may not fit, a ratio: more is a disturbance.
    pub disturbed_ratio: f64,
    /// Least range of temperature from which slopes are fitted, K.
    pub temperature_range_k: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            heading_sigma_deg: 1.5,
            circle_deg: 300.0,
            tilt_deg: 2.0,
            duration_s: 15.0,
            disturbed_ratio: 0.05,
            temperature_range_k: 5.0,
        }
    }
}
