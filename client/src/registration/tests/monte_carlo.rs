//! Errors must be as large as the covariance says.

use glam::DVec3;

use super::room::{Room, camera};
use super::scene::{Pose, Scene, Sigma, error};
use crate::registration::PoseEstimate;
use crate::registration::prior::stack;

/// All of them in release; a quarter does where the same takes many times as long.
const SEEDS: u64 = if cfg!(debug_assertions) { 25 } else { 100 };

/// Normalised estimation error squared, for each of six degrees of freedom; 1 if the covariance is true.
fn nees(estimate: &PoseEstimate, truth: Pose) -> f64 {
    let (turn, shift) = error(estimate.world_from_body, truth);
    let error = stack(turn, shift);
    let factor = estimate.covariance.matrix().cholesky().unwrap();
    error.dot(&factor.solve(&error)) / 6.0
}

/// Three cameras near each other that look across the room, elsewhere for each seed: the last one is the
/// one to find.
fn places(seed: u64) -> [Pose; 3] {
    let at = |i: u64| (seed as f64 * 0.618 + i as f64 * 0.37).fract() - 0.5;
    let yaw = at(4) * 6.0;
    let back = DVec3::new(-1.8 * yaw.cos(), -1.4 * yaw.sin(), 1.3);
    let near = |i: u64| (back + DVec3::new(at(i), at(i + 1), at(i + 2)) * 0.6).to_array();
    [
        camera(near(1), yaw + 0.4, 0.1),
        camera(near(1), yaw - 0.4, 0.1),
        camera(near(5), yaw, 0.2 * at(8)),
    ]
}

#[test]
fn errors_are_as_large_as_the_covariance_says() {
    let sigma = Sigma { turn_deg: 1.0, shift_m: 0.05 };
    let (mut posterior, mut alone, mut refused) = (0.0, 0.0, 0.0);
    let mut square = (DVec3::ZERO, DVec3::ZERO);
    for seed in 0..SEEDS {
        let [mapped @ .., truth] = places(seed);
        let mut scene = Scene::new(&Room::furnished(), &mapped, truth, seed);
        let away = sigma.draw(&mut scene.rng);
        let found = scene.register(away, sigma).unwrap();
        let Ok(fix) = found.fix() else {
            println!("{seed}: {}", found.fix().unwrap_err());
            refused += 1.0;
            continue;
        };
        posterior += nees(&found.posterior, truth);
        alone += nees(&fix, truth);
        let (turn, shift) = error(fix.world_from_body, truth);
        square = (square.0 + turn * turn, square.1 + shift * shift);
    }
    let count = SEEDS as f64 - refused;
    let (posterior, alone) = (posterior / count, alone / count);
    let rms = (square.0 / count).map(f64::sqrt).map(f64::to_degrees);
    println!("{count} of {SEEDS}: NEES/dof {posterior:.2} with prior, {alone:.2} without");
    println!("errors (rms): {rms:.3}°, {:.4} m", (square.1 / count).map(f64::sqrt));
    assert!(refused <= 0.05 * SEEDS as f64, "{refused} refused");
    assert!((0.3..2.0).contains(&posterior), "{posterior}");
    assert!((0.3..2.0).contains(&alone), "{alone}");
}
