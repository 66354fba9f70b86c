//! What comes out.

use glam::{DMat3, DVec3};

use crate::Coverage;

/// What one recording tells about the sensors.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Magnetometer.
    pub magnetometer: MagnetometerErrors,
    /// Gyroscope.
    pub gyro: GyroErrors,
    /// Accelerometer; `None` if the movement shows no component of its bias.
    pub accelerometer: Option<AccelerometerErrors>,
    /// Temperatures during the recording; `None` if there were none.
    pub temperature: Option<TemperatureSpan>,
    /// The movement it rests on.
    pub coverage: Coverage,
    /// Steps of the fit.
    pub iterations: u32,
}

/// The magnetometer's model: `B = C (B̃ − b₀ − b₁ (T − T₀))` turns a reading into the field.
#[derive(Clone, Debug, PartialEq)]
pub struct MagnetometerErrors {
    /// Correction of soft iron `C = A⁻¹`, aligned to gyroscope and accelerometer; not symmetric.
    pub soft_iron: DMat3,
    /// Hard iron `b₀`, µT.
    pub hard_iron_ut: DVec3,
    /// Its slope `b₁`, µT/K; `None` if the temperature did not vary enough.
    pub hard_iron_slope_ut_k: Option<DVec3>,
    /// Covariance of `C` row by row (9), `b₀` (3, µT) and, where it is there, `b₁` (3, µT/K):
    /// 12 or 15 rows of as many columns.
    pub covariance: Vec<Vec<f64>>,
    /// Expected heading error over the tilts seen and all headings, root mean square, 1σ, degrees.
    pub heading_sigma_deg: f64,
    /// The same for a level camera, degrees.
    pub level_heading_sigma_deg: f64,
    /// Root mean square of what the fit leaves of one reading, per axis, µT.
    pub residual_ut: f64,
    /// The field at the place, as found.
    pub field: FieldFound,
}

/// The earth's field, as found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldFound {
    /// Strength, µT. Without a prior its scale is that of the readings.
    pub strength_ut: f64,
    /// 1σ, µT.
    pub strength_sigma_ut: f64,
    /// Dip, degrees, positive downward.
    pub dip_deg: f64,
    /// 1σ, degrees.
    pub dip_sigma_deg: f64,
}

/// The gyroscope's model: rate = reading − bias − slope (T − T₀).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GyroErrors {
    /// Bias at T₀, rad/s.
    pub bias_rad_s: DVec3,
    /// 1σ, rad/s.
    pub bias_sigma_rad_s: DVec3,
    /// Slope, rad/s/K; `None` if the temperature did not vary enough.
    pub bias_slope_rad_s_k: Option<DVec3>,
}

/// The accelerometer's model: specific force = reading − bias.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelerometerErrors {
    /// Bias, m/s²; near zero along a direction that the movement does not show.
    pub bias_m_s2: DVec3,
    /// 1σ, m/s²; that of the prior along a direction that the movement does not show.
    pub bias_sigma_m_s2: DVec3,
}

/// Temperatures of a recording, °C.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TemperatureSpan {
    /// Lowest.
    pub min_c: f64,
    /// Highest.
    pub max_c: f64,
    /// The mean: the reference T₀ of every slope.
    pub reference_c: f64,
}
