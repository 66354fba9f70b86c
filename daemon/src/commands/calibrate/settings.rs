//! What the configuration knows of a camera and its place.

use glam::DVec3;
use lodestone_calibration::{FieldPrior, SensorNoise, Settings};
use lodestone_config::model::{Camera, DriverKind, World};

use crate::driver::synthetic::EarthField;

/// How far the field at the camera may be from the World Magnetic Model's, 1σ: buildings and the
/// vehicle's large parts, µT and degrees.
const STRENGTH_SIGMA_UT: f64 = 3.0;
const DIP_SIGMA_DEG: f64 = 5.0;

/// Noise and axes of a camera, and the field where the place is known.
pub(crate) fn of(camera: &Camera, world: Option<&World>) -> Settings {
    let noise = camera.noise.unwrap_or_else(|| camera.model.noise());
    let defaults = SensorNoise::default();
    // Nobody knows what made a recording, and how it stamped its sensors.
    let is_recorded = camera.driver == DriverKind::Replay;
    let delay_s = if is_recorded { defaults.imu_delay_s } else { camera.imu_delay_s };
    Settings {
        noise: SensorNoise {
            gyro_density_rad_s_rthz: noise.gyro_density_rad_s_rthz,
            gyro_bias_walk_rad_s2_rthz: noise.gyro_bias_walk_rad_s2_rthz,
            // What a calibration looks for is what the noise figures leave out: stay wide.
            gyro_bias_sigma_rad_s: noise.gyro_bias_sigma_rad_s.max(defaults.gyro_bias_sigma_rad_s),
            accel_density_m_s2_rthz: noise.accel_density_m_s2_rthz,
            accel_bias_sigma_m_s2: noise.accel_bias_sigma_m_s2.max(defaults.accel_bias_sigma_m_s2),
            mag_sigma_ut: noise.mag_sigma_ut,
            imu_delay_s: delay_s,
            ..defaults
        },
        field: world.and_then(field),
        level_up: Some(DVec3::from(camera.axes().directions()[2])),
        ..Settings::default()
    }
}

fn field(world: &World) -> Option<FieldPrior> {
    let field = EarthField::of(world).ok()?.world_ut;
    let horizontal = field.x.hypot(field.y);
    Some(FieldPrior {
        strength_ut: field.length(),
        strength_sigma_ut: STRENGTH_SIGMA_UT,
        dip_deg: (-field.z).atan2(horizontal).to_degrees(),
        dip_sigma_deg: DIP_SIGMA_DEG,
    })
}
