//! One sample through the lane's core, and its parts, beside VQF on the same samples.
//!
//! Every subject takes the same stretch of a walk: it starts aligned and moving, from a copy of its
//! state, so that each iteration does the same work. Times are per sample.

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Bencher, Criterion};
use lodestone_benches::ledger::Ledger;
use lodestone_benches::readings::Load;
use lodestone_benches::vqf::VqfLane;
use lodestone_config::model::TrajectoryKind;
use lodestone_daemon::lane::Core;
use lodestone_daemon::reading::Reading;
use lodestone_fusion::{ACCEL_BIAS, GYRO_BIAS, LEAKY_VELOCITY, ORIENTATION, POSITION, VELOCITY};
use lodestone_fusion::{Covariance, Estimator, Grid, ImuSample, Mag, Step};

const PEER: &str = "peer: vqf-rs";

/// Samples before the measured stretch: rest, alignment, first steps.
const BEFORE: usize = 2400;
/// Samples of the measured stretch.
const STRETCH: usize = 800;

fn main() {
    let load = Load::synthetic(TrajectoryKind::Walk, BEFORE + STRETCH).expect("the default world");
    let mut criterion = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(2))
        .configure_from_args();
    let ledger = Ledger::default();
    whole(&mut criterion, &ledger, &load);
    parts(&mut criterion, &ledger, &load);
    covariance(&mut criterion, &ledger);
    criterion.final_summary();
    ledger.print_ratios(PEER);
}

/// The lane's core and its peer.
fn whole(criterion: &mut Criterion, ledger: &Ledger, load: &Load) {
    let (before, stretch) = load.readings.split_at(BEFORE);
    let mut core = Core::new(&load.settings);
    for reading in before {
        core.take(reading, |_| {});
    }
    let over = |bencher: &mut Bencher<'_>, name: &str| {
        per_sample(bencher, ledger, name, stretch, &core, |core, reading: &Reading| {
            core.take(reading, |step| {
                black_box(step);
            });
        });
    };
    criterion.bench_function("lane core", |b| over(b, "lane core"));

    let mut peer = VqfLane::new(load);
    for reading in before {
        peer.take(reading);
    }
    criterion.bench_function(PEER, |b| {
        per_sample(b, ledger, PEER, stretch, &peer, |peer, reading| {
            black_box(peer.take(reading));
        });
    });
}

/// Grid, filter with and without magnetometer.
fn parts(criterion: &mut Criterion, ledger: &Ledger, load: &Load) {
    let samples: Vec<ImuSample> =
        load.readings.iter().map(|r| load.settings.conditioner.condition(r)).collect();
    let (before, stretch) = samples.split_at(BEFORE);
    let mut grid = Grid::new(load.settings.grid);
    let mut estimator = Estimator::new(load.settings.estimator);
    for sample in before {
        on_steps(&mut grid, sample, |step| {
            estimator.step(step);
        });
    }
    criterion.bench_function("grid", |b| {
        per_sample(b, ledger, "grid", stretch, &grid, |grid, sample| {
            on_steps(grid, sample, |step| {
                black_box(step);
            });
        });
    });

    let mut steps = Vec::new();
    let mut stretched = grid;
    for s in stretch {
        on_steps(&mut stretched, s, |step| steps.push(*step));
    }
    let of = |mag: fn(&Step) -> Option<Mag<_>>| -> Vec<Step> {
        steps.iter().map(|step| Step { mag: mag(step), ..*step }).collect()
    };
    for (name, steps) in [
        ("estimator step", of(|step| step.mag)),
        ("estimator step, no magnetometer", of(|_| None)),
        // The last field again with every step: the compass updates at its own interval.
        (
            "estimator step, field in every step",
            of(|step| step.mag.or(Some(Mag::new(glam::DVec3::new(20.0, 5.0, -40.0))))),
        ),
    ] {
        criterion.bench_function(name, |b| {
            per_sample(b, ledger, name, &steps, &estimator, |estimator, step| {
                black_box(estimator.step(step));
            });
        });
    }
    criterion.bench_function("estimate", |b| {
        per_sample(b, ledger, "estimate", &steps, &estimator, |estimator, _| {
            black_box(estimator.estimate());
        });
    });
}

/// What prediction and one scalar update do to the covariance.
fn covariance(criterion: &mut Criterion, ledger: &Ledger) {
    let mut start = Covariance::ZERO;
    for block in [ORIENTATION, VELOCITY, POSITION, GYRO_BIAS, ACCEL_BIAS, LEAKY_VELOCITY] {
        start.add_variances(block, glam::DVec3::splat(1e-2));
    }
    let times = [0_u8; STRETCH];
    let m = glam::DMat3::from_rotation_x(0.3) * 2.5e-3;
    let predict = |p: &mut Covariance, _: &u8| {
        p.shear_scalar(POSITION, 2.5e-3, VELOCITY);
        p.shear_alike([VELOCITY, LEAKY_VELOCITY], [(m, ORIENTATION), (m, ACCEL_BIAS)]);
        p.shear(ORIENTATION, m, GYRO_BIAS);
        p.scale(15, 3, 0.999);
        black_box(p);
    };
    let name = "covariance prediction";
    criterion.bench_function(name, |b| per_sample(b, ledger, name, &times, &start, predict));
    let mut row = [0.0; lodestone_fusion::STATES];
    row[2] = 1.0;
    let update = |p: &mut Covariance, _: &u8| {
        let ph = p.times(&row);
        p.deflate(&ph, ph[2] + 1.0);
        black_box(p);
    };
    let name = "covariance, one scalar update";
    criterion.bench_function(name, |b| per_sample(b, ledger, name, &times, &start, update));
}

fn on_steps(grid: &mut Grid, sample: &ImuSample, mut on_step: impl FnMut(&Step)) {
    if grid.push(*sample).is_ok() {
        while let Some(step) = grid.next_step() {
            on_step(&step);
        }
    }
}

/// Times whole stretches, each from a copy of `start`; making the copy is not timed.
fn per_sample<S: Clone, T>(
    bencher: &mut Bencher<'_>,
    ledger: &Ledger,
    name: &str,
    stretch: &[T],
    start: &S,
    mut take: impl FnMut(&mut S, &T),
) {
    bencher.iter_custom(|samples| {
        let stretches = samples.div_ceil(stretch.len() as u64);
        let mut total = Duration::ZERO;
        for _ in 0..stretches {
            let mut subject = black_box(start.clone());
            let begin = Instant::now();
            for item in stretch {
                take(&mut subject, black_box(item));
            }
            total += begin.elapsed();
        }
        let taken = stretches * stretch.len() as u64;
        ledger.add(name, total, taken);
        // Criterion asked for `samples` of them.
        total.mul_f64(samples as f64 / taken as f64)
    });
}
