//! What a rig of three cameras adds: the vote, the virtual IMU, and the whole.

use std::hint::black_box;

use criterion::Criterion;
use glam::DVec3;
use lodestone_benches::ledger::Ledger;
use lodestone_fusion::Step;
use lodestone_fusion::blocks::RigBlocks;
use lodestone_fusion::rig::{Geometry, MAX_MEMBERS, Mounting, RigEstimator, RigParameters};

use super::{Walk, per_sample};

const MEMBERS: [[f64; 3]; 3] = [[0.3, 0.0, 0.0], [-0.15, 0.25, 0.0], [-0.15, -0.25, 0.0]];

type Row = [Option<Step>; MAX_MEMBERS];

pub(super) fn bench(criterion: &mut Criterion, ledger: &Ledger, walk: &Walk) {
    let mounting = |place: [f64; 3]| {
        let at = DVec3::from_array(place);
        Mounting { imu_m: at, magnetometer_m: at, ..Mounting::CENTRED }
    };
    let geometry = Geometry::new(&MEMBERS.map(mounting)).expect("three members");
    let rows: Vec<Row> = walk.steps.iter().map(row).collect();
    let parameters = RigParameters::default();
    let blocks = RigBlocks::new(geometry, &parameters);
    let name = "rig of three: vote";
    criterion.bench_function(name, |b| {
        per_sample(b, ledger, name, &rows, &blocks, |rig, row| {
            black_box(rig.vote(row));
        });
    });
    let name = "rig of three: virtual IMU";
    criterion.bench_function(name, |b| {
        per_sample(b, ledger, name, &rows, &blocks, |rig, row| {
            black_box(rig.virtual_imu(row));
        });
    });
    // Aligned and moving, as it comes out of a first pass over the walk.
    let mut rig = RigEstimator::new(geometry, parameters);
    for row in rows.iter().cycle().take(4 * rows.len()) {
        rig.step(row);
    }
    assert!(rig.estimate().is_some(), "it aligns while it walks");
    let name = "rig of three: whole step";
    criterion.bench_function(name, |b| {
        per_sample(b, ledger, name, &rows, &rig, |rig, row| {
            black_box(rig.step(row));
        });
    });
}

/// One camera's step as three would have it, each with an offset of its own.
fn row(step: &Step) -> Row {
    std::array::from_fn(|k| {
        (k < MEMBERS.len()).then(|| {
            let mut own = *step;
            own.increment.velocity += DVec3::splat(1e-5 * (k as f64 - 1.0));
            own
        })
    })
}
