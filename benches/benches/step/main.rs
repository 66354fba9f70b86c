//! One sample through the lane's core, and each of its building blocks, beside VQF on the same samples.
//!
//! Every subject takes the same stretch of a walk: it starts aligned and moving, from a copy of its
//! state, so that each iteration does the same work. Times are per sample, or per call of a block.

mod blocks;
mod parts;
mod rig;

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Bencher, Criterion};
use lodestone_benches::ledger::Ledger;
use lodestone_benches::readings::Load;
use lodestone_benches::vqf::VqfLane;
use lodestone_config::model::TrajectoryKind;
use lodestone_daemon::lane::Core;
use lodestone_daemon::reading::Reading;
use lodestone_fusion::{Estimator, Grid, ImuSample, Step};

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
    let walk = Walk::of(&load);
    parts::bench(&mut criterion, &ledger, &load, &walk);
    parts::covariance(&mut criterion, &ledger);
    blocks::bench(&mut criterion, &ledger, &load, &walk);
    rig::bench(&mut criterion, &ledger, &walk);
    criterion.final_summary();
    ledger.print_ratios(PEER);
}

/// The stretch as its parts see it, and the filter and grid that come to it.
struct Walk {
    /// Calibrated samples in the body frame.
    samples: Vec<ImuSample>,
    /// The grid's steps.
    steps: Vec<Step>,
    grid: Grid,
    estimator: Estimator,
}

impl Walk {
    fn of(load: &Load) -> Self {
        let condition = |reading| load.settings.conditioner.condition(reading);
        let samples: Vec<ImuSample> = load.readings.iter().map(condition).collect();
        let (before, stretch) = samples.split_at(BEFORE);
        let mut grid = Grid::new(load.settings.grid);
        let mut estimator = Estimator::new(load.settings.estimator);
        for sample in before {
            on_steps(&mut grid, sample, |step| {
                estimator.step(step);
            });
        }
        let (mut steps, mut stretched) = (Vec::new(), grid);
        for sample in stretch {
            on_steps(&mut stretched, sample, |step| steps.push(*step));
        }
        Self { samples: stretch.to_vec(), steps, grid, estimator }
    }
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
