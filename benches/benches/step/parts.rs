//! Grid and filter with and without their extras, and the covariance's arithmetic.

use std::hint::black_box;

use criterion::Criterion;
use lodestone_benches::ledger::Ledger;
use lodestone_benches::readings::Load;
use lodestone_fusion::{
    ACCEL_BIAS, Alignment, Covariance, GYRO_BIAS, Grid, ImuSample, LEAKY_VELOCITY, LowPass, Mag,
    ORIENTATION, POSITION, Step, VELOCITY,
};

use super::{STRETCH, Walk, on_steps, per_sample};

/// Everything from a sample to an estimate.
pub(super) fn bench(criterion: &mut Criterion, ledger: &Ledger, load: &Load, walk: &Walk) {
    let smooth = Grid::new(load.settings.grid).with_low_pass(LowPass::new(40.0, 400.0));
    for (name, grid) in [("grid", walk.grid), ("grid with low-pass", smooth)] {
        criterion.bench_function(name, |b| {
            per_sample(b, ledger, name, &walk.samples, &grid, |grid, sample| {
                on_steps(grid, sample, |step| {
                    black_box(step);
                });
            });
        });
    }
    low_pass(criterion, ledger, walk);
    alignment(criterion, ledger, load, walk);
    estimator(criterion, ledger, walk);
}

fn low_pass(criterion: &mut Criterion, ledger: &Ledger, walk: &Walk) {
    let Some(filter) = LowPass::new(40.0, 400.0) else { return };
    let name = "low-pass alone";
    criterion.bench_function(name, |b| {
        per_sample(b, ledger, name, &walk.samples, &filter, |filter, sample: &ImuSample| {
            black_box(filter.filter(sample, 0));
        });
    });
}

/// A camera that walks is never done with it, so each step is one more.
fn alignment(criterion: &mut Criterion, ledger: &Ledger, load: &Load, walk: &Walk) {
    let (begun, name) = (Alignment::new(), "alignment");
    criterion.bench_function(name, |b| {
        per_sample(b, ledger, name, &walk.steps, &begun, |alignment, step| {
            black_box(alignment.push(step, &load.settings.estimator));
        });
    });
}

fn estimator(criterion: &mut Criterion, ledger: &Ledger, walk: &Walk) {
    let of = |mag: fn(&Step) -> Option<Mag<_>>| -> Vec<Step> {
        walk.steps.iter().map(|step| Step { mag: mag(step), ..*step }).collect()
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
            per_sample(b, ledger, name, &steps, &walk.estimator, |estimator, step| {
                black_box(estimator.step(step));
            });
        });
    }
    criterion.bench_function("estimate", |b| {
        per_sample(b, ledger, "estimate", &walk.steps, &walk.estimator, |estimator, _| {
            black_box(estimator.estimate());
        });
    });
}

/// What prediction and one scalar update do to the covariance.
pub(super) fn covariance(criterion: &mut Criterion, ledger: &Ledger) {
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
