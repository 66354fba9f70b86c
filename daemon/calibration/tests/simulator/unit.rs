//! The sensors and what is wrong with them.

use glam::{DMat3, DQuat, DVec3};
use lodestone_calibration::Sample;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::{Motion, Scene};

const DIP_DEG: f64 = 67.0;
const GRAVITY: f64 = 9.81;

/// Errors of one unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Imperfect {
    /// Soft iron.
    pub soft_iron: DMat3,
    /// Hard iron, µT.
    pub hard_iron: DVec3,
    /// Its slope, µT/K.
    pub hard_slope: DVec3,
    /// Bias, rad/s.
    pub gyro_bias: DVec3,
    /// Its slope, rad/s/K.
    pub gyro_slope: DVec3,
    /// Bias, m/s².
    pub accel_bias: DVec3,
}

/// One sensor unit at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// The field in W, µT.
    pub field: DVec3,
    /// What is wrong.
    pub errors: Imperfect,
    /// Degrees above 20 °C per minute, if it has a thermometer.
    pub warming_k_min: Option<f64>,
    /// A field of the world that is added for a while: from, to, s, and what, µT.
    pub disturbance: Option<(f64, f64, DVec3)>,
}

fn uniform(rng: &mut ChaCha8Rng, limit: f64) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| rng.random_range(-limit..limit)))
}

impl Unit {
    /// Soft iron ±10 % and ±5 %, hard iron ±30 µT, gyro ±1 °/s, accelerometer ±0.3 m/s²; field 50 ± 1 µT.
    pub fn drawn(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x5eed);
        let mut soft_iron = DMat3::from_cols(
            uniform(&mut rng, 0.05),
            uniform(&mut rng, 0.05),
            uniform(&mut rng, 0.05),
        );
        for i in 0..3 {
            soft_iron.col_mut(i)[i] = 1.0 + rng.random_range(-0.1..0.1);
        }
        let strength = 50.0 + rng.random_range(-1.0..1.0);
        let dip = DIP_DEG.to_radians();
        Self {
            field: DVec3::new(0.0, strength * dip.cos(), -strength * dip.sin()),
            errors: Imperfect {
                soft_iron,
                hard_iron: uniform(&mut rng, 30.0),
                hard_slope: DVec3::ZERO,
                gyro_bias: uniform(&mut rng, 1.0_f64.to_radians()),
                gyro_slope: DVec3::ZERO,
                accel_bias: uniform(&mut rng, 0.3),
            },
            warming_k_min: None,
            disturbance: None,
        }
    }

    /// What the magnetometer reads without noise.
    pub fn field_reading(&self, attitude: DQuat) -> DVec3 {
        self.errors.soft_iron * (attitude.inverse() * self.field) + self.errors.hard_iron
    }
}

/// Every sample of a movement.
pub fn record(scene: &Scene, unit: &Unit, motion: &Motion, seed: u64) -> Vec<Sample> {
    let mut noise = Noise::new(scene, seed);
    let count = (scene.duration_s * scene.rate_hz) as usize;
    (0..count)
        .map(|k| {
            let time_s = k as f64 / scene.rate_hz;
            sample(scene, unit, motion, &mut noise, (k, time_s))
        })
        .collect()
}

fn sample(
    scene: &Scene,
    unit: &Unit,
    motion: &Motion,
    noise: &mut Noise,
    (k, t): (usize, f64),
) -> Sample {
    let e = &unit.errors;
    let warmer = unit.warming_k_min.map_or(0.0, |rate| rate * t / 60.0);
    let attitude = motion.attitude(t);
    let rate = if scene.mean_rate {
        rate_between(motion, t - scene.rate_hz.recip(), t)
    } else {
        rate_between(motion, t - 1e-4, t + 1e-4)
    };
    let up = attitude.inverse() * DVec3::new(0.0, 0.0, GRAVITY);
    let has_mag = k.is_multiple_of(scene.mag_every);
    let added = unit.disturbance.filter(|(from, to, _)| (*from..*to).contains(&t));
    let added = added.map_or(DVec3::ZERO, |(_, _, field)| attitude.inverse() * field);
    let clean = unit.field_reading(attitude) + e.soft_iron * added + e.hard_slope * warmer;
    Sample {
        time_ns: 5_000_000_000 + (t * 1e9).round() as i64,
        gyro_rad_s: rate + e.gyro_bias + e.gyro_slope * warmer + noise.gyro(),
        accel_m_s2: up + e.accel_bias + noise.accel(),
        mag_ut: has_mag.then(|| clean + noise.white(scene.mag_sigma_ut)),
        temperature_c: unit.warming_k_min.map(|_| 20.0 + warmer),
    }
}

/// Mean rate in the sensor's axes, rad/s.
fn rate_between(motion: &Motion, from_s: f64, to_s: f64) -> DVec3 {
    let turn = motion.attitude(from_s).inverse() * motion.attitude(to_s);
    turn.to_scaled_axis() / (to_s - from_s)
}

/// Noise of a ZED 2: densities and the random walk of the gyroscope's bias.
struct Noise {
    rng: ChaCha8Rng,
    gyro_sigma: f64,
    walk_sigma: f64,
    accel_sigma: f64,
    walked: DVec3,
}

impl Noise {
    fn new(scene: &Scene, seed: u64) -> Self {
        let root_rate = scene.rate_hz.sqrt();
        Self {
            rng: ChaCha8Rng::seed_from_u64(seed ^ 0x0015_e000),
            gyro_sigma: 1.22e-4 * root_rate * scene.noise_scale,
            walk_sigma: 1.0e-5 / root_rate * scene.noise_scale,
            accel_sigma: 1.6e-3 * root_rate * scene.noise_scale,
            walked: DVec3::ZERO,
        }
    }

    fn white(&mut self, sigma: f64) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| {
            let unit: f64 = StandardNormal.sample(&mut self.rng);
            unit * sigma
        }))
    }

    fn gyro(&mut self) -> DVec3 {
        let step = self.white(self.walk_sigma);
        self.walked += step;
        self.walked + self.white(self.gyro_sigma)
    }

    fn accel(&mut self) -> DVec3 {
        self.white(self.accel_sigma)
    }
}
