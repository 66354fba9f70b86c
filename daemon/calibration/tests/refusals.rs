//! Recordings that cannot tell are refused, with what is missing.
#![allow(unreachable_pub, dead_code, reason = "the simulator serves several tests")]

mod simulator;

use glam::{DVec3, Vec3Swizzles as _};
use lodestone_calibration::{Missing, Refusal, Sample, Settings, calibrate};
use simulator::{Motion, Scene, Tilt, Unit, unit};

fn refused(samples: &[Sample]) -> Refusal {
    match calibrate(samples, &Settings::default()) {
        Ok(outcome) => panic!("accepted: {outcome:?}"),
        Err(refusal) => refusal,
    }
}

fn refused_scene(scene: &Scene, seed: u64) -> Refusal {
    refused(&scene.draw(seed).0)
}

#[test]
fn standing_still_lacks_the_circle() {
    for seed in 0..3 {
        let scene = Scene { turns: 0.0, ..Scene::yardstick(Tilt::None) };
        let refusal = refused_scene(&scene, seed);
        assert!(matches!(refusal.missing[0], Missing::Circle { seen_deg, .. } if seen_deg < 30.0));
        assert!(refusal.to_string().contains("turn through a whole circle"), "{refusal}");
    }
}

#[test]
fn rocking_on_the_spot_lacks_the_circle() {
    for seed in 0..3 {
        let scene = Scene { turns: 0.0, ..Scene::yardstick(Tilt::Rock(10.0)) };
        let refusal = refused_scene(&scene, seed);
        assert!(matches!(refusal.missing[0], Missing::Circle { seen_deg, .. } if seen_deg < 60.0));
    }
}

#[test]
fn a_level_turn_lacks_the_tilt() {
    for seed in 0..3 {
        let refusal = refused_scene(&Scene::yardstick(Tilt::None), seed);
        let [Missing::Tilt { seen_deg, heading_sigma_deg, .. }] = refusal.missing[..] else {
            panic!("{refusal}");
        };
        assert!(seen_deg < 1.0 && heading_sigma_deg > 2.0, "{refusal}");
    }
}

#[test]
fn a_hardly_tilted_turn_lacks_the_tilt_too() {
    let refusal = refused_scene(&Scene::yardstick(Tilt::Cone(0.5)), 5);
    assert!(matches!(refusal.missing[..], [Missing::Tilt { .. }]), "{refusal}");
}

#[test]
fn half_a_circle_lacks_the_other_half() {
    for (seed, tilt) in [(0, Tilt::Rock(5.0)), (1, Tilt::Cone(10.0)), (2, Tilt::Slow(10.0))] {
        let refusal = refused_scene(&Scene { turns: 0.5, ..Scene::yardstick(tilt) }, seed);
        let Missing::Circle { seen_deg, .. } = refusal.missing[0] else { panic!("{refusal}") };
        assert!((150.0..=240.0).contains(&seen_deg), "{refusal}");
    }
}

#[test]
fn a_strong_disturbance_in_the_middle_is_iron_to_keep_away_from() {
    let scene = Scene::yardstick(Tilt::Rock(10.0));
    for seed in 0..3 {
        let mut disturbed = Unit::drawn(seed);
        disturbed.disturbance = Some((50.0, 75.0, DVec3::new(15.0, -20.0, 10.0)));
        let motion = Motion::drawn(&scene, seed);
        let refusal = refused(&unit::record(&scene, &disturbed, &motion, seed));
        let Missing::Disturbance { from_s, to_s, percent } = refusal.missing[0] else {
            panic!("{refusal}");
        };
        assert!((from_s - 50.0).abs() < 1.0 && (to_s - 75.0).abs() < 1.0, "{refusal}");
        assert!((15.0..25.0).contains(&percent), "{refusal}");
    }
}

#[test]
fn a_short_recording_lacks_duration() {
    let scene = Scene { duration_s: 8.0, ..Scene::yardstick(Tilt::Tumble) };
    let refusal = refused_scene(&scene, 1);
    assert!(matches!(refusal.missing[..], [Missing::Duration { .. }]), "{refusal}");
}

#[test]
fn nothing_and_nonsense_are_refused_without_a_panic() {
    assert!(matches!(refused(&[]).missing[0], Missing::Duration { .. }));
    let (mut samples, _) = Scene::yardstick(Tilt::Cone(5.0)).draw(3);
    for sample in &mut samples {
        sample.mag_ut = None;
    }
    assert!(matches!(refused(&samples).missing[..], [Missing::Magnetometer { seen: 0, .. }]));
    for huge in [f64::NAN, f64::INFINITY, 1e300, -1e30] {
        for sample in &mut samples {
            sample.mag_ut = Some(DVec3::splat(huge));
        }
        refused(&samples);
        for sample in &mut samples {
            sample.gyro_rad_s = DVec3::splat(huge);
        }
        refused(&samples);
    }
}

#[test]
fn axes_that_do_not_belong_together_are_a_contradiction() {
    let (mut samples, _) = Scene::yardstick(Tilt::Tumble).draw(4);
    for sample in &mut samples {
        sample.mag_ut = sample.mag_ut.map(DVec3::yxz);
    }
    let refusal = refused(&samples);
    assert!(
        refusal.missing.iter().any(|m| matches!(m, Missing::Contradiction { .. })),
        "{refusal}"
    );
}
