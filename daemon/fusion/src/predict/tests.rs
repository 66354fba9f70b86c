use std::vec::Vec;

use super::*;
use crate::covariance::{Covariance, Row, STATES};
use crate::parameters::SensorNoise;
use crate::testing::{Dense, Normal, attitudes, moved, state_at, unit};

/// Advances the state, its covariance at once.
fn predict(state: &mut State, increment: &Increment, noise: &ProcessNoise) {
    let mut pending = Pending::NONE;
    advance(state, &mut pending, increment, noise);
    follow(state, &mut pending, noise);
}

/// Process noise of a perfect sensor, so that only the transition is left.
fn noiseless() -> ProcessNoise {
    let mut p = Parameters::default();
    p.noise = SensorNoise {
        gyro_density: 0.0,
        gyro_bias_walk: 0.0,
        gyro_scale_walk: 0.0,
        accel_density: 0.0,
        accel_bias_walk: 0.0,
        ..p.noise
    };
    p.compass.deviation_sigma_rad = 0.0;
    ProcessNoise::new(&p)
}

/// The transition as the covariance sees it: the column that a unit variance grows into.
fn transition(state: &State, increment: &Increment) -> Dense {
    let noise = noiseless();
    let columns: Vec<Row> = (0..STATES)
        .map(|j| {
            let mut one = *state;
            one.covariance = Covariance::ZERO;
            one.covariance.set(j, j, 1.0);
            predict(&mut one, increment, &noise);
            // P' = f fᵀ, and no state loses its own sign over a step.
            let own = libm::sqrt(one.covariance.variance(j));
            one.covariance.times(&unit(j, 1.0 / own))
        })
        .collect();
    Dense::from_fn(|i, j| columns[j][i])
}

/// The same by central differences on the manifold.
fn differences(state: &State, increment: &Increment) -> Dense {
    const DELTA: f64 = 1e-6;
    let noise = noiseless();
    let after = |error: Row| {
        let mut state = moved(state, &error);
        predict(&mut state, increment, &noise);
        state
    };
    let columns: Vec<Row> = (0..STATES)
        .map(|j| {
            let (plus, minus) = (after(unit(j, DELTA)), after(unit(j, -DELTA)));
            plus.error_from(&minus).map(|x| x / (2.0 * DELTA))
        })
        .collect();
    Dense::from_fn(|i, j| columns[j][i])
}

#[test]
fn the_error_transition_is_exact_to_first_order() {
    // What is left out is of second order in the step: half a step's turn or gain, times the step.
    let mut random = Normal::seeded(3);
    for orientation in attitudes() {
        let state = state_at(orientation, &mut random);
        let rate = random.vector(2.0);
        let force = state.orientation.conjugate() * DVec3::Z * 9.81 + random.vector(4.0);
        for dt in [2.5e-3, 2.5e-4] {
            let increment = Increment { span_s: dt, angle: rate * dt, velocity: force * dt };
            let allowed = 0.6 * dt * dt * (rate.length() + force.length() + 1.0) + 1e-8;
            let (got, exact) = (transition(&state, &increment), differences(&state, &increment));
            let error = got.plus(&exact, -1.0).largest();
            assert!(error < allowed, "{error:e} of {allowed:e} at {orientation}, {dt} s");
        }
    }
}

#[test]
fn noise_grows_by_density_and_time() {
    // Given a camera at rest, when a second passes, then each variance has grown by what the
    // parameters promise for a second.
    let p = Parameters::default();
    let noise = ProcessNoise::new(&p);
    let mut state = state_at(glam::DQuat::IDENTITY, &mut Normal::seeded(1));
    state.gyro_bias = DVec3::ZERO;
    state.leaky_velocity = DVec3::ZERO;
    state.accel_bias = DVec3::ZERO;
    let still =
        Increment { span_s: 0.0025, angle: DVec3::ZERO, velocity: DVec3::Z * 9.81 * 0.0025 };
    for _ in 0..400 {
        predict(&mut state, &still, &noise);
    }
    let square = |x: f64| x * x;
    let close = |got: f64, expected: f64| (got / expected - 1.0).abs() < 0.01;
    let n = &p.noise;
    assert!(close(state.covariance.variance(ORIENTATION.0 + 2), square(n.gyro_density)));
    assert!(close(state.covariance.variance(GYRO_BIAS.0), square(n.gyro_bias_walk)));
    assert!(close(state.covariance.variance(ACCEL_BIAS.0), square(n.accel_bias_walk)));
    assert!(close(state.covariance.variance(VELOCITY.0 + 2), square(n.accel_density)));
}

#[test]
fn a_turn_adds_the_same_variance_in_many_steps_as_in_few() {
    let noise = ProcessNoise::new(&Parameters::default());
    let after = |steps: u32| {
        let dt = f64::from(steps).recip();
        let mut state = state_at(glam::DQuat::IDENTITY, &mut Normal::seeded(1));
        state.gyro_bias = DVec3::ZERO;
        for _ in 0..steps {
            let increment = Increment { span_s: dt, angle: DVec3::X * dt, velocity: DVec3::ZERO };
            predict(&mut state, &increment, &noise);
        }
        state.covariance.variance(ORIENTATION.0)
    };
    assert!((after(1000) / after(10) - 1.0).abs() < 1e-3);
}

#[test]
fn constant_acceleration_is_exact() {
    // From rest for ten seconds: v = a t, p = a t² / 2, whatever the attitude.
    let noise = ProcessNoise::new(&Parameters::default());
    let acceleration = DVec3::new(0.3, -0.2, 0.1);
    for orientation in attitudes().into_iter().step_by(3) {
        let mut state = state_at(orientation, &mut Normal::seeded(1));
        (state.velocity, state.position) = (DVec3::ZERO, DVec3::ZERO);
        let force = orientation.conjugate() * (acceleration + DVec3::Z * 9.81) + state.accel_bias;
        let increment =
            Increment { span_s: 0.0025, angle: state.gyro_bias * 0.0025, velocity: force * 0.0025 };
        for _ in 0..4_000 {
            predict(&mut state, &increment, &noise);
        }
        assert!((state.velocity - acceleration * 10.0).length() < 1e-9);
        assert!((state.position - acceleration * 50.0).length() < 1e-9);
    }
}
