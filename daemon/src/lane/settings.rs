//! What a lane needs of the configuration, in the estimator's terms.

use std::time::Duration;

use glam::{DMat3, DVec3};
use lodestone_config::Calibration;
use lodestone_config::model::{
    Camera, Config, Estimator, HeadingMode as Mode, Noise, North, Preset, ValidityBounds,
};
use lodestone_fusion::{
    AlignmentParameters, CompassParameters, FieldReference, GridParameters, HeadingMode, LowPass,
    Parameters, SensorNoise, SensorSpan,
};
use lodestone_schema::DistanceSource;

use super::Conditioner;
use super::vehicle::{antenna_of, vehicle_of};
use crate::driver::synthetic::{EarthField, FieldError};
use crate::world::{MemberSettings, Place};

/// Why a lane cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum SettingsError {
    /// The earth's field at the place is not known.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The samples are too far apart for the low-pass.
    #[error(
        "camera.low_pass_hz: {cut_off_hz} Hz cannot be told from lower frequencies at {rate_hz} samples/s; allowed: below {:.1} Hz",
        0.45 * .rate_hz
    )]
    LowPass {
        /// The configured cut-off, Hz.
        cut_off_hz: f64,
        /// The source's rate, Hz.
        rate_hz: f64,
    },
}

/// How a lane reacts to silence and gaps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Silence after which a pose is marked stale.
    pub stale_after: Duration,
    /// Gap after which the filter starts anew.
    pub reset_after: SensorSpan,
}

/// Everything one lane is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct LaneSettings {
    /// Index of the camera in the configuration.
    pub camera_id: u32,
    /// Name of the camera.
    pub camera: String,
    /// Sensor axes and calibration.
    pub conditioner: Conditioner,
    /// The time grid.
    pub grid: GridParameters,
    /// A low-pass on the inertial samples, if one is configured.
    pub low_pass: Option<LowPass>,
    /// The filter; it makes up for the low-pass's delay.
    pub estimator: Parameters,
    /// When values are called valid.
    pub validity: ValidityBounds,
    /// Silence and gaps.
    pub timing: Timing,
    /// What the lane knows of its place in the world.
    pub member: MemberSettings,
    /// The earth's field at the configured place and date, where the World Magnetic Model covers it.
    pub earth: Option<FieldReference>,
    /// Where position fixes of a recording hold, from the camera's origin in its own axes, m.
    pub antenna_m: DVec3,
}

impl LaneSettings {
    /// The settings of one camera whose source delivers samples at a nominal rate.
    ///
    /// # Errors
    /// [`SettingsError`] where true north is asked for and the World Magnetic Model does not cover the
    /// place or the date, and where the low-pass does not go with the rate.
    pub fn new(
        config: &Config,
        camera_id: usize,
        camera: &Camera,
        calibration: Option<&Calibration>,
        nominal_rate_hz: f64,
    ) -> Result<Self, SettingsError> {
        let lane = &config.lane;
        let step_rate_hz = lane.step_rate_hz.unwrap_or(nominal_rate_hz);
        let earth = EarthField::of(&config.world);
        let true_north_rad = earth.as_ref().ok().map(|field| field.true_north_rad);
        let reference = earth.as_ref().ok().map(|field| FieldReference::of(field.world_ut));
        let field_bearing_rad = match config.world.north {
            // A magnetic north needs no model.
            North::Magnetic => 0.0,
            North::True => earth?.declination_rad,
        };
        let earth_rate_rad_s = earth_rate(config.world.latitude_deg, true_north_rad);
        let low_pass = low_pass_of(camera, nominal_rate_hz)?;
        let group_delay_s = low_pass.map_or(0.0, |filter| filter.group_delay_s());
        let parameters = parameters_of(config, camera, calibration);
        Ok(Self {
            camera_id: camera_id as u32,
            camera: camera.name.clone(),
            conditioner: Conditioner::new(camera.axes(), calibration),
            grid: GridParameters {
                sample_interval: SensorSpan::from_secs_f64(1.0 / nominal_rate_hz),
                bridge_limit: SensorSpan::from_secs_f64(lane.bridge_limit_s),
                ..GridParameters::at_rate(step_rate_hz)
            },
            estimator: Parameters {
                field_bearing_rad,
                earth_rate_rad_s,
                lead_s: camera.imu_delay_s + group_delay_s - 0.5 / nominal_rate_hz,
                compass: CompassParameters {
                    // What the low-pass delays, it delays against the magnetometer as well.
                    delay_s: -group_delay_s,
                    ..parameters.compass
                },
                ..parameters
            },
            low_pass,
            validity: config.estimator.validity,
            earth: reference,
            antenna_m: antenna_of(config, camera),
            member: member_of(config, camera),
            timing: Timing {
                stale_after: Duration::from_secs_f64(lane.stale_after_s),
                reset_after: SensorSpan::from_secs_f64(lane.reset_after_s),
            },
        })
    }
}

