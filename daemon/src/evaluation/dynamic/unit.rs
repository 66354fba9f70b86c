//! One unit of the camera: its biases at switch-on, and what a calibration finds of them.

use lodestone_calibration::{Sample, calibrate};
use lodestone_config::Calibration;
use lodestone_config::model::{Synthetic, TrajectoryKind};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::commands::calibrate::{calibration_of, sample, settings_of};
use crate::evaluation::place::Place;
use crate::evaluation::recording::{Purpose, RecordingError, record};
use crate::reading::Reading;
use crate::service::signals::StopFlag;

/// Length of the recording that a unit is calibrated from, s.
const TURNED_S: f64 = 80.0;

/// A unit that goes through all scenes of one run.
#[derive(Clone, Debug)]
pub struct Unit {
    number: u32,
    gyro_bias_rad_s: [f64; 3],
    accel_bias_m_s2: [f64; 3],
    /// From a recording of its own; or why there is none.
    pub calibration: Result<Calibration, String>,
}

impl Unit {
    /// Draws the n-th unit of an evaluation from the camera's noise figures and calibrates it: turned
    /// through all attitudes by hand, as `lodestoned calibrate` asks for.
    ///
    /// # Errors
    /// If the synthetic world cannot be made, or somebody asked to stop.
    pub fn drawn(
        scene: &Place,
        (seed, number): (u64, u32),
        stop: &StopFlag,
    ) -> Result<Self, RecordingError> {
        let noise = scene.camera.noise.unwrap_or_else(|| scene.camera.model.noise());
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(u64::from(number));
        let mut bias = |sigma: f64| {
            std::array::from_fn(|_| {
                let normal: f64 = StandardNormal.sample(&mut rng);
                sigma * normal
            })
        };
        let mut unit = Self {
            number,
            gyro_bias_rad_s: bias(noise.gyro_bias_sigma_rad_s),
            accel_bias_m_s2: bias(noise.accel_bias_sigma_m_s2),
            calibration: Err("not tried".into()),
        };
        unit.calibration = unit.calibrated(scene, seed, stop)?;
        Ok(unit)
    }

    /// A unit with these biases in sensor axes, rad/s and m/s², and without a calibration.
    #[cfg(test)]
    pub(super) fn with_biases(number: u32, gyro: [f64; 3], accel: [f64; 3]) -> Self {
        let calibration = Err("not calibrated".into());
        Self { number, gyro_bias_rad_s: gyro, accel_bias_m_s2: accel, calibration }
    }

    /// Which run of each scene it goes through.
    pub const fn number(&self) -> u32 {
        self.number
    }

    /// Gives a simulated camera this unit's biases.
    pub const fn equip(&self, synthetic: &mut Synthetic) {
        synthetic.errors.gyro_bias_rad_s = Some(self.gyro_bias_rad_s);
        synthetic.errors.accel_bias_m_s2 = Some(self.accel_bias_m_s2);
    }

    /// What `lodestoned calibrate` makes of a recording: it sees samples, the camera's noise figures
    /// and the place, nothing of the truth.
    fn calibrated(
        &self,
        scene: &Place,
        seed: u64,
        stop: &StopFlag,
    ) -> Result<Result<Calibration, String>, RecordingError> {
        let mut readings: Vec<Reading> = Vec::new();
        let turned = |synthetic: &mut Synthetic| {
            synthetic.trajectory = TrajectoryKind::Tumble;
            synthetic.duration_s = TURNED_S;
            self.equip(synthetic);
        };
        record(scene, (Purpose::Unit(self.number), seed), turned, &mut readings, stop)?;
        let samples: Vec<Sample> = readings.iter().map(sample).collect();
        let outcome = calibrate(&samples, &settings_of(&scene.camera, Some(&scene.world)));
        let calibration =
            outcome.map(|outcome| calibration_of(scene.camera.serial, None, &outcome));
        Ok(calibration.map_err(|refusal| refusal.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::place::dynamic_scenes;
    use glam::DVec3;

    #[test]
    fn a_unit_is_calibrated_to_a_part_of_its_biases() {
        let scene = &dynamic_scenes().unwrap()[0];
        let unit = Unit::drawn(scene, (1, 0), &StopFlag::new()).unwrap();
        let found = unit.calibration.as_ref().unwrap().accelerometer.as_ref().unwrap().bias_m_s2;
        let bias = DVec3::from_array(unit.accel_bias_m_s2);
        let left = DVec3::from_array(found).distance(bias);
        assert!(left < 0.6 * bias.length(), "{left} m/s² left of {bias}");
        let again = Unit::drawn(scene, (1, 0), &StopFlag::new()).unwrap();
        let bits = |unit: &Unit| unit.accel_bias_m_s2.map(f64::to_bits);
        assert_eq!(bits(&unit), bits(&again));
        let found = |unit: &Unit| unit.calibration.as_ref().unwrap().magnetometer.clone();
        assert_eq!(found(&unit), found(&again));
        let other = Unit::drawn(scene, (1, 1), &StopFlag::new()).unwrap();
        assert_ne!(bits(&unit), bits(&other));
    }
}
