//! What a rig needs of the configuration, in the estimator's terms.

use glam::{DMat3, DQuat, DVec3, EulerRot};
use lodestone_config::model::{Camera, Config, Mounting as Mounted, Rig, ValidityBounds};
use lodestone_config::{Calibration, LoadError, Loaded};
use lodestone_fusion::rig::{Geometry, GeometryError, GradientParameters, Mounting, RigParameters};
use lodestone_fusion::{
    FieldReference, GridParameters, LowPass, Parameters, Rotation, SensorNoise, VehicleParameters,
};

use crate::lane::{Conditioner, LaneSettings, SettingsError, Timing};
use crate::world::MemberSettings as Place;

/// Why a rig cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum RigError {
    /// Its members' places.
    #[error("body {0:?}: {1}")]
    Geometry(String, GeometryError),
    /// A member's lane.
    #[error(transparent)]
    Lane(#[from] SettingsError),
    /// A member's calibration cannot be used.
    #[error(transparent)]
    Calibration(#[from] LoadError),
}

/// One member of a rig.
#[derive(Clone, Debug, PartialEq)]
pub struct MemberSettings {
    /// Index of the camera in the configuration.
    pub camera_id: u32,
    /// Name of the camera.
    pub camera: String,
    /// Sensor axes and calibration.
    pub conditioner: Conditioner,
    /// The time grid, the same for all members but for the rate of samples.
    pub grid: GridParameters,
    /// What smooths its rates and forces.
    pub low_pass: Option<LowPass>,
    /// Where position fixes of its recording hold, from the camera's origin in its own axes, m.
    pub antenna_m: DVec3,
}

/// Everything a rig is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct RigSettings {
    /// What poses of the body carry for a camera's index: it goes on behind the cameras.
    pub body_id: u32,
    /// Name of the body.
    pub body: String,
    /// Its cameras.
    pub members: Vec<MemberSettings>,
    /// Where they sit.
    pub geometry: Geometry,
    /// The estimator.
    pub rig: RigParameters,
    /// When values are called valid.
    pub validity: ValidityBounds,
    /// Silence and gaps.
    pub timing: Timing,
    /// What the rig knows of its place in the world: what its first camera does, for the filter point.
    pub place: Place,
    /// The earth's field at the configured place and date, where the World Magnetic Model covers it.
    pub earth: Option<FieldReference>,
}

impl RigSettings {
    /// The settings of one rig whose members' sources deliver samples at nominal rates, Hz.
    ///
    /// # Errors
    /// [`RigError`].
    pub fn new(loaded: &Loaded, rig: &Rig, rates_hz: &[f64]) -> Result<Self, RigError> {
        let config = &loaded.config;
        let body = &config.body[rig.body];
        let lanes = member_lanes(loaded, rig, rates_hz)?;
        let mountings: Vec<Mounting> =
            rig.members.iter().map(|&index| mounting_of(&config.camera[index])).collect();
        let geometry =
            Geometry::new(&mountings).map_err(|e| RigError::Geometry(body.name.clone(), e))?;
        let first = &lanes[0];
        let (validity, timing, earth) = (first.validity, first.timing, first.earth);
        let place = place_of(first.member, &geometry);
        let vehicle = || VehicleParameters::mounted(Rotation::IDENTITY, -geometry.centroid_m());
        let estimator = Parameters { vehicle: body.vehicle.then(vehicle), ..common(&lanes) };
        let gradient = GradientParameters {
            mag_sigma_ut: estimator.noise.mag_sigma_ut,
            ..GradientParameters::default()
        };
        let rig_parameters = RigParameters {
            estimator,
            gradient: body.gradient.then_some(gradient),
            ..RigParameters::default()
        };
        Ok(Self {
            body_id: (config.camera.len() + rig.body) as u32,
            body: body.name.clone(),
            members: lanes.into_iter().map(MemberSettings::of).collect(),
            geometry,
            rig: rig_parameters,
            validity,
            timing,
            place,
            earth,
        })
    }
}

impl MemberSettings {
    fn of(lane: LaneSettings) -> Self {
        Self {
            camera_id: lane.camera_id,
            camera: lane.camera,
            conditioner: lane.conditioner,
            grid: lane.grid,
            low_pass: lane.low_pass,
            antenna_m: lane.antenna_m,
        }
    }
}

