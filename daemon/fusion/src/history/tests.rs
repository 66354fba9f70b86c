//! The way back against the way forward, and its Jacobian against central differences.

use std::vec::Vec;

use super::*;
use crate::covariance::STATES;
use crate::parameters::Parameters;
use crate::predict::{Ground, Pending, ProcessNoise, Strapdown};
use crate::testing::{Normal, attitudes, moved, state_at, unit};
use crate::update::{fix, non_holonomic, speed, vehicle};
use crate::{Rotation, VehicleParameters};

const EARTH_RATE: DVec3 = DVec3::new(0.0, 4.9e-5, 5.4e-5);
const AROUND: Surroundings =
    Surroundings { gravity: DVec3::new(0.0, 0.0, -9.81), earth_rate: EARTH_RATE };
const GROUND: Ground = Ground { earth_rate: EARTH_RATE, stands: false };
const STEP_S: f64 = 0.0025;

/// A vehicle-like motion: increments that turn and push.
fn increments(count: usize) -> Vec<Increment> {
    let at = |k: usize| {
        let t = k as f64 * STEP_S;
        let rate = DVec3::new(0.1 * (5.0 * t).sin(), -0.05, 0.6 + 0.3 * (2.0 * t).cos());
        let force = DVec3::new(2.0 * (1.5 * t).sin(), 4.0, 9.6 + (9.0 * t).sin());
        Increment { span_s: STEP_S, angle: rate * STEP_S, velocity: force * STEP_S }
    };
    (0..count).map(at).collect()
}

/// States after each step from a start, and the history of all steps.
fn drive(start: State, steps: &[Increment]) -> (Vec<State>, History) {
    let noise = ProcessNoise::new(&Parameters::default());
    let (mut strapdown, mut pending) = (Strapdown::NEW, Pending::NONE);
    let (mut state, mut history) = (start, History::EMPTY);
    let mut states = Vec::new();
    for step in steps {
        strapdown.advance(&mut state, &mut pending, step, (&noise, GROUND));
        history.push(step);
        states.push(state);
    }
    (states, history)
}

fn start() -> State {
    state_at(attitudes()[12], &mut Normal::seeded(4))
}

#[test]
fn the_way_back_leads_to_where_the_way_began() {
    let (states, history) = drive(start(), &increments(800));
    let now = states.last().unwrap();
    for steps_ago in [0, 1, 3, 8, 119, 400, 760] {
        let then = &states[states.len() - 1 - steps_ago];
        let past = history.past(now, steps_ago as f64 * STEP_S, &AROUND).unwrap();
        let turn = so3::log(past.orientation * then.orientation.conjugate()).length();
        let velocity = (past.velocity - then.velocity).length();
        let position = (past.position - then.position).length();
        assert!(turn < 2e-4, "{turn} rad after {steps_ago} steps");
        assert!(velocity < 4e-3, "{velocity} m/s after {steps_ago} steps");
        assert!(position < 4e-3, "{position} m after {steps_ago} steps");
    }
}

#[test]
fn a_correction_made_meanwhile_counts() {
    // Given a state that was corrected by a metre and a tenth of a metre per second after a motion,
    // when it is run back, then the past is corrected as well.
    let (states, history) = drive(start(), &increments(400));
    let now = *states.last().unwrap();
    let mut error = unit(POSITION.0, 1.0);
    error[VELOCITY.0 + 1] = 0.1;
    let (before, after) =
        (history.past(&now, 0.5, &AROUND), history.past(&moved(&now, &error), 0.5, &AROUND));
    let shift = after.unwrap().position - before.unwrap().position;
    assert!((shift - DVec3::new(1.0, -0.05, 0.0)).length() < 1e-4, "{shift}");
}

#[test]
fn what_is_forgotten_is_not_guessed() {
    let (states, history) = drive(start(), &increments(400));
    let now = states.last().unwrap();
    assert!(history.past(now, 0.99, &AROUND).is_some());
    assert_eq!(history.past(now, 1.1, &AROUND), None);
    let (states, history) = drive(start(), &increments(4000));
    let now = states.last().unwrap();
    assert!(history.past(now, 1.99, &AROUND).is_some());
    assert_eq!(history.past(now, 2.1, &AROUND), None, "a ring has an end");
}

