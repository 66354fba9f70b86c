//! What may be chosen about the estimator.

use glam::DVec3;

mod aiding;
mod alignment;
mod compass;
mod hard_iron;
mod levelling;
mod noise;
mod rest;
mod stance;
mod vehicle;

pub use aiding::AidingParameters;
pub use alignment::AlignmentParameters;
pub use compass::{CompassParameters, HeadingMode};
pub use hard_iron::HardIronParameters;
pub use levelling::LevellingParameters;
pub use noise::SensorNoise;
pub use rest::{RestParameters, Stillness};
pub use stance::StanceParameters;
pub use vehicle::VehicleParameters;

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