/// The settings that each member would have for itself, with the common grid.
fn member_lanes(
    loaded: &Loaded,
    rig: &Rig,
    rates_hz: &[f64],
) -> Result<Vec<LaneSettings>, RigError> {
    let config = &loaded.config;
    let fastest_hz = rates_hz.iter().copied().fold(0.0, f64::max);
    let step_rate_hz = config.lane.step_rate_hz.unwrap_or(fastest_hz);
    let lane = |(&index, &rate_hz): (&usize, &f64)| {
        let camera = &config.camera[index];
        let calibration: Option<Calibration> = loaded.calibration(camera)?;
        let settings = LaneSettings::new(config, index, camera, calibration.as_ref(), rate_hz)?;
        let step = GridParameters::at_rate(step_rate_hz).step;
        let grid = GridParameters { step, aligned: true, ..settings.grid };
        Ok(LaneSettings { grid, ..settings })
    };
    rig.members.iter().zip(rates_hz).map(lane).collect()
}

fn mounting_of(camera: &Camera) -> Mounting {
    let Mounted { position_m, roll_pitch_yaw_deg, .. } = camera.mounting;
    let [roll, pitch, yaw] = roll_pitch_yaw_deg.map(f64::to_radians);
    let turn = DQuat::from_euler(EulerRot::ZYX, yaw, pitch, roll);
    let imu_m = DVec3::from_array(position_m);
    Mounting {
        rotation: Rotation::from_yaw_pitch_roll(yaw, pitch, roll),
        imu_m,
        magnetometer_m: imu_m + turn * DVec3::from_array(camera.magnetometer_position_m),
    }
}

/// What a rig knows of its place, as its first camera does. A camera's place is the filter point's up to
/// its arm, whose direction in the world is not known before the alignment.
fn place_of(first: Place, geometry: &Geometry) -> Place {
    let arm = geometry.imu_arm_m(0);
    let loose = |place: crate::world::Place| {
        let covariance =
            place.covariance + DMat3::from_diagonal(DVec3::splat(arm.length_squared()));
        crate::world::Place { covariance, ..place }
    };
    Place {
        origin_in_body_m: geometry.magnetometer_arm_m(0),
        start: first.start.map(loose),
        kept: first.kept.map(loose),
        ..first
    }
}

impl RigSettings {
    /// The same with what was kept of the first camera's place.
    #[must_use]
    pub fn with_kept(self, kept: Option<crate::world::Place>) -> Self {
        let place = place_of(Place { kept, start: None, ..self.place }, &self.geometry);
        Self { place: Place { start: self.place.start, ..place }, ..self }
    }
}

/// One set of parameters for all members: their mean noise, their mean delay, the worst compass.
fn common(lanes: &[LaneSettings]) -> Parameters {
    let n = lanes.len() as f64;
    let mean = |of: fn(&Parameters) -> f64| lanes.iter().map(|l| of(&l.estimator)).sum::<f64>() / n;
    let mean_square = |of: fn(&SensorNoise) -> f64| {
        let squares = lanes.iter().map(|l| of(&l.estimator.noise).powi(2));
        (squares.sum::<f64>() / n).sqrt()
    };
    let worst = lanes.iter().map(|l| l.estimator.compass.systematic_sigma_rad).fold(0.0, f64::max);
    let first = lanes[0].estimator;
    Parameters {
        lead_s: mean(|p| p.lead_s),
        noise: SensorNoise {
            gyro_density: mean_square(|n| n.gyro_density),
            gyro_bias_walk: mean_square(|n| n.gyro_bias_walk),
            gyro_bias_sigma: mean_square(|n| n.gyro_bias_sigma),
            accel_density: mean_square(|n| n.accel_density),
            accel_bias_walk: mean_square(|n| n.accel_bias_walk),
            accel_bias_sigma: mean_square(|n| n.accel_bias_sigma),
            mag_sigma_ut: mean_square(|n| n.mag_sigma_ut),
            ..first.noise
        },
        compass: lodestone_fusion::CompassParameters {
            systematic_sigma_rad: worst,
            ..first.compass
        },
        ..first
    }
}

/// Whether a configuration's camera belongs to a rig.
pub fn is_member(config: &Config, camera: usize) -> bool {
    config.rigs().iter().any(|rig| rig.members.contains(&camera))
}