/// The low-pass of a camera, if one is configured.
///
/// # Errors
/// [`SettingsError::LowPass`].
pub fn low_pass_of(camera: &Camera, rate_hz: f64) -> Result<Option<LowPass>, SettingsError> {
    let made = |cut_off_hz| {
        LowPass::new(cut_off_hz, rate_hz).ok_or(SettingsError::LowPass { cut_off_hz, rate_hz })
    };
    camera.low_pass_hz.map(made).transpose()
}

fn member_of(config: &Config, camera: &Camera) -> MemberSettings {
    let start = camera.start.map(|start| Place {
        position: start.position_m.into(),
        covariance: DMat3::from_diagonal(DVec3::splat(start.sigma_m * start.sigma_m)),
        source: DistanceSource::CommonStart,
    });
    MemberSettings {
        origin_in_body_m: camera.magnetometer_position_m.into(),
        start,
        kept: None,
        unseen_speed_m_s: config.world.unseen_speed_m_s,
        alignment_rest_s: config.estimator.alignment_rest_s,
    }
}

/// How fast the earth turns against the stars, rad/s.
const EARTH_RATE_RAD_S: f64 = 7.292_115e-5;

/// The earth's rate in W at a latitude, rad/s (Groves, eq. 2.123). True north lies anticlockwise of W's
/// y axis by an angle, rad; where that is not known, what the earth turns about north is left out.
fn earth_rate(latitude_deg: f64, true_north_rad: Option<f64>) -> DVec3 {
    let (up, horizontal) = latitude_deg.to_radians().sin_cos();
    let north = true_north_rad.map_or(DVec3::ZERO, |angle| {
        let (sin, cos) = angle.sin_cos();
        DVec3::new(-sin, cos, 0.0) * horizontal
    });
    (north + DVec3::Z * up) * EARTH_RATE_RAD_S
}

/// What even a good calibration leaves, rad: half a degree, by currents, temperature and age, which its own
/// figure does not know.
const LEAST_SYSTEMATIC_RAD: f64 = 8.7e-3;

fn parameters_of(
    config: &Config,
    camera: &Camera,
    calibration: Option<&Calibration>,
) -> Parameters {
    let (defaults, usual_noise) = match config.estimator.preset {
        Preset::Carried => (Parameters::default(), Some(camera.model.noise())),
        Preset::Foot => (Parameters::foot_mounted(), None),
    };
    let left_by_calibration = calibration
        .and_then(|c| c.magnetometer.as_ref()?.heading_sigma_deg)
        .map_or(defaults.compass.systematic_sigma_rad, |deg| {
            deg.to_radians().max(LEAST_SYSTEMATIC_RAD)
        });
    Parameters {
        compass: CompassParameters {
            systematic_sigma_rad: left_by_calibration,
            ..defaults.compass
        },
        noise: camera
            .noise
            .or(usual_noise)
            .map_or(defaults.noise, |noise| noise_of(noise, defaults.noise)),
        heading: match config.estimator.heading {
            Mode::Continuous => HeadingMode::Continuous,
            Mode::Adaptive => HeadingMode::Adaptive,
            Mode::InitialOnly => HeadingMode::InitialOnly,
        },
        alignment: alignment_of(&config.estimator, defaults.alignment),
        hard_iron: lodestone_fusion::HardIronParameters {
            enabled: config.estimator.hard_iron_refinement,
            ..defaults.hard_iron
        },
        vehicle: vehicle_of(config, camera),
        ..defaults
    }
}

