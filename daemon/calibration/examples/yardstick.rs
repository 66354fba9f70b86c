//! The yardstick: how good calibrations of simulated recordings are, and how honest.
//!
//! `cargo run --release -p lodestone-calibration --example yardstick -- [DRAWS]`

#[allow(unreachable_pub, dead_code, reason = "the tests share it")]
#[path = "../tests/simulator/mod.rs"]
mod simulator;

use std::time::Instant;

use lodestone_calibration::{Settings, calibrate};
use simulator::{Scene, Tilt};

fn main() {
    let draws = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(20);
    println!("heading RMS on fresh data, degrees, of {draws} draws each");
    println!(
        "{:34}{:>8}{:>8}{:>8}{:>9}{:>9}{:>8}{:>8}",
        "movement", "median", "90 %", "worst", "mean σ", "in 2σ %", "failed", "s each"
    );
    for (name, scene) in scenes() {
        println!("{name:34}{}", row(&scene, draws));
    }
}

fn scenes() -> Vec<(String, Scene)> {
    let base = Scene::yardstick;
    let fast = |scene: Scene| Scene { rate_hz: 400.0, mag_every: 8, ..scene };
    let mut scenes = Vec::new();
    for tilt in [Tilt::Cone(5.0), Tilt::Rock(5.0), Tilt::Slow(5.0)] {
        scenes.push((format!("{tilt:?}"), base(tilt)));
    }
    for tilt in [Tilt::Cone(10.0), Tilt::Rock(10.0), Tilt::Slow(10.0), Tilt::Tumble] {
        scenes.push((format!("{tilt:?}"), base(tilt)));
    }
    let mean = Scene { mean_rate: true, ..base(Tilt::Cone(5.0)) };
    scenes.push(("Cone(5.0), mean rates".into(), mean));
    let mean = Scene { mean_rate: true, ..base(Tilt::Tumble) };
    scenes.push(("Tumble, mean rates".into(), mean));
    scenes.push(("Cone(5.0), IMU at 400 Hz".into(), fast(base(Tilt::Cone(5.0)))));
    scenes.push(("Tumble, IMU at 400 Hz".into(), fast(base(Tilt::Tumble))));
    let rest = Scene { rest_s: 5.0, ..base(Tilt::Rock(5.0)) };
    scenes.push(("Rock(5.0) after 5 s of rest".into(), rest));
    let noisy = Scene { noise_scale: 5.0, ..base(Tilt::Cone(5.0)) };
    scenes.push(("Cone(5.0), IMU noise × 5".into(), noisy));
    let noisy = Scene { noise_scale: 5.0, ..base(Tilt::Slow(10.0)) };
    scenes.push(("Slow(10.0), IMU noise × 5".into(), noisy));
    let noisy = Scene { noise_scale: 5.0, ..base(Tilt::Tumble) };
    scenes.push(("Tumble, IMU noise × 5".into(), noisy));
    scenes
}

fn row(scene: &Scene, draws: u64) -> String {
    let (mut errors, mut sigma, mut covered) = (Vec::new(), 0.0, 0u64);
    let begin = Instant::now();
    for seed in 0..draws {
        let (samples, unit) = scene.draw(seed);
        match calibrate(&samples, &Settings::default()) {
            Ok(outcome) => {
                let error = scene.heading_error_deg(&unit, &outcome, seed);
                let stated = outcome.magnetometer.heading_sigma_deg;
                sigma += stated;
                covered += u64::from(error <= 2.0 * stated);
                errors.push(error);
            }
            Err(refusal) => eprintln!("  seed {seed}: {refusal}"),
        }
    }
    errors.sort_by(f64::total_cmp);
    let count = errors.len().max(1) as f64;
    let at = |part: f64| errors.get(((count - 1.0) * part).round() as usize).copied();
    let number = |value: Option<f64>| value.map_or("-".into(), |v| format!("{v:.3}"));
    format!(
        "{:>8}{:>8}{:>8}{:>9.3}{:>9.0}{:>8}{:>8.2}",
        number(at(0.5)),
        number(at(0.9)),
        number(at(1.0)),
        sigma / count,
        100.0 * covered as f64 / count,
        draws - errors.len() as u64,
        begin.elapsed().as_secs_f64() / draws as f64
    )
}
