//! What must be found, and what must be refused.

use std::sync::LazyLock;

use glam::DVec3;
use proptest::prelude::*;

use super::room::{Room, camera};
use super::scene::{Pose, Scene, Sigma, error};
use crate::registration::RegistrationError;

const PRIOR: Sigma = Sigma { turn_deg: 1.5, shift_m: 0.1 };

fn two_places() -> ([Pose; 2], Pose) {
    let mapped = [camera([-1.5, -1.0, 1.3], 0.5, 0.1), camera([-1.5, -0.8, 1.3], -0.3, 0.2)];
    (mapped, camera([-1.0, 0.4, 1.2], 0.1, 0.15))
}

static FURNISHED: LazyLock<Scene> = LazyLock::new(|| {
    let (mapped, truth) = two_places();
    Scene::new(&Room::furnished(), &mapped, truth, 1)
});

fn ball(radius: f64) -> impl Strategy<Value = DVec3> {
    let cube = prop::array::uniform3(-1.0..1.0_f64).prop_map(DVec3::from_array);
    cube.prop_map(move |v| v.clamp_length_max(1.0) * radius)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn a_room_seen_from_two_places_comes_together(
        turn in ball(3.0_f64.to_radians()), shift in ball(0.2),
    ) {
        let found = FURNISHED.register((turn, shift), PRIOR).unwrap();
        let (turn, shift) = error(found.fix().unwrap().world_from_body, FURNISHED.truth);
        prop_assert!(turn.length().to_degrees() < 0.15, "{turn}");
        prop_assert!(shift.length() < 0.008, "{shift}");
        prop_assert!(found.statistics.overlap > 0.8);
        prop_assert!(found.statistics.rmse_after_m <= found.statistics.rmse_before_m * 1.01);
    }
}

/// Given walls that only slide along themselves, then the fix is refused, and what is known is used.
fn refused_as_degenerate(room: &Room, unseen: &[&str]) {
    let mapped = [camera([0.0, 0.0, 1.3], 0.0, 0.0), camera([0.0, 0.2, 1.3], 0.4, 0.0)];
    let truth = camera([0.5, 0.0, 1.2], 0.1, 0.0);
    let scene = Scene::new(room, &mapped, truth, 1);
    let found = scene.register((DVec3::ZERO, DVec3::new(0.08, 0.05, 0.03)), PRIOR).unwrap();
    let refused = found.fix().unwrap_err();
    let RegistrationError::Degenerate { unseen: said } = &refused else { panic!("{refused}") };
    assert_eq!(said.len(), unseen.len(), "{refused}");
    for words in unseen {
        assert!(refused.to_string().contains(words), "{refused}");
    }
    // Along east nothing is known but the prior.
    let left = error(found.posterior.world_from_body, truth).1;
    let sigma = found.posterior.covariance.position_m2;
    if unseen.contains(&"a shift along east") {
        assert!((left.x - 0.08).abs() < 0.02, "{left}");
        assert!((sigma.x_axis.x.sqrt() - PRIOR.shift_m).abs() < 0.01, "{sigma}");
        assert!(left.y.abs() < 0.01 && sigma.y_axis.y.sqrt() < 0.02, "{left} {sigma}");
    }
}

#[test]
fn a_corridor_is_refused() {
    let corridor = Room::boxes(&[([-50.0, -1.0, 0.0], [50.0, 1.0, 2.5])]);
    refused_as_degenerate(&corridor, &["a shift along east"]);
}

#[test]
fn a_single_wall_is_refused() {
    let wall = Room::boxes(&[([3.0, -50.0, -50.0], [3.5, 50.0, 50.0])]);
    refused_as_degenerate(&wall, &["a shift", "a turn about east", "shift"]);
}

#[test]
fn a_prior_that_is_wrong_by_six_sigma_is_refused() {
    let sigma = Sigma { turn_deg: 0.5, shift_m: 0.03 };
    let turns = DVec3::Z * (6.0 * sigma.turn_deg).to_radians();
    for away in [(DVec3::ZERO, DVec3::Y * 6.0 * sigma.shift_m), (turns, DVec3::ZERO)] {
        let found = FURNISHED.register(away, sigma).unwrap();
        let refused = found.fix().unwrap_err();
        let RegistrationError::ContradictsPrior { distance, allowed } = refused else {
            panic!("{refused}")
        };
        assert!((5.0..7.0).contains(&distance), "{distance}");
        assert!((allowed - 4.479).abs() < 1e-3);
    }
}

#[test]
fn a_third_of_moving_points_does_no_harm() {
    let (mapped, truth) = two_places();
    let mut scene = Scene::new(&Room::furnished(), &mapped, truth, 3);
    // Somebody stands before the camera who was not there when the map was made.
    let somebody = scene.source_in_body.len() * 3 / 10;
    for (index, point) in scene.source_in_body.iter_mut().take(somebody).enumerate() {
        let (u, v) = ((index % 40) as f64 / 40.0, (index / 40) as f64 / 40.0);
        *point = DVec3::new(1.5 + 0.05 * u, u - 0.5, v - 0.5);
    }
    let away = (DVec3::new(0.01, -0.01, 0.02), DVec3::new(0.08, -0.06, 0.04));
    let found = scene.register(away, PRIOR).unwrap();
    let (turn, shift) = error(found.fix().unwrap().world_from_body, truth);
    assert!(turn.length().to_degrees() < 0.2 && shift.length() < 0.01, "{turn} {shift}");
    assert!(found.statistics.overlap < 0.75, "{:?}", found.statistics);
}

#[test]
fn clouds_of_different_places_are_refused() {
    let far_away = (DVec3::ZERO, DVec3::X * 30.0);
    let refused = FURNISHED.register(far_away, PRIOR).unwrap_err();
    assert!(matches!(refused, RegistrationError::NoOverlap { found, .. } if found < 0.01));
}

#[test]
fn points_without_depth_change_nothing() {
    let (mapped, truth) = two_places();
    let mut scene = Scene::new(&Room::furnished(), &mapped, truth, 1);
    let away = (DVec3::ZERO, DVec3::X * 0.05);
    let without = scene.register(away, PRIOR).unwrap().fix().unwrap();
    scene.source_in_body.extend([DVec3::NAN; 500]);
    scene.source_in_body.extend([DVec3::new(f64::INFINITY, 0.0, 1.0); 50]);
    let with = scene.register(away, PRIOR).unwrap().fix().unwrap();
    assert_eq!(with, without);
}

#[test]
fn a_handful_of_points_and_a_prior_without_sense_are_refused() {
    let (mapped, truth) = two_places();
    let mut scene = Scene::new(&Room::furnished(), &mapped, truth, 1);
    let nothing = (DVec3::ZERO, DVec3::ZERO);
    for shift_m in [0.0, f64::NAN, f64::INFINITY] {
        let refused = scene.register(nothing, Sigma { turn_deg: 1.0, shift_m }).unwrap_err();
        assert_eq!(refused, RegistrationError::UnusablePrior);
    }
    scene.source_in_body.truncate(100);
    let refused = scene.register(nothing, PRIOR).unwrap_err();
    assert!(matches!(refused, RegistrationError::TooFewPoints { cloud: "source", .. }));
}
