//! What a person who turns the camera is told on the way.
#![allow(unreachable_pub, dead_code, reason = "the simulator serves several tests")]

mod simulator;

use lodestone_calibration::{Limits, Missing, Progress, Sample, Settings, calibrate, thinned};
use simulator::{Scene, Tilt};

fn progress(samples: &[Sample]) -> Progress {
    let attempt = calibrate(&thinned(samples, 4), &Settings::default());
    Progress::of(&attempt, &Limits::default(), 0.3)
}

#[test]
fn it_grows_from_nothing_to_complete_and_tells_what_is_missing() {
    let scene = Scene { rate_hz: 400.0, mag_every: 8, ..Scene::yardstick(Tilt::Rock(8.0)) };
    let (samples, _) = scene.draw(1);
    let seen: Vec<_> = [5, 20, 60, 119].iter().map(|s| progress(&samples[..s * 400])).collect();
    assert!(matches!(seen[0].missing[..], [Missing::Duration { .. }]), "{seen:?}");
    assert!(matches!(seen[1].missing[0], Missing::Circle { .. }), "{seen:?}");
    assert!(seen.windows(2).all(|pair| pair[0].ratio <= pair[1].ratio), "{seen:?}");
    assert!(!seen[1].is_complete() && seen[3].is_complete(), "{seen:?}");
}

#[test]
fn a_thinned_recording_promises_what_the_whole_one_does() {
    let scene = Scene { rate_hz: 400.0, mag_every: 8, ..Scene::yardstick(Tilt::Rock(8.0)) };
    let (samples, _) = scene.draw(2);
    let thin = thinned(&samples, 4);
    assert!((samples.len() / 5..=samples.len() / 3).contains(&thin.len()), "{}", thin.len());
    let sigma = |samples: &[Sample]| {
        let outcome = calibrate(samples, &Settings::default()).expect("it can tell");
        outcome.magnetometer.heading_sigma_deg
    };
    let (quick, whole) = (sigma(&thin), sigma(&samples));
    assert!((quick / whole - 1.0).abs() < 0.3, "{quick} {whole}");
}
