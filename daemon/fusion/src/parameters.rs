//! What may be chosen about the estimator.

use glam::DVec3;

use crate::frame::{Body, Rotation, Vehicle};

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

/// Parameters of the estimator; the defaults serve every camera and every motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Noise of the sensors.
    pub noise: SensorNoise,
    /// How the magnetometer steers the heading.
    pub heading: HeadingMode,
    /// Angle from the world's north (its y axis) to the horizontal field, east positive, rad: 0 where
    /// the world's north is magnetic, the declination where it is true.
    pub field_bearing_rad: f64,
    /// How far a pose is carried beyond the last sample at its rate and force, s: the age of what a
    /// sample shows, less half its interval, which integrating it over the interval accounts for.
    /// Default 0; negative where samples show the instant of their stamp.
    pub lead_s: f64,
    /// How much older what the gyroscope shows is than what the accelerometer shows, s; two steps at most.
    /// Default 0.
    pub gyro_lag_s: f64,
    /// Strength of gravity at the place, m/s².
    pub gravity_m_s2: f64,
    /// The earth's rate in the world, rad/s. Default 0, an earth that does not turn.
    pub earth_rate_rad_s: DVec3,
    /// Alignment.
    pub alignment: AlignmentParameters,
    /// Detection of standstill: zero velocity and zero rate.
    pub rest: RestParameters,
    /// Detection of a foot's stances, which are shorter and less still: zero velocity alone. None for
    /// what is not mounted on a foot.
    pub stance: Option<StanceParameters>,
    /// Levelling by gravity.
    pub levelling: LevellingParameters,
    /// Heading by the magnetometer.
    pub compass: CompassParameters,
    /// Refinement of the hard iron while running.
    pub hard_iron: HardIronParameters,
    /// Measurements by others.
    pub aiding: AidingParameters,
    /// The vehicle that carries the camera, if one does.
    pub vehicle: Option<VehicleParameters>,
}

/// Measurements by others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AidingParameters {
    /// How long a source must be refused without pause before it is believed after all, s. Short gives in
    /// to outliers, long stays wrong longer. Default 5.
    pub patience_s: f64,
}

/// A road vehicle that carries the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VehicleParameters {
    /// The camera's attitude on the vehicle.
    pub vehicle_from_body: Rotation<Vehicle, Body>,
    /// From the camera's body origin to the vehicle's, in the body, m. The vehicle's origin is in the
    /// middle of the axle that does not steer.
    pub origin_m: DVec3,
    /// How well that is known, 1σ, m. Default 0.05.
    pub origin_sigma_m: f64,
    /// How well the camera's pitch and yaw on the vehicle are known, 1σ, rad. Default 1°.
    pub mounting_sigma_rad: f64,
    /// Whether the vehicle moves neither sideways nor up and down. Default true.
    pub non_holonomic: bool,
    /// Sideways velocity of a vehicle that drives straight on, 1σ, m/s. Default 0.05.
    pub sideways_sigma_m_s: f64,
    /// Upward velocity against the vehicle's own floor at low speed, 1σ, m/s. Default 0.1.
    pub upward_sigma_m_s: f64,
    /// Slip angle of the tyres for each m/s² of sideways acceleration, 1σ, rad. Default 6 mrad, that of
    /// a passenger car.
    pub slip_rad_per_m_s2: f64,
    /// Pitch of the body on its springs at constant speed, 1σ, rad. Default 4 mrad.
    pub sway_rad: f64,
    /// Pitch of the body for each m/s² of throttle or braking, 1σ, rad. Default 6 mrad, that of a
    /// passenger car.
    pub sway_rad_per_m_s2: f64,
    /// Time over which the pitch on the springs hangs together, s: that of a braking. Default 3.
    pub sway_correlation_s: f64,
    /// Turn rate beyond which it may skid, rad/s. Default 1.5.
    pub max_turn_rad_s: f64,
    /// Seconds between two uses of the constraint. Default 0.1.
    pub constraint_interval_s: f64,
    /// Time over which its errors hang together, s. Default 0.5.
    pub constraint_correlation_s: f64,
    /// Scale error of the speed, 1σ, a part of one. Default 1 %.
    pub speed_scale_sigma: f64,
    /// Noise of a speed that does not say its own, 1σ, m/s. Default 0.1.
    pub speed_sigma_m_s: f64,
    /// Least noise that a speed is believed to have, 1σ, m/s. Default 0.02.
    pub speed_floor_m_s: f64,
    /// Time over which errors of the speed hang together, s. Default 0.1.
    pub speed_correlation_s: f64,
}

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

/// Scatter of the sensors without motion: the unit in which a window's statistic measures it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stillness {
    /// Angular rate about the bias, 1σ, rad/s, per axis and step. Default 0.02; a foot's stance 0.11.
    pub rate_sigma_rad_s: f64,
    /// Specific force about gravity, 1σ, m/s², per axis and step. Default 0.15; a foot's stance 0.5.
    pub force_sigma_m_s2: f64,
}

/// Detection of standstill over a sliding window, and what a standstill is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestParameters {
    /// Length of the window, s; a tenth of it lies between two decisions. Short reacts fast, long is
    /// rarely fooled by slow motion. Default 0.5.
    pub window_s: f64,
    /// How still a standing camera is.
    pub stillness: Stillness,
    /// Largest statistic of a standing camera. Small misses standstills on a running engine, large
    /// stops a slow camera. Default 1.
    pub threshold: f64,
    /// Largest mean angular rate after the bias estimate, rad/s. A steady turn below it is taken for
    /// bias; a bias that changes by more in motion delays the next standstill. Default 0.004.
    pub mean_rate_rad_s: f64,
    /// Velocity noise of a zero-velocity update, 1σ, m/s. Default 0.01.
    pub velocity_sigma_m_s: f64,
    /// Least noise of a zero-rate update, 1σ, rad/s. Default 2e-4.
    pub turn_sigma_rad_s: f64,
}

