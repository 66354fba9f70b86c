use std::prelude::v1::*;

use glam::DQuat;
use proptest::prelude::*;

use super::*;
use crate::covariance::DEVIATION;
use crate::parameters::Parameters;
use crate::predict::{Pending, ProcessNoise, follow};
use crate::so3;
use crate::state::State;
use crate::testing::{Dense, Normal, unit};
use crate::time::SensorTime;
use crate::update::standstill::restart_leaky_velocity;
use crate::update::{apply, apply_blind};

/// A state tied by random shares, whose error is the anchor's and nothing else.
fn tied(seed: u64) -> State {
    let mut random = Normal::seeded(seed);
    let mut shares = Shares::NONE;
    for row in &mut shares.rows {
        *row = core::array::from_fn(|_| random.number());
    }
    let mut covariance = || {
        let root = DMat3::from_cols(random.vector(1.0), random.vector(1.0), random.vector(1.0));
        root * root.transpose() + DMat3::IDENTITY
    };
    let covariance = [covariance(), covariance()];
    let mark = Drift::new(SensorTime::from_nanos(0));
    // Beyond the time in which it is held: its gains are the optimal ones.
    let tie = Tie { anchor: 3, shares, covariance, mark, age_s: 2.0 * HELD_S };
    let mut state = State::at(so3::exp(random.vector(1.0)));
    tie.put_on(&mut state.covariance, 1.0);
    state.tie = Some(tie);
    state
}

/// What the tie says that the covariance is, where all is in common.
fn of_tie(state: &State) -> Dense {
    let mut covariance = Covariance::ZERO;
    state.tie.expect("it is tied").put_on(&mut covariance, 1.0);
    Dense::of(&covariance)
}

/// A noiseless world, so that nothing is the state's own.
fn noiseless() -> ProcessNoise {
    let mut p = Parameters::default();
    let n = &mut p.noise;
    for density in [
        &mut n.gyro_density,
        &mut n.gyro_bias_walk,
        &mut n.gyro_scale_walk,
        &mut n.gyro_aliasing,
        &mut n.accel_density,
        &mut n.accel_bias_walk,
        &mut n.accel_aliasing,
    ] {
        *density = 0.0;
    }
    ProcessNoise::new(&p)
}

#[test]
fn a_prediction_does_to_the_shares_what_it_does_to_the_error() {
    let mut state = tied(1);
    let mut strapdown = crate::predict::Strapdown::NEW;
    let mut pending = Pending::NONE;
    let ground = crate::predict::Ground { earth_rate: DVec3::ZERO, stands: false };
    let increment = crate::grid::Increment {
        span_s: 0.0025,
        angle: DVec3::new(0.01, -0.02, 0.005),
        velocity: DVec3::new(0.1, 0.02, 0.05),
    };
    for _ in 0..4 {
        strapdown.advance(&mut state, &mut pending, &increment, (&noiseless(), ground));
    }
    follow(&mut state, &mut pending, &noiseless());
    let apart = Dense::of(&state.covariance).relative_difference(&of_tie(&state));
    assert!(apart < 1e-12, "{apart}");
}

#[test]
fn an_own_measurement_takes_from_the_shares_what_it_takes_from_the_error() {
    // With hardly any noise of its own: P⁺ = (I − K h) P (I − K h)ᵀ.
    let mut state = tied(2);
    for index in [0, 4, 7, DEVIATION] {
        let mut row = unit(index, 1.0);
        row[(index + 5) % STATES] = -0.7;
        apply(&mut state, &row, 0.0, 1e-12);
    }
    let apart = Dense::of(&state.covariance).relative_difference(&of_tie(&state));
    assert!(apart < 1e-9, "{apart}");
    restart_leaky_velocity(&mut state, 0.0);
    let apart = Dense::of(&state.covariance).relative_difference(&of_tie(&state));
    assert!(apart < 1e-9, "{apart}");
}

#[test]
fn what_is_held_in_common_is_not_corrected_by_one_alone() {
    // Given a camera with much in common with its anchor and a little error of its own
    let mut state = State::at(DQuat::IDENTITY);
    state.covariance.add_variances(ORIENTATION, DVec3::splat(1e-6));
    let mut shares = Shares::NONE;
    (0..3).for_each(|k| shares.rows[ORIENTATION.0 + k][k] = 1.0);
    let covariance = [DMat3::IDENTITY * 1e-4, DMat3::IDENTITY];
    let mark = Drift::new(SensorTime::from_nanos(0));
    let tie = Tie { anchor: 1, shares, covariance, mark, age_s: 0.0 };
    tie.put_on(&mut state.covariance, 1.0);
    state.tie = Some(tie);
    // When it sees its heading off by two degrees, as sure as the anchor is
    let before = state;
    apply_blind(&mut state, &unit(ORIENTATION.0 + 2, 1.0), 0.035, 1e-4);
    // Then it turns as far as that is its own, and stays as close to its anchor as it was
    let turned = state.error_from(&before)[ORIENTATION.0 + 2];
    assert!((turned - 0.035 * 1e-6 / 2.01e-4).abs() < 1e-6, "{turned}");
    let share = state.tie.expect("it is").shares.of_heading();
    assert!((0.99..1.0).contains(&share), "{share}");
    // Once it is held no longer, it follows what it sees
    if let Some(tie) = &mut state.tie {
        tie.age_s = 2.0 * HELD_S;
    }
    let before = state;
    apply_blind(&mut state, &unit(ORIENTATION.0 + 2, 1.0), 0.035, 1e-4);
    assert!(state.error_from(&before)[ORIENTATION.0 + 2] > 0.015);
}

proptest! {
    /// What is the state's own stays a covariance, whatever is measured.
    #[test]
    fn the_own_part_stays_a_covariance(
        seed in 0_u64..1000,
        rows in prop::collection::vec((0..STATES, -1.0..1.0_f64, 1e-3..10.0_f64), 1..30),
        held in any::<bool>(),
    ) {
        let mut state = tied(seed);
        (0..STATES).for_each(|i| state.covariance.add_variance(i, 0.1));
        if let Some(tie) = &mut state.tie {
            tie.age_s = if held { 0.0 } else { tie.age_s };
        }
        for (index, other, noise) in rows {
            let mut row = unit(index, 1.0);
            row[(index + 3) % STATES] = other;
            apply(&mut state, &row, 0.1, noise);
        }
        let whole = Dense::of(&state.covariance);
        let own = whole.plus(&of_tie(&state), -1.0);
        prop_assert!(own.is_positive_semidefinite(1e-9));
        prop_assert!(whole.is_positive_semidefinite(1e-9));
    }
}
