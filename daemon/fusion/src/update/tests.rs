//! Jacobians of the measurements against central differences on the manifold, and signs.

use glam::DVec3;

use super::{compass, gradient, levelling, standstill};
use crate::covariance::{
    ACCEL_BIAS, Block, DEVIATION, GYRO_BIAS, LEAKY_VELOCITY, ORIENTATION, Row, STATES, VELOCITY,
};
use crate::parameters::Parameters;
use crate::state::State;
use crate::testing::{Normal, attitudes, moved, state_at, unit};

const DELTA: f64 = 1e-6;
const FIELD: DVec3 = DVec3::new(0.0, 22.0, -42.0);

/// `(h(x ⊞ δ) − h(x ⊞ −δ)) / 2δ` for each error state.
fn differences(state: &State, h: impl Fn(&State) -> f64) -> Row {
    core::array::from_fn(|j| {
        let (plus, minus) = (moved(state, &unit(j, DELTA)), moved(state, &unit(j, -DELTA)));
        (h(&plus) - h(&minus)) / (2.0 * DELTA)
    })
}

fn assert_close(got: &Row, exact: &Row) {
    for k in 0..STATES {
        assert!((got[k] - exact[k]).abs() < 1e-8, "column {k}: {} for {}", got[k], exact[k]);
    }
}

fn states() -> impl Iterator<Item = State> {
    let mut random = Normal::seeded(11);
    attitudes().into_iter().map(move |orientation| state_at(orientation, &mut random))
}

#[test]
fn the_error_between_two_states_is_what_was_added() {
    let mut random = Normal::seeded(5);
    for state in states() {
        let error = random.row(0.3);
        assert_close(&moved(&state, &error).error_from(&state), &error);
    }
}

#[test]
fn levelling_sees_the_leaky_velocity() {
    for state in states() {
        for axis in 0..3 {
            // The expected value is zero, so the prediction is the opposite of the residual.
            let exact = differences(&state, |s| -levelling::residual(s)[axis]);
            assert_close(&levelling::jacobian(axis), &exact);
        }
    }
}

#[test]
fn standstill_sees_velocity_and_bias() {
    let value = |s: &State, block: Block, axis: usize| match block {
        VELOCITY => s.velocity[axis],
        LEAKY_VELOCITY => s.leaky_velocity[axis],
        _ => s.gyro_bias[axis],
    };
    for state in states() {
        for block in [VELOCITY, LEAKY_VELOCITY, GYRO_BIAS] {
            for axis in 0..3 {
                let exact = differences(&state, |s| value(s, block, axis));
                assert_close(&standstill::jacobian(block, axis), &exact);
            }
        }
    }
}

/// The camera's rate in the world, rad/s.
const RATE: DVec3 = DVec3::new(0.7, -1.1, 2.3);

/// The innovation that `nominal` has when the reading comes from `truth`.
fn compass_innovation(nominal: &State, truth: &State) -> f64 {
    // A deviation turns the field from north to east.
    let local = crate::so3::exp(DVec3::Z * -truth.deviation) * FIELD;
    // A delay shows the body as it was: the turn since then is missing.
    let late = truth.mag_delay_s - nominal.mag_delay_s;
    let local = crate::so3::exp(RATE * late) * local;
    let reading = truth.orientation().inverse().apply(local);
    let seen = nominal.orientation().apply(reading);
    compass::bearing(seen).unwrap() - nominal.deviation
}

#[test]
fn the_compass_sees_heading_deviation_tilt_and_delay() {
    for state in states() {
        let local = crate::so3::exp(DVec3::Z * -state.deviation) * FIELD;
        let exact = differences(&state, |truth| compass_innovation(&state, truth));
        assert_close(&compass::jacobian(local, RATE.cross(local)).unwrap(), &exact);
    }
}

#[test]
fn the_gradient_sees_the_velocity_against_the_body() {
    for nominal in states() {
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            // What the rig's magnetometers tell in the body is turned by the estimated attitude.
            let seen = |truth: &State| {
                let in_body = truth.orientation().inverse().apply(truth.velocity);
                axis.dot(nominal.orientation().apply(in_body))
            };
            let exact = differences(&nominal, seen);
            assert_close(&gradient::jacobian(axis, nominal.velocity), &exact);
        }
    }
}

