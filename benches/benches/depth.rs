//! What a point of a synthetic depth source costs: ray, colour, noise, and writing it.
//!
//! The embedded room from where its first camera begins, turned all round, 100,000 points each. Times are
//! per point. The peer is what one would write first: sphere tracing (Hart 1996) along each ray by the
//! distance to the nearest surface, in f64; it has neither colour nor noise.

use std::convert::Infallible;
use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Bencher, Criterion};
use glam::{DQuat, DVec3, EulerRot};
use lodestone_benches::ledger::Ledger;
use lodestone_client::{Body, CloudPoint, Rotation, Transform, World, body_from_optical_axes};
use lodestone_config::Config;
use lodestone_config::model::{Camera, Depth};
use lodestone_daemon::scene::{DepthCamera, Frame, Scene};

const PEER: &str = "peer: sphere tracing in f64";
/// Views all round.
const VIEWS: u32 = 16;
/// The peer casts every so manyth ray.
const EVERY: usize = 64;

fn main() {
    let mut criterion = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(3))
        .configure_from_args();
    let ledger = Ledger::default();
    let config = Config::embedded();
    let scene = Scene::new(config.scene.as_ref().expect("a room"));
    for (name, depth) in [
        ("exposed, rows at their times", Depth::default()),
        ("exposed, all at once", Depth { rolling_shutter_s: 0.0, ..Depth::default() }),
        ("exposed, without noise", Depth { sigma_per_m: 0.0, ..Depth::default() }),
    ] {
        let camera = DepthCamera::new(&Camera { depth: Some(depth), ..Camera::default() }, 0);
        criterion.bench_function(name, |b| exposed(b, &ledger, name, (&camera, &scene)));
    }
    criterion.bench_function(PEER, |b| traced(b, &ledger, &scene));
    criterion.final_summary();
    ledger.print_ratios(PEER);
}

/// Where a view looks from.
fn pose(view: u32) -> Transform<World, Body> {
    let yaw = std::f64::consts::TAU * f64::from(view) / f64::from(VIEWS);
    let turn = DQuat::from_euler(EulerRot::ZYX, yaw, 0.09, 0.02);
    let rotation = Rotation::from_quaternion(turn).expect("a unit quaternion");
    Transform::new(rotation, DVec3::new(0.2, -0.3, 0.05))
}

fn exposed(
    bencher: &mut Bencher<'_>,
    ledger: &Ledger,
    name: &str,
    (camera, scene): (&DepthCamera, &Scene),
) {
    let nothing = CloudPoint { position_m: [f32::NAN; 3], time_offset_ns: 0, colour: [0; 4] };
    let mut cloud = vec![nothing; camera.points()];
    bencher.iter_custom(|rounds| {
        let begin = Instant::now();
        for round in 0..rounds {
            let frame = Frame { number: round, time_ns: round.cast_signed() * 66_666_667 };
            let place = pose(round as u32 % VIEWS);
            let Ok(()) = camera.expose(scene, frame, |_| Ok::<_, Infallible>(place), &mut cloud);
            black_box(&mut cloud);
        }
        let total = begin.elapsed();
        ledger.add(name, total, rounds * camera.points() as u64);
        total.div_f64(camera.points() as f64)
    });
}

fn traced(bencher: &mut Bencher<'_>, ledger: &Ledger, scene: &Scene) {
    let (width, height) = (Depth::default().width, Depth::default().height);
    let focal_px = 0.5 * width as f64;
    let rays: Vec<DVec3> = (0..width * height)
        .step_by(EVERY)
        .map(|pixel| {
            let (column, row) = (pixel % width, pixel / width);
            let x = (column as f64 + 0.5 - 0.5 * width as f64) / focal_px;
            let y = (row as f64 + 0.5 - 0.5 * height as f64) / focal_px;
            DVec3::new(x, y, 1.0).normalize()
        })
        .collect();
    bencher.iter_custom(|rounds| {
        let begin = Instant::now();
        for round in 0..rounds {
            let place = pose(round as u32 % VIEWS) * body_from_optical_axes();
            for ray in &rays {
                black_box(trace(scene, place.origin(), place.rotation().apply(*ray)));
            }
        }
        let total = begin.elapsed();
        ledger.add(PEER, total, rounds * rays.len() as u64);
        total.div_f64(rays.len() as f64)
    });
}

/// Goes on along a ray by the distance to the nearest surface, until there is none to speak of.
fn trace(scene: &Scene, origin: DVec3, direction: DVec3) -> f64 {
    let mut length_m = 0.0;
    for _ in 0..200 {
        let free_m = scene.distance_m(origin + direction * length_m, Some(0));
        length_m += free_m;
        if free_m < 1e-4 {
            break;
        }
    }
    length_m
}