/// A foot does not rest as long as a configuration may ask for.
fn alignment_of(estimator: &Estimator, defaults: AlignmentParameters) -> AlignmentParameters {
    match estimator.preset {
        Preset::Foot => defaults,
        Preset::Carried => AlignmentParameters {
            rest_s: estimator.alignment_rest_s,
            motion_s: Some(estimator.alignment_motion_s).filter(|s| *s > 0.0),
            ..defaults
        },
    }
}

/// What the configuration does not name stays as the estimator has it.
const fn noise_of(noise: Noise, rest: SensorNoise) -> SensorNoise {
    SensorNoise {
        gyro_density: noise.gyro_density_rad_s_rthz,
        gyro_bias_walk: noise.gyro_bias_walk_rad_s2_rthz,
        gyro_bias_sigma: noise.gyro_bias_sigma_rad_s,
        accel_density: noise.accel_density_m_s2_rthz,
        accel_bias_walk: noise.accel_bias_walk_m_s3_rthz,
        accel_bias_sigma: noise.accel_bias_sigma_m_s2,
        mag_sigma_ut: noise.mag_sigma_ut,
        ..rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_earth_turns_about_true_north() {
        let at = |true_north_rad| earth_rate(48.0, true_north_rad);
        assert!((at(Some(0.0)).length() - EARTH_RATE_RAD_S).abs() < 1e-15);
        assert!(at(Some(0.0)).x.abs() < 1e-20);
        // Where W's y axis is a magnetic north that lies east of the true one, the true one lies west.
        assert!(at(Some(0.07)).x < 0.0);
        assert!((at(Some(0.07)).length() - EARTH_RATE_RAD_S).abs() < 1e-15);
        // No north, no turn about it.
        assert_eq!(at(None), DVec3::Z * at(Some(0.0)).z);
    }

    #[test]
    fn a_foot_has_parameters_of_its_own_but_a_cameras_noise_counts() {
        let mut config = Config::default();
        let parameters = |config: &Config, camera: &Camera| parameters_of(config, camera, None);
        let mut camera = Camera::default();
        assert_eq!(parameters(&config, &camera).stance, None);
        config.estimator.preset = Preset::Foot;
        config.estimator.alignment_rest_s = 3.0;
        let foot = Parameters::foot_mounted();
        let got = parameters(&config, &camera);
        assert_eq!((got.stance, got.noise), (foot.stance, foot.noise));
        assert_eq!(got.alignment, foot.alignment);
        camera.noise = Some(Noise { gyro_density_rad_s_rthz: 0.01, ..camera.model.noise() });
        let got = parameters(&config, &camera).noise;
        assert_eq!(got.gyro_density.to_bits(), 0.01_f64.to_bits());
        assert_eq!(got.gyro_aliasing.to_bits(), foot.noise.gyro_aliasing.to_bits());
    }

    #[test]
    fn a_lane_knows_how_the_earth_turns_at_the_configured_place() {
        let mut config = Config::default();
        config.world.year = Some(2026.0);
        let rate = |config: &Config| {
            let camera = Camera::default();
            LaneSettings::new(config, 0, &camera, None, 400.0).unwrap().estimator.earth_rate_rad_s
        };
        let magnetic = rate(&config);
        assert!((magnetic.length() - EARTH_RATE_RAD_S).abs() < 1e-15);
        config.world.north = North::True;
        assert!(
            rate(&config).x.abs() < 1e-20 && magnetic.x < 0.0,
            "the declination there is 4° east"
        );
    }
}
