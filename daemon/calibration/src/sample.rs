//! What goes in.

use glam::DVec3;

/// One reading of the sensor unit, raw, in sensor axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time of the sample on the sensor's clock, ns. Samples that are not later than the one
    /// before are left out.
    pub time_ns: i64,
    /// Angular rate, rad/s: a point sample, or the mean over the interval that ends here; the fit
    /// finds out which by the delay of the other sensors.
    pub gyro_rad_s: DVec3,
    /// Specific force, m/s²; about +9.81 upward at rest.
    pub accel_m_s2: DVec3,
    /// Magnetic field, µT; `None` without a new reading.
    pub mag_ut: Option<DVec3>,
    /// Temperature of the sensor, °C; `None` if not known.
    pub temperature_c: Option<f64>,
}

impl Sample {
    /// Whether every value is a finite number.
    pub fn is_finite(&self) -> bool {
        self.gyro_rad_s.is_finite()
            && self.accel_m_s2.is_finite()
            && self.mag_ut.is_none_or(DVec3::is_finite)
            && self.temperature_c.is_none_or(f64::is_finite)
    }
}
