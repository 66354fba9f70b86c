//! What a seed decides: which sensors the cameras have, and how the surveyor erred.

use lodestone_config::model::{Camera, Config, FaultKind};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// The cameras whose clouds are merged.
pub const CAMERAS: [&str; 2] = ["front", "rear"];

/// The same camera as it would report without its magnetometer.
pub fn without_magnetometer(camera: &str) -> String {
    format!("{camera}_gyro")
}

/// Whether a camera's magnetometer is silent.
pub fn is_silent(camera: &Camera) -> bool {
    camera.fault.iter().any(|fault| fault.kind == FaultKind::NoMagnetometer)
}

/// The demo's configuration with everything random drawn from a seed: noise, biases at switch-on and errors of
/// the survey, each from the figures that the configuration states for it.
///
/// Cameras with one seed in the configuration are one device, and stay one.
pub fn drawn(mut config: Config, seed: u64) -> Config {
    for camera in &mut config.camera {
        let Some(synthetic) = &mut camera.synthetic else { continue };
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(synthetic.seed);
        let noise = camera.noise.unwrap_or_else(|| camera.model.noise());
        synthetic.seed = rng.random::<u32>().into();
        synthetic.errors.gyro_bias_rad_s = Some(normal(&mut rng, noise.gyro_bias_sigma_rad_s));
        synthetic.errors.accel_bias_m_s2 = Some(normal(&mut rng, noise.accel_bias_sigma_m_s2));
        let survey = normal(&mut rng, 1.0);
        if let (Some(start), Some(truth)) = (&mut camera.start, synthetic.position_m) {
            let error = survey.map(|unit| unit * start.sigma_m);
            start.position_m = [0, 1, 2].map(|axis| truth[axis] + error[axis]);
        }
        if let Some(depth) = &mut camera.depth {
            depth.seed = rng.random::<u32>().into();
        }
    }
    config
}

fn normal(rng: &mut ChaCha8Rng, sigma: f64) -> [f64; 3] {
    [0; 3].map(|_| sigma * rng.sample::<f64, _>(StandardNormal))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera<'a>(config: &'a Config, name: &str) -> &'a Camera {
        config.camera.iter().find(|camera| camera.name == name).unwrap()
    }

    #[test]
    fn a_camera_and_its_twin_without_magnetometer_are_one_device() {
        let config = drawn(Config::demo(), 3);
        for name in CAMERAS {
            let (own, twin) = (camera(&config, name), camera(&config, &without_magnetometer(name)));
            assert!(!is_silent(own) && is_silent(twin));
            let synthetic = |camera: &Camera| {
                let synthetic = camera.synthetic.clone().unwrap();
                (synthetic.seed, synthetic.errors, synthetic.position_m, synthetic.heading_deg)
            };
            assert_eq!(synthetic(own), synthetic(twin), "{name}");
            let place = |camera: &Camera| camera.start.map(|start| start.position_m);
            assert!(place(own).is_none() || place(own) == place(twin), "{name}");
        }
    }

    #[test]
    fn seeds_differ_in_everything_random_and_the_survey_errs_as_it_says() {
        let mut squares = Vec::new();
        let mut seeds = std::collections::BTreeSet::new();
        for seed in 0..200 {
            let config = drawn(Config::demo(), seed);
            let rear = camera(&config, "rear");
            let (start, synthetic) = (rear.start.unwrap(), rear.synthetic.clone().unwrap());
            let truth = synthetic.position_m.unwrap();
            let error = |axis: usize| (start.position_m[axis] - truth[axis]) / start.sigma_m;
            squares.extend([0, 1, 2].map(|axis| error(axis).powi(2)));
            seeds.insert(synthetic.seed);
        }
        let mean = squares.iter().sum::<f64>() / squares.len() as f64;
        assert!((mean - 1.0).abs() < 0.25, "{mean}");
        assert_eq!(seeds.len(), 200);
    }
}