/// Detection of a foot's stance, for a sensor that is mounted on it.
///
/// A stance lasts some tenths of a second, and in it the foot rolls on. How still it gets depends on the
/// gait, so a threshold alone fits one gait: what a stance is worth falls with its statistic T,
/// `σ² = σ₀² (1 + (T / T₀)²)`, and the threshold only keeps out what cannot be one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StanceParameters {
    /// Length of the window, s. Short finds short stances, long is rarely fooled by a slow swing.
    /// Default 0.05.
    pub window_s: f64,
    /// How still a foot is that stands.
    pub stillness: Stillness,
    /// Largest statistic of a stance. Small loses those of a fast gait, and the position with them; large
    /// lets swings slow the foot down. Default 150.
    pub threshold: f64,
    /// Statistic T₀ from which a stance is worth less. Default 10.
    pub statistic_scale: f64,
    /// Velocity of the stillest stance, 1σ, m/s, per axis and update. Default 0.03.
    pub velocity_sigma_m_s: f64,
}

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

impl Parameters {
    /// Parameters for a sensor on a foot: position by zero velocity in each stance.
    ///
    /// A foot stands within a second or two, but for a tenth of a second only: that is what the alignment
    /// asks for, and a coarse alignment in motion would be the worse one.
    pub fn foot_mounted() -> Self {
        Self {
            noise: SensorNoise::FOOT_MOUNTED,
            gyro_lag_s: 0.003,
            alignment: AlignmentParameters {
                window_s: 0.08,
                rest_s: 0.1,
                max_bias_rad_s: 0.05,
                motion_s: None,
                ..AlignmentParameters::default()
            },
            rest: RestParameters::FOOT,
            stance: Some(StanceParameters::default()),
            ..Self::default()
        }
    }

    /// The earth's rate in the world, rad/s, as far as it is known: all of it with a north, else only
    /// its part about up.
    pub(crate) fn earth_rate_where(&self, north_is_known: bool) -> DVec3 {
        if north_is_known {
            self.earth_rate_rad_s
        } else {
            DVec3::new(0.0, 0.0, self.earth_rate_rad_s.z)
        }
    }
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

impl Default for Parameters {
    fn default() -> Self {
        Self {
            noise: SensorNoise::ZED2,
            heading: HeadingMode::Adaptive,
            field_bearing_rad: 0.0,
            lead_s: 0.0,
            gyro_lag_s: 0.0,
            gravity_m_s2: 9.81,
            earth_rate_rad_s: DVec3::ZERO,
            alignment: AlignmentParameters::default(),
            rest: RestParameters::default(),
            stance: None,
            levelling: LevellingParameters::default(),
            compass: CompassParameters::default(),
            hard_iron: HardIronParameters::default(),
            aiding: AidingParameters::default(),
            vehicle: None,
        }
    }
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

impl Default for RestParameters {
    fn default() -> Self {
        Self {
            window_s: 0.5,
            stillness: Stillness { rate_sigma_rad_s: 0.02, force_sigma_m_s2: 0.15 },
            threshold: 1.0,
            mean_rate_rad_s: 0.004,
            velocity_sigma_m_s: 0.01,
            turn_sigma_rad_s: 2e-4,
        }
    }
}

impl RestParameters {
    /// Time between two decisions, s.
    pub(crate) fn interval_s(&self) -> f64 {
        0.1 * self.window_s
    }

    /// How still a foot gets on which somebody stands, and how sure one may be then that it does not turn.
    const FOOT: Self = Self {
        window_s: 0.5,
        stillness: Stillness { rate_sigma_rad_s: 0.05, force_sigma_m_s2: 0.2 },
        threshold: 2.0,
        mean_rate_rad_s: 0.02,
        velocity_sigma_m_s: 0.01,
        turn_sigma_rad_s: 4.0e-3,
    };
}

impl Default for StanceParameters {
    fn default() -> Self {
        Self {
            window_s: 0.05,
            stillness: Stillness { rate_sigma_rad_s: 0.11, force_sigma_m_s2: 0.5 },
            threshold: 150.0,
            statistic_scale: 10.0,
            velocity_sigma_m_s: 0.03,
        }
    }
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

impl Default for AidingParameters {
    fn default() -> Self {
        Self { patience_s: 5.0 }
    }
}

impl VehicleParameters {
    /// A vehicle on which the camera sits like this.
    pub const fn mounted(vehicle_from_body: Rotation<Vehicle, Body>, origin_m: DVec3) -> Self {
        Self {
            vehicle_from_body,
            origin_m,
            origin_sigma_m: 0.05,
            mounting_sigma_rad: 0.0175,
            non_holonomic: true,
            sideways_sigma_m_s: 0.05,
            upward_sigma_m_s: 0.1,
            slip_rad_per_m_s2: 6e-3,
            sway_rad: 4e-3,
            sway_rad_per_m_s2: 6e-3,
            sway_correlation_s: 3.0,
            max_turn_rad_s: 1.5,
            constraint_interval_s: 0.1,
            constraint_correlation_s: 0.5,
            speed_scale_sigma: 0.01,
            speed_sigma_m_s: 0.1,
            speed_floor_m_s: 0.02,
            speed_correlation_s: 0.1,
        }
    }
}
