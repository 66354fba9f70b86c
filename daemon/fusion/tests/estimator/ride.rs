//! A car in the city, the filter in it, and others who measure.

use glam::{DMat3, DVec3};
use lodestone_fusion::{
    Aid, AidReport, Estimate, Estimator, Measurement, POSITION, Parameters, SensorSpan, SensorTime,
    StepReport, VELOCITY, VehicleParameters,
};

use crate::city::{City, Mount};
use crate::simulation::{DT, steps};

/// 95 % of the means over ten rides lie within, of NEES per number (chi-square of 30).
pub(crate) const BAND: (f64, f64) = (0.56, 1.57);

/// A car and the filter in it.
#[derive(Clone)]
pub(crate) struct Ride {
    pub(crate) car: City,
    pub(crate) filter: Estimator,
    pub(crate) now: SensorTime,
    steps: usize,
    speed_scale: f64,
}

/// A camera behind the windscreen whose filter knows of the car.
pub(crate) fn in_vehicle() -> Parameters {
    Parameters { vehicle: Some(Mount::windscreen().parameters()), ..Parameters::default() }
}

/// The same with the car described differently.
pub(crate) fn in_vehicle_with(change: impl Fn(&mut VehicleParameters)) -> Parameters {
    let mut vehicle = Mount::windscreen().parameters();
    change(&mut vehicle);
    Parameters { vehicle: Some(vehicle), ..Parameters::default() }
}

impl Ride {
    pub(crate) fn new(seed: u64, p: Parameters) -> Self {
        Self {
            car: City::new(seed, p, Mount::windscreen()),
            filter: Estimator::new(p),
            now: SensorTime::from_nanos(0),
            steps: 0,
            speed_scale: 0.0,
        }
    }

    /// Draws how much too fast the speed reads, and how much the camera is turned against what the
    /// filter is told.
    pub(crate) fn misread(&mut self, speed_scale_sigma: f64, mounting_sigma_rad: f64) {
        self.speed_scale = self.car.number(speed_scale_sigma);
        let pitch = self.car.number(mounting_sigma_rad);
        let yaw = self.car.number(mounting_sigma_rad);
        self.car.turn_camera(DVec3::new(0.0, pitch, yaw));
    }

    pub(crate) fn step(&mut self) -> StepReport {
        let step = self.car.step();
        self.now = step.time;
        self.steps += 1;
        self.filter.step(&step)
    }

    /// Drives, with a speed measured so many times a second.
    pub(crate) fn drive(&mut self, seconds: f64, speed_rate_hz: f64, sigma_m_s: f64) {
        let every = (1.0 / (DT * speed_rate_hz)).round() as usize;
        for k in 0..steps(seconds) {
            self.step();
            if k % every == 0 {
                let true_m_s = self.car.speed * (1.0 + self.speed_scale);
                let speed_m_s = true_m_s + self.car.number(sigma_m_s);
                self.offer_speed(speed_m_s, sigma_m_s);
            }
        }
    }

    /// Drives without any aid.
    pub(crate) fn drive_unaided(&mut self, seconds: f64) {
        (0..steps(seconds)).for_each(|_| {
            self.step();
        });
    }

    pub(crate) fn offer_speed(&mut self, speed_m_s: f64, sigma_m_s: f64) -> AidReport {
        let sigma_m_s = Some(sigma_m_s);
        self.offer(Measurement::Speed { speed_m_s, sigma_m_s }, 0.0)
    }

    pub(crate) fn offer_position(
        &mut self,
        position_m: DVec3,
        sigma_m: f64,
        age_s: f64,
    ) -> AidReport {
        let covariance = DMat3::IDENTITY * (sigma_m * sigma_m);
        self.offer(Measurement::Position { position_m, covariance, lever_m: DVec3::ZERO }, age_s)
    }

    pub(crate) fn offer(&mut self, measurement: Measurement, age_s: f64) -> AidReport {
        let age = SensorSpan::from_nanos(-(age_s * 1e9).round() as i64);
        self.filter.aid(&Aid { time: self.now + age, measurement, anchor: None })
    }

    pub(crate) fn estimate(&self) -> Estimate {
        self.filter.estimate().expect("aligned")
    }

    pub(crate) fn position_error(&self) -> DVec3 {
        self.car.position - self.filter.state().expect("aligned").position
    }

    /// NEES per number of position and velocity.
    pub(crate) fn nees(&self) -> [f64; 2] {
        let state = self.filter.state().expect("aligned");
        let score = |error: DVec3, p: DMat3| error.dot(p.inverse() * error) / 3.0;
        [
            score(self.position_error(), state.covariance.block(POSITION, POSITION)),
            score(self.car.velocity - state.velocity, state.covariance.block(VELOCITY, VELOCITY)),
        ]
    }
}

pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) }
}

pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