#[test]
fn the_rate_of_the_present_is_not_one_sample() {
    let (states, history) = drive(start(), &increments(401));
    let now = states.last().unwrap();
    let past = history.past(now, 0.0, &AROUND).unwrap();
    let expected = DVec3::new(0.1 * 5.0_f64.sin(), -0.05, 0.6 + 0.3 * 2.0_f64.cos());
    assert!((past.rate - expected + now.gyro_bias).length() < 0.02, "{}", past.rate);
}

/// `(h(x ⊞ δ) − h(x ⊞ −δ)) / 2δ` of a function of the present state.
fn differences(state: &State, h: impl Fn(&State) -> f64) -> Row {
    const DELTA: f64 = 1e-6;
    core::array::from_fn(|j| {
        let (plus, minus) = (moved(state, &unit(j, DELTA)), moved(state, &unit(j, -DELTA)));
        (h(&plus) - h(&minus)) / (2.0 * DELTA)
    })
}

fn assert_close(got: &Row, exact: &Row, tolerance: f64, what: &str) {
    for k in 0..STATES {
        let (g, e) = (got[k], exact[k]);
        let scale = 1.0 + e.abs();
        assert!((g - e).abs() < tolerance * scale, "{what}, column {k}: {g} for {e}");
    }
}

fn car() -> VehicleParameters {
    let mounted = Rotation::from_yaw_pitch_roll(0.3, -0.1, 0.05);
    VehicleParameters::mounted(mounted, DVec3::new(-1.4, 0.2, -0.9))
}

/// Ages, s, with the tolerance of the Jacobian there: over a stretch the attitude is taken constant.
const AGES: [(f64, f64); 4] = [(0.0, 1e-8), (0.013, 3e-3), (0.3, 2e-3), (1.7, 1e-2)];

#[test]
fn fixes_see_the_past_through_the_present() {
    let lever = DVec3::new(0.5, -0.3, 1.2);
    for attitude in attitudes().into_iter().step_by(3) {
        let (states, history) = drive(state_at(attitude, &mut Normal::seeded(9)), &increments(800));
        let now = *states.last().unwrap();
        for (ago_s, tolerance) in AGES {
            let at = |s: &State| history.past(s, ago_s, &AROUND).unwrap();
            let past = at(&now);
            for k in 0..3 {
                let exact =
                    differences(&now, |s| -fix::position_residual(&at(s), DVec3::ZERO, lever)[k]);
                let row = past.carry(&fix::position_rows(&past, lever)[k]);
                assert_close(&row, &exact, tolerance, "position");
                let exact =
                    differences(&now, |s| -fix::velocity_residual(&at(s), DVec3::ZERO, lever)[k]);
                assert_close(
                    &past.carry(&fix::velocity_rows(&past, lever)[k]),
                    &exact,
                    tolerance,
                    "velocity",
                );
                let exact =
                    differences(&now, |s| -fix::orientation_residual(&at(s), past.orientation)[k]);
                let row = past.carry(&fix::orientation_rows()[k]);
                assert_close(&row, &exact, tolerance, "orientation");
            }
        }
    }
}

#[test]
fn a_vehicles_velocity_sees_the_past_through_the_present() {
    let p = car();
    for attitude in attitudes().into_iter().step_by(3) {
        let (states, history) = drive(state_at(attitude, &mut Normal::seeded(9)), &increments(800));
        let now = *states.last().unwrap();
        for (ago_s, tolerance) in AGES {
            let at = |s: &State| history.past(s, ago_s, &AROUND).unwrap();
            let past = at(&now);
            for k in 0..3 {
                let exact = differences(&now, |s| vehicle::velocity(s, &at(s), &p)[k]);
                let row = past.carry(&vehicle::rows(&now, &past, &p)[k]);
                assert_close(&row, &exact, tolerance, "velocity of the vehicle");
            }
            let exact = differences(&now, |s| -speed::residual(s, &at(s), 3.0, &p));
            let row = past.carry(&speed::row(&now, &past, &p));
            assert_close(&row, &exact, tolerance, "speed");
        }
    }
}

#[test]
fn the_constraint_is_left_out_of_turns_in_which_a_vehicle_may_skid() {
    let p = car();
    let mut past = Past::present(&start());
    past.rate = DVec3::Z;
    assert!(non_holonomic::applies(&past, &p));
    past.rate = DVec3::Z * 2.0;
    assert!(!non_holonomic::applies(&past, &p));
    past.rate = DVec3::Z;
    assert!(!non_holonomic::applies(&past, &VehicleParameters { non_holonomic: false, ..p }));
}