#[test]
fn a_deviation_moves_the_compass_one_to_one_however_large() {
    for mut state in states() {
        for deviation in [-0.5, 0.2, 1.0] {
            state.deviation = deviation;
            let mut truth = state;
            truth.correct(&unit(DEVIATION, 0.1));
            assert!((compass_innovation(&state, &truth) - 0.1).abs() < 1e-12);
        }
    }
}

#[test]
fn a_vertical_field_has_no_heading() {
    assert_eq!(compass::bearing(DVec3::new(0.1, -0.2, 48.0)), None);
    assert_eq!(compass::bearing(DVec3::ZERO), None);
}

#[test]
fn a_standing_camera_learns_velocity_and_bias() {
    // Given a filter that knows nothing, when the camera is known to stand, then the measured
    // values replace its own.
    let mut state = states().next().unwrap();
    for block in [VELOCITY, LEAKY_VELOCITY, GYRO_BIAS] {
        state.covariance.set_independent(block, glam::DMat3::IDENTITY * 100.0);
    }
    let rate = DVec3::new(0.01, -0.02, 0.03);
    let before = state;
    standstill::zero_velocity(&mut state, super::apply_blind, 1e-3);
    standstill::zero_rate(&mut state, super::apply_blind, rate, 1e-4);
    assert!(state.velocity.length() < 1e-6 && before.velocity.length() > 0.1);
    assert!((state.gyro_bias - rate).length() < 1e-8);
    assert_eq!(state.leaky_velocity, before.leaky_velocity, "another state");
    standstill::restart_leaky_velocity(&mut state, 1e-3);
    assert_eq!(state.leaky_velocity, DVec3::ZERO);
    assert_eq!(state.covariance.block(LEAKY_VELOCITY, VELOCITY), glam::DMat3::ZERO);
}

#[test]
fn levelling_turns_a_tilted_camera_upright() {
    // Given a standing camera whose attitude is a degree off, when prediction and levelling run for
    // half a minute, then the tilt is gone. The accelerometer is known to be unbiased.
    let p = Parameters::default();
    let noise = crate::predict::ProcessNoise::new(&p);
    for orientation in attitudes().into_iter().step_by(4) {
        let mut state = state_at(orientation, &mut Normal::seeded(2));
        (state.gyro_bias, state.accel_bias) = (DVec3::ZERO, DVec3::ZERO);
        state.leaky_velocity = DVec3::ZERO;
        state.covariance.set_independent(ORIENTATION, glam::DMat3::IDENTITY * 1e-3);
        state.covariance.set_independent(ACCEL_BIAS, glam::DMat3::IDENTITY * 1e-8);
        let truth = state;
        state.correct(&unit(ORIENTATION.0, 0.0175));
        let force = truth.orientation().inverse().apply(DVec3::Z * p.gravity_m_s2);
        let still =
            crate::Increment { span_s: 0.0025, angle: DVec3::ZERO, velocity: force * 0.0025 };
        let mut pending = crate::predict::Pending::NONE;
        let mut strapdown = crate::predict::Strapdown::NEW;
        for step in 0..12_000 {
            let ground = crate::predict::Ground { earth_rate: DVec3::ZERO, stands: false };
            let surroundings = (&noise, ground);
            strapdown.advance(&mut state, &mut pending, &still, surroundings);
            crate::predict::follow(&mut state, &mut pending, &noise);
            if step % 40 == 39 {
                levelling::Levelling::new().update(&mut state, &p.levelling);
            }
        }
        let tilt = truth.error_from(&state)[ORIENTATION.0];
        assert!(tilt.abs() < 0.0175 * 0.1, "{tilt} rad left at {orientation}");
    }
}

#[test]
fn a_residual_beyond_the_gate_is_weakened_but_never_ignored() {
    let p = Parameters::default().levelling;
    let mut state = states().next().unwrap();
    state.covariance.set_independent(LEAKY_VELOCITY, glam::DMat3::IDENTITY * 0.01);
    let corrected_by = |leaky: f64| {
        let mut state = state;
        state.leaky_velocity = DVec3::X * leaky;
        let outcome = levelling::Levelling::new().update(&mut state, &p);
        assert!(outcome.used && state.leaky_velocity.x > 0.0);
        leaky - state.leaky_velocity.x
    };
    let (usual, far, farther) = (corrected_by(0.5), corrected_by(5.0), corrected_by(50.0));
    assert!(usual > 0.0 && farther > 0.0);
    assert!(far < 10.0 * usual, "weaker than in proportion");
    assert!(farther < far, "the farther the weaker");
}
