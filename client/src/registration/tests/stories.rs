//! What must be found, and what must be refused.

use glam::DVec3;

use super::room::{Room, camera};
use super::scene::{Pose, Scene, Sigma, error};
use crate::registration::RegistrationError;

const PRIOR: Sigma = Sigma { turn_deg: 1.5, shift_m: 0.1 };

fn two_places() -> ([Pose; 2], Pose) {
    let mapped = [camera([-1.5, -1.0, 1.3], 0.5, 0.1), camera([-1.5, -0.8, 1.3], -0.3, 0.2)];
    (mapped, camera([-1.0, 0.4, 1.2], 0.1, 0.15))
}

#[test]
fn a_room_seen_from_two_places_comes_together() {
    let (mapped, truth) = two_places();
    for seed in 0..10 {
        let mut scene = Scene::new(&Room::furnished(), &mapped, truth, seed);
        let away = PRIOR.draw(&mut scene.rng);
        let found = scene.register(away, PRIOR).unwrap();
        let fix = found.fix().unwrap();
        let (turn, shift) = error(fix.world_from_body, truth);
        println!("{seed}: {:.3}° {:.1} mm {:?}", turn.length().to_degrees(), shift.length() * 1e3, found.statistics);
        assert!(turn.length().to_degrees() < 0.1, "{seed}: {turn}");
        assert!(shift.length() < 0.006, "{seed}: {shift}");
        assert!(found.statistics.rmse_after_m < found.statistics.rmse_before_m);
    }
}

#[test]
fn a_corridor_is_refused() {
    let corridor = Room::boxes(&[([-50.0, -1.0, 0.0], [50.0, 1.0, 2.5])]);
    let mapped = [camera([0.0, 0.0, 1.3], 0.0, 0.0), camera([0.0, 0.2, 1.3], 0.4, 0.0)];
    let scene = Scene::new(&corridor, &mapped, camera([0.5, 0.0, 1.2], 0.1, 0.0), 1);
    let found = scene.register((DVec3::ZERO, DVec3::new(0.05, 0.05, 0.0)), PRIOR).unwrap();
    let refused = found.fix().unwrap_err();
    println!("{refused} {:?}", found.statistics);
    assert!(matches!(&refused, RegistrationError::Degenerate { unseen } if unseen.len() == 1));
}

#[test]
#[ignore = "figures"]
fn nees() {
    let (mapped, truth) = two_places();
    let (mut post, mut alone, mut n) = (0.0, 0.0, 0);
    let mut worst: f64 = 0.0;
    let mut bias = (DVec3::ZERO, DVec3::ZERO);
    let start = std::time::Instant::now(); let mut took = 0.0; let _ = start;
    for seed in 0..100 {
        let b = std::time::Instant::now();
        let mut scene = Scene::new(&Room::furnished(), &mapped, truth, seed);
        if seed == 0 { println!("scene {:?} {} planes", b.elapsed(), scene.target.len()); }
        let away = PRIOR.draw(&mut scene.rng);
        let t = std::time::Instant::now();
        let found = scene.register(away, PRIOR).unwrap();
        took += t.elapsed().as_secs_f64();
        let Ok(fix) = found.fix() else { println!("{seed}: {:?}", found.fix()); continue };
        let nees = |e: &crate::registration::PoseEstimate| {
            let (turn, shift) = error(e.world_from_body, truth);
            let x = crate::registration::prior::stack(turn, shift);
            x.dot(&e.covariance.matrix().cholesky().unwrap().solve(&x)) / 6.0
        };
        post += nees(&found.posterior);
        alone += nees(&fix);
        worst = worst.max(nees(&fix));
        n += 1;
        let (turn, shift) = error(fix.world_from_body, truth);
        bias.0 += turn.map(f64::to_degrees) / 100.0;
        bias.1 += shift * 10.0;
        if seed < 3 {
            let (turn, shift) = error(fix.world_from_body, truth);
            println!("{seed}: {:.3}° {:.1} mm nees {:.2} σ {:.3}° {:.1}mm {:?}", turn.length().to_degrees(), shift.length() * 1e3, nees(&fix), crate::covariance::trace(&fix.covariance.orientation_rad2).sqrt().to_degrees(), crate::covariance::trace(&fix.covariance.position_m2).sqrt()*1e3, found.statistics);
        }
    }
    println!("n {n} posterior {:.2} alone {:.2} worst {worst:.2} bias ° {:.3} mm {:.1} took {:.1} ms, all {:.1} s", post / f64::from(n), alone / f64::from(n), bias.0, bias.1, took*10.0, start.elapsed().as_secs_f64());
}
