use std::vec::Vec;

use super::*;
use crate::covariance::{Covariance, Row, STATES};
use crate::parameters::SensorNoise;
use crate::testing::{Dense, Normal, attitudes, moved, state_at, unit};

/// A camera that may move, on an earth that does not turn.
const STILL_EARTH: Ground = Ground { earth_rate: DVec3::ZERO, stands: false };

/// Advances the state, its covariance at once.
fn predict(state: &mut State, increment: &Increment, noise: &ProcessNoise) {
    let mut pending = Pending::NONE;
    let mut strapdown = Strapdown::NEW;
    strapdown.advance(state, &mut pending, increment, (noise, STILL_EARTH));
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

/// Rate and specific force in the body at a time, s.
type Felt<'a> = &'a dyn Fn(f64) -> (DVec3, DVec3);

/// The mean of a function over a span, by Gauss and Legendre with five points: exact to 1e-13 here.
fn mean(felt: Felt<'_>, from: f64, span: f64) -> (DVec3, DVec3) {
    const NODES: [(f64, f64); 5] = [
        (-0.906_179_845_938_664, 0.236_926_885_056_189),
        (-0.538_469_310_105_683, 0.478_628_670_499_366),
        (0.0, 0.568_888_888_888_889),
        (0.538_469_310_105_683, 0.478_628_670_499_366),
        (0.906_179_845_938_664, 0.236_926_885_056_189),
    ];
    NODES.iter().fold((DVec3::ZERO, DVec3::ZERO), |(rate, force), (at, weight)| {
        let (r, f) = felt(from + 0.5 * span * (1.0 + at));
        (rate + r * (0.5 * weight), force + f * (0.5 * weight))
    })
}

/// The increments of a step as a sensor delivers them: integrals over it.
fn increment(felt: Felt<'_>, step: u32, span_s: f64) -> Increment {
    let (rate, force) = mean(felt, f64::from(step) * span_s, span_s);
    Increment { span_s, angle: rate * span_s, velocity: force * span_s }
}

/// A state without biases, integrated from time 0 over steps of what was felt.
fn integrated(
    start: State,
    felt: Felt<'_>,
    (steps, span_s): (u32, f64),
    earth_rate: DVec3,
) -> State {
    let noise = ProcessNoise::new(&Parameters::default());
    let (mut state, mut strapdown, mut pending) = (start, Strapdown::NEW, Pending::NONE);
    for step in 0..steps {
        let increment = increment(felt, step, span_s);
        strapdown.advance(
            &mut state,
            &mut pending,
            &increment,
            (&noise, Ground { earth_rate, stands: false }),
        );
    }
    state
}

/// The angle between two attitudes, rad.
fn angle_between(a: glam::DQuat, b: glam::DQuat) -> f64 {
    so3::log(a.conjugate() * b).length()
}

#[test]
fn coning_is_integrated_a_thousand_times_better_than_to_first_order() {
    // An axis that itself goes round on a cone turns the body about the cone's axis, although the
    // gyroscope's mean there is zero. Attitude: Exp(θ (cos ωt, sin ωt, 0)), half-angle θ.
    const HALF_ANGLE: f64 = 0.02;
    let axis = |phase: f64| DVec3::new(libm::cos(phase), libm::sin(phase), 0.0);
    for (cone_hz, rate_hz) in [(2.0, 400.0), (10.0, 400.0), (5.0, 200.0)] {
        let omega = core::f64::consts::TAU * cone_hz;
        let attitude = |t: f64| so3::exp(axis(omega * t) * HALF_ANGLE);
        let felt = |t: f64| {
            let (sin, cos) = (libm::sin(HALF_ANGLE), libm::cos(HALF_ANGLE));
            let across = DVec3::new(-libm::sin(omega * t), libm::cos(omega * t), 0.0);
            (across * (omega * sin) - DVec3::Z * (omega * (1.0 - cos)), DVec3::ZERO)
        };
        let steps = (10.0 * rate_hz) as u32;
        let span_s = 1.0 / rate_hz;
        let first_order = (0..steps).fold(attitude(0.0), |q, step| {
            (q * so3::exp(increment(&felt, step, span_s).angle)).normalize()
        });
        let corrected = integrated(State::at(attitude(0.0)), &felt, (steps, span_s), DVec3::ZERO);
        let truth = attitude(10.0);
        let ratio = angle_between(corrected.orientation, truth) / angle_between(first_order, truth);
        assert!(ratio < 1e-3, "{ratio:e} at {cone_hz} Hz, sampled at {rate_hz} Hz");
    }
}

#[test]
fn sculling_is_integrated_a_thousand_times_better_than_to_first_order() {
    // A body that rocks about x while it is pushed along y in phase feels a push along z on average:
    // f = Rᵀ a with a tilt φ(t) = A sin ωt and a force B sin ωt along its own y.
    const ANGLE: f64 = 0.05;
    const FORCE: f64 = 5.0;
    let omega = core::f64::consts::TAU * 5.0;
    let tilt = |t: f64| ANGLE * libm::sin(omega * t);
    let felt = |t: f64| {
        let rate = ANGLE * omega * libm::cos(omega * t);
        (DVec3::X * rate, DVec3::Y * (FORCE * libm::sin(omega * t)))
    };
    let (steps, span_s) = (4_000, 0.0025);
    let state = integrated(State::at(glam::DQuat::IDENTITY), &felt, (steps, span_s), DVec3::ZERO);
    // The truth, by a thousand times finer steps of the closed form.
    let turned = |t: f64| so3::exp(DVec3::X * tilt(t)) * felt(t).1;
    let truth = (0..40_000).fold(DVec3::ZERO, |v, n| {
        v + mean(&|t| (turned(t), DVec3::ZERO), f64::from(n) * 2.5e-4, 2.5e-4).0 * 2.5e-4
    });
    let first_order = (0..steps).fold(DVec3::ZERO, |v, step| {
        let at = f64::from(step) * span_s;
        v + so3::exp(DVec3::X * tilt(at)) * increment(&felt, step, span_s).velocity
    });
    let truth_with_gravity = truth - DVec3::Z * 9.81 * 10.0;
    let error = (state.velocity - truth_with_gravity).length();
    let ratio = error / (first_order - truth).length();
    assert!(ratio < 1e-3, "{error:e} m/s, {ratio:e} of the first order's");
}

#[test]
fn a_constant_turn_is_exact() {
    let noise = ProcessNoise::new(&Parameters::default());
    for rate in [DVec3::new(0.7, -1.1, 0.4), DVec3::Z * 10.0] {
        let (mut state, mut strapdown) = (State::at(glam::DQuat::IDENTITY), Strapdown::NEW);
        let increment = Increment { span_s: 0.0025, angle: rate * 0.0025, velocity: DVec3::ZERO };
        for _ in 0..40_000 {
            let surroundings = (&noise, STILL_EARTH);
            strapdown.advance(&mut state, &mut { Pending::NONE }, &increment, surroundings);
        }
        assert!(angle_between(state.orientation, so3::exp(rate * 100.0)) < 1e-9);
    }
}

#[test]
fn free_fall_is_right_to_a_millionth() {
    // Given a camera in free fall that tumbles, then a force-free body falls with g.
    let tumbling = |_| (DVec3::new(1.0, -2.0, 0.5), DVec3::ZERO);
    let start = State::at(glam::DQuat::IDENTITY);
    let fallen = integrated(start, &tumbling, (400, 0.0025), DVec3::ZERO);
    assert!((fallen.velocity - DVec3::Z * -9.81).length() < 1e-6);
}

#[test]
fn a_turntable_is_right_to_a_millionth() {
    // Given a camera on a turntable's rim, mounted askew, that feels gravity and the pull inward, when it
    // has gone round for ten seconds, then its acceleration was right to 1e-6 m/s² on average.
    const RATE: f64 = 3.0;
    const RADIUS: f64 = 0.5;
    let mounted = so3::exp(DVec3::new(0.3, -0.2, 0.1));
    let inward = DVec3::new(-RATE * RATE * RADIUS, 0.0, 9.81);
    let felt = |_| (mounted.conjugate() * DVec3::Z * RATE, mounted.conjugate() * inward);
    let start = State { velocity: DVec3::Y * RATE * RADIUS, ..State::at(mounted) };
    let end = integrated(start, &felt, (4_000, 0.0025), DVec3::ZERO);
    let truth = so3::exp(DVec3::Z * RATE * 10.0) * DVec3::Y * (RATE * RADIUS);
    assert!((end.velocity - truth).length() < 1e-5, "{}", end.velocity - truth);
}

/// The earth's rate at 48° north, in a world whose y axis is true north.
fn earth_rate() -> DVec3 {
    let latitude = 48_f64.to_radians();
    DVec3::new(0.0, libm::cos(latitude), libm::sin(latitude)) * 7.292_115e-5
}

#[test]
fn coriolis_at_80_km_h_is_2_4_mm_s2() {
    // Given a vehicle that drives north at 80 km/h, kept on its way, when no force is felt but gravity's
    // and the filter knows how the earth turns, then it sees the vehicle drift to the east.
    let level = |_| (earth_rate(), DVec3::Z * 9.81);
    let start = State { velocity: DVec3::Y * (80.0 / 3.6), ..State::at(glam::DQuat::IDENTITY) };
    let end = integrated(start, &level, (400, 0.0025), earth_rate());
    assert!((end.velocity.x - 2.41e-3).abs() < 0.01e-3, "{}", end.velocity);
    assert!(
        angle_between(end.orientation, start.orientation) < 1e-9,
        "the earth's turn is no turn"
    );
}

#[test]
fn a_camera_that_stands_for_an_hour_does_not_turn_with_the_earth() {
    for orientation in attitudes().into_iter().step_by(3) {
        let felt = |_| {
            let to_body = orientation.conjugate();
            (to_body * earth_rate(), to_body * DVec3::Z * 9.81)
        };
        let end = integrated(State::at(orientation), &felt, (36_000, 0.1), earth_rate());
        assert!(angle_between(end.orientation, orientation) < 1e-9);
        assert!(end.velocity.length() < 1e-5);
    }
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
