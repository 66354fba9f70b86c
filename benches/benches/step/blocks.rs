//! The filter's building blocks one by one.

use std::hint::black_box;

use criterion::Criterion;
use lodestone_benches::ledger::Ledger;
use lodestone_benches::readings::Load;
use lodestone_fusion::Step;
use lodestone_fusion::blocks::Blocks;

use super::{Walk, per_sample};

/// What a block does with a step.
type Call = fn(&mut Blocks, &Step);

/// Those that change the covariance also restore its symmetry now and then in the filter; it is timed by
/// itself here.
const BLOCKS: [(&str, Call); 6] = [
    ("predict: state", |blocks, step| {
        black_box(blocks.predict(&step.increment));
    }),
    ("predict: state and covariance", |blocks, step| {
        blocks.predict(&step.increment);
        blocks.follow();
    }),
    ("levelling update", |blocks, _| {
        black_box(blocks.level());
    }),
    ("compass update", |blocks, step| {
        let field = step.mag.map_or(glam::DVec3::new(20.0, 5.0, -40.0), |mag| mag.vector);
        black_box(blocks.compass(field));
    }),
    ("standstill: search and updates", |blocks, step| {
        black_box(blocks.standstill(&step.increment));
    }),
    ("covariance, symmetry restored", |blocks, _| blocks.restore()),
];

pub(super) fn bench(criterion: &mut Criterion, ledger: &Ledger, load: &Load, walk: &Walk) {
    let taken_apart = Blocks::of(&walk.estimator, &load.settings.estimator);
    let start = taken_apart.expect("the walk begins aligned");
    for (name, call) in BLOCKS {
        criterion.bench_function(name, |b| {
            per_sample(b, ledger, name, &walk.steps, &start, call);
        });
    }
}
