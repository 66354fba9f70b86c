//! Noise of one camera's sensors.

/// Noise of one camera's sensors, as the filter believes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorNoise {
    /// Gyroscope noise density, rad/s/√Hz.
    pub gyro_density: f64,
    /// Gyroscope bias random walk, rad/s²/√Hz.
    pub gyro_bias_walk: f64,
    /// Gyroscope bias at switch-on, 1σ, rad/s.
    pub gyro_bias_sigma: f64,
    /// Error that turning adds (scale factor, misalignment), 1σ after one radian, rad; grows with
    /// the root of the turned angle.
    pub gyro_scale_walk: f64,
    /// Accelerometer noise density, m/s²/√Hz.
    pub accel_density: f64,
    /// Part of the change of the angular rate from one step to the next that sampling misses, 1σ. Large
    /// where a sensor strikes the ground. Default 0.
    pub gyro_aliasing: f64,
    /// Part of the change of the specific force from one step to the next that sampling misses, 1σ.
    /// Default 0.
    pub accel_aliasing: f64,
    /// Accelerometer bias random walk, m/s³/√Hz.
    pub accel_bias_walk: f64,
    /// Accelerometer bias at switch-on, 1σ, m/s².
    pub accel_bias_sigma: f64,
    /// Noise of one magnetometer reading, 1σ, µT.
    pub mag_sigma_ut: f64,
}

impl SensorNoise {
    /// Figures of a ZED 2 at room temperature.
    pub const ZED2: Self = Self {
        gyro_density: 1.22e-4,
        gyro_bias_walk: 1.0e-5,
        gyro_bias_sigma: 5.0e-3,
        gyro_scale_walk: 7.0e-3,
        accel_density: 1.6e-3,
        gyro_aliasing: 0.0,
        accel_aliasing: 0.0,
        accel_bias_walk: 2.5e-4,
        accel_bias_sigma: 0.05,
        mag_sigma_ut: 0.5,
    };

    /// Figures of an industrial IMU on a foot, sampled at 100 Hz and more: its gyroscope is calibrated, its
    /// errors come from the strike of the heel, which is shorter than a step.
    pub const FOOT_MOUNTED: Self = Self {
        gyro_density: 7.0e-4,
        gyro_bias_sigma: 1.0e-3,
        gyro_scale_walk: 1.0e-3,
        gyro_aliasing: 0.2,
        accel_aliasing: 0.1,
        accel_bias_sigma: 0.025,
        ..Self::ZED2
    };
}
