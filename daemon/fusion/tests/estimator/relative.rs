//! Two cameras, two filters: is the relative orientation as good as it says?

use glam::{DMat3, DVec3};
use lodestone_fusion::relative::{Relative, relative};
use lodestone_fusion::{Estimator, Parameters, so3};

use crate::simulation::{FIELD, Motion, Simulation, steps};

const SEEDS: u64 = 100;
/// What a calibration leaves at which `lodestoned calibrate` ends by itself, rad.
const LEFT_RAD: f64 = 5.2e-3;
/// What a lane counts at least for a calibrated camera, rad.
const COUNTED_RAD: f64 = 8.7e-3;

/// Two calibrated cameras in one place, turned differently.
struct Pair {
    truth: [Simulation; 2],
    filters: Vec<Estimator>,
}

fn calibrated() -> Parameters {
    let mut parameters = Parameters::default();
    parameters.compass.systematic_sigma_rad = COUNTED_RAD;
    parameters
}

impl Pair {
    /// `deviation` is that of the field at their place; `None` draws a usual one.
    fn new(seed: u64, deviation: Option<f64>) -> Self {
        let horizontal_ut = FIELD.truncate().length();
        let mut truth = [0, 1].map(|which| {
            let mut camera = Simulation::new(2 * seed + which + 1000, calibrated());
            // Level enough to have a heading, turned to anywhere.
            let turn = 2.4 * f64::from(which as u32) + 0.1 * seed as f64;
            let tilt = so3::exp(DVec3::new(0.2, -0.1, 0.0) * (1.0 - f64::from(which as u32)));
            camera.orientation = so3::exp(DVec3::Z * turn) * tilt;
            // What its calibration left is its own.
            let drawn = Simulation::new(2 * seed + which + 9000, calibrated()).accel_bias;
            let left = drawn / Parameters::default().noise.accel_bias_sigma;
            camera.hard_iron = left * (LEFT_RAD * horizontal_ut);
            camera
        });
        let at_their_place = deviation.unwrap_or(truth[0].deviation);
        for camera in &mut truth {
            camera.deviation = at_their_place;
        }
        Self { truth, filters: vec![Estimator::new(calibrated()); 2] }
    }

    /// Both do the same for a while, each by itself; the field of the place stays what it is.
    fn run(&mut self, motion: Motion, seconds: f64) {
        for (truth, filter) in self.truth.iter_mut().zip(&mut self.filters) {
            let deviation = truth.deviation;
            for _ in 0..steps(seconds) {
                filter.step(&truth.step(motion));
                truth.deviation = deviation;
            }
            truth.velocity = DVec3::ZERO;
        }
    }

    fn relative(&self) -> Relative {
        let station = |filter: &Estimator| filter.estimate().expect("aligned").station();
        relative(&station(&self.filters[0]), &station(&self.filters[1]))
    }

    /// Rotation vector of the error about a's axes, rad.
    fn error(&self, found: &Relative) -> DVec3 {
        let truth = self.truth[0].orientation.conjugate() * self.truth[1].orientation;
        so3::log(truth * found.orientation.quaternion().conjugate())
    }
}

#[derive(Debug, Default)]
struct Score {
    within_two_sigma: u32,
    nees: f64,
    error_deg: f64,
    sigma_deg: f64,
}

/// Of each seed: is the angle of the error about each axis within 2σ, and the NEES per axis.
fn score(motion: Motion, seconds: f64) -> Score {
    let mut score = Score::default();
    for seed in 0..SEEDS {
        let mut pair = Pair::new(seed, None);
        pair.run(Motion::Still, 3.0);
        pair.run(motion, seconds);
        pair.run(Motion::Still, 2.0);
        let found = pair.relative();
        let error = pair.error(&found);
        // About the vertical: what the cameras' headings differ by.
        let up = pair.truth[0].orientation.conjugate() * DVec3::Z;
        let sigma = up.dot(found.orientation_covariance * up).sqrt();
        score.within_two_sigma += u32::from(error.dot(up).abs() < 2.0 * sigma);
        score.nees += nees(error, found.orientation_covariance) / SEEDS as f64;
        score.error_deg += error.dot(up).powi(2) / SEEDS as f64;
        score.sigma_deg += sigma.to_degrees() / SEEDS as f64;
    }
    score.error_deg = score.error_deg.sqrt().to_degrees();
    score
}

fn nees(error: DVec3, covariance: DMat3) -> f64 {
    error.dot(covariance.inverse() * error) / 3.0
}

#[test]
fn two_cameras_that_stand_turned_differently_in_one_place_know_how() {
    let score = score(Motion::Still, 1.0);
    println!("standing: {score:?}");
    assert!(score.within_two_sigma >= 95, "{score:?}");
    assert!((0.4..1.3).contains(&score.nees), "{score:?}");
    // The field's deviation, 2°, is common: neither the error nor the sigma has it.
    assert!(score.error_deg < 1.5 && score.sigma_deg < 1.5, "{score:?}");
}

#[test]
fn two_cameras_that_were_turned_about_by_hand_in_one_place_know_how() {
    let score = score(Motion::Carried { rate_sigma: 0.8, speed_sigma: 0.0 }, 10.0);
    println!("turned: {score:?}");
    assert!(score.within_two_sigma >= 95, "{score:?}");
    assert!((0.05..1.3).contains(&score.nees), "{score:?}");
}

#[test]
fn a_wrong_declination_cancels() {
    // Given a field that points 10° beside where both filters expect it: five times the usual
    let mut wrong = Pair::new(1, Some(10_f64.to_radians()));
    let mut right = Pair::new(1, Some(0.0));
    for pair in [&mut wrong, &mut right] {
        pair.run(Motion::Still, 3.0);
    }
    // Then each heading is wrong by as much, and the relative orientation is the same
    let heading = |pair: &Pair| {
        let estimate = pair.filters[0].estimate().expect("aligned");
        so3::log(estimate.orientation.quaternion() * pair.truth[0].orientation.conjugate()).z
    };
    let apart_deg = (heading(&wrong) - heading(&right)).to_degrees();
    assert!((apart_deg.abs() - 10.0).abs() < 0.1, "{apart_deg}°");
    let (wrong, right) = (wrong.relative(), right.relative());
    let difference = wrong.orientation.quaternion() * right.orientation.quaternion().conjugate();
    let difference_deg = so3::log(difference).length().to_degrees();
    assert!(difference_deg < 0.1, "{difference_deg}°");
}
