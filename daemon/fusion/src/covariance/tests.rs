use proptest::prelude::*;

use super::*;
use crate::testing::{Dense, Normal};

const BLOCKS: [Block; 6] = [ORIENTATION, VELOCITY, POSITION, GYRO_BIAS, ACCEL_BIAS, LEAKY_VELOCITY];

/// A dense covariance with every correlation.
fn any_covariance(random: &mut Normal) -> Covariance {
    let root: [Row; STATES] = core::array::from_fn(|_| random.row(1.0));
    let root = Dense::from_fn(|i, j| root[i][j]);
    let product = root.times(&root.transposed());
    let rows = core::array::from_fn(|i| core::array::from_fn(|j| product.at(i.max(j), i.min(j))));
    Covariance { rows }
}

fn any_matrix(random: &mut Normal, sigma: f64) -> DMat3 {
    DMat3::from_cols(random.vector(sigma), random.vector(sigma), random.vector(sigma))
}

/// A row with a few entries, as measurements have.
fn any_sparse(random: &mut Normal) -> Row {
    let mut row = [0.0; STATES];
    for _ in 0..=random.below(4) {
        row[random.below(STATES)] = random.number();
    }
    row
}

fn product(p: &Covariance, h: &Row) -> Row {
    core::array::from_fn(|i| (0..STATES).map(|j| p.rows[i][j] * h[j]).sum())
}

fn inner(a: &Row, b: &Row) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// `(I − k hᵀ) P (I − k hᵀ)ᵀ + k r kᵀ`.
fn joseph(p: &Covariance, h: &Row, gain: &Row, r: f64) -> Dense {
    let kept = Dense::identity().plus(&Dense::outer(gain, h), -1.0);
    Dense::of(p).mapped(&kept).plus(&Dense::outer(gain, gain), r)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_shear_is_the_full_product(seed: u64, i in 0..6_usize, off in 1..6_usize) {
        let mut random = Normal::seeded(seed);
        let (i, j) = (BLOCKS[i], BLOCKS[(i + off) % 6]);
        let m = any_matrix(&mut random, 1.0);
        let mut p = any_covariance(&mut random);
        let mut f = Dense::identity();
        for r in 0..3 {
            for c in 0..3 {
                f.set(i.0 + r, j.0 + c, m.col(c)[r]);
            }
        }
        let expected = Dense::of(&p).mapped(&f);
        p.shear(i, m, j);
        prop_assert!(Dense::of(&p).relative_difference(&expected) < 1e-14);
    }

    #[test]
    fn a_scalar_shear_is_a_shear_by_a_diagonal(seed: u64, s in -2.0..2.0_f64) {
        let mut p = any_covariance(&mut Normal::seeded(seed));
        let mut f = Dense::identity();
        (0..3).for_each(|k| f.set(POSITION.0 + k, VELOCITY.0 + k, s));
        let expected = Dense::of(&p).mapped(&f);
        p.shear_scalar(POSITION, s, VELOCITY);
        prop_assert!(Dense::of(&p).relative_difference(&expected) < 1e-14);
    }

    #[test]
    fn a_scale_is_the_full_product(
        seed: u64,
        (first, count) in (0..STATES).prop_flat_map(|f| (Just(f), 0..=STATES - f)),
        s in -2.0..2.0_f64,
    ) {
        let mut p = any_covariance(&mut Normal::seeded(seed));
        let within = |i: usize| (first..first + count).contains(&i);
        let f = Dense::from_fn(|i, j| if i != j { 0.0 } else if within(i) { s } else { 1.0 });
        let expected = Dense::of(&p).mapped(&f);
        p.scale(first, count, s);
        prop_assert!(Dense::of(&p).relative_difference(&expected) < 1e-14);
    }

    #[test]
    fn times_is_the_product_with_a_column(seed: u64) {
        let mut random = Normal::seeded(seed);
        let p = any_covariance(&mut random);
        let h = any_sparse(&mut random);
        let (got, expected) = (p.times(&h), product(&p, &h));
        for k in 0..STATES {
            prop_assert!((got[k] - expected[k]).abs() < 1e-12);
        }
    }

    #[test]
    fn deflating_is_the_joseph_form_with_the_optimal_gain(seed: u64, exponent in -4.0..2.0_f64) {
        let mut random = Normal::seeded(seed);
        let mut p = any_covariance(&mut random);
        let h = any_sparse(&mut random);
        let r = 10_f64.powf(exponent);
        let ph = p.times(&h);
        let s = inner(&h, &ph) + r;
        let expected = joseph(&p, &h, &ph.map(|x| x / s), r);
        p.deflate(&ph, s);
        prop_assert!(Dense::of(&p).relative_difference(&expected) < 1e-12);
    }

    #[test]
    fn an_update_with_any_gain_is_the_joseph_form(seed: u64, exponent in -4.0..2.0_f64) {
        let mut random = Normal::seeded(seed);
        let mut p = any_covariance(&mut random);
        let h = any_sparse(&mut random);
        let gain = random.row(0.3);
        let r = 10_f64.powf(exponent);
        let ph = p.times(&h);
        let s = inner(&h, &ph) + r;
        let expected = joseph(&p, &h, &gain, r);
        p.update_with_gain(&ph, &gain, s);
        prop_assert!(Dense::of(&p).relative_difference(&expected) < 1e-12);
    }

    #[test]
    fn an_update_that_teaches_few_states_is_the_joseph_form(
        seed: u64,
        exponent in -4.0..2.0_f64,
        taught in prop::collection::vec(0..STATES, 0..7),
    ) {
        let mut random = Normal::seeded(seed);
        let mut p = any_covariance(&mut random);
        let h = any_sparse(&mut random);
        let all = random.row(0.3);
        let gain = core::array::from_fn(|k| if taught.contains(&k) { all[k] } else { 0.0 });
        let r = 10_f64.powf(exponent);
        let ph = p.times(&h);
        let s = inner(&h, &ph) + r;
        let expected = joseph(&p, &h, &gain, r);
        p.update_few(&ph, &gain, s);
        prop_assert!(Dense::of(&p).relative_difference(&expected) < 1e-12);
    }

    #[test]
    fn an_independent_block_keeps_no_correlation(seed: u64, i in 0..6_usize) {
        let mut random = Normal::seeded(seed);
        let mut p = any_covariance(&mut random);
        let before = p;
        let m = any_matrix(&mut random, 1.0);
        let own = m * m.transpose();
        let block = BLOCKS[i];
        p.set_independent(block, own);
        prop_assert_eq!(p.block(block, block), own);
        for other in BLOCKS.into_iter().filter(|b| *b != block) {
            prop_assert_eq!(p.block(block, other), DMat3::ZERO);
            prop_assert_eq!(p.block(other, block), DMat3::ZERO);
            prop_assert_eq!(p.block(other, other), before.block(other, other));
        }
    }

    #[test]
    fn noise_goes_to_the_diagonal_alone(seed: u64, v in 0.0..9.0_f64) {
        let mut random = Normal::seeded(seed);
        let p = any_covariance(&mut random);
        let mut q = p;
        q.add_variances(GYRO_BIAS, DVec3::new(v, 2.0 * v, 3.0 * v));
        q.add_variance(DEVIATION, v);
        let added = Dense::of(&q).plus(&Dense::of(&p), -1.0);
        let expected = Dense::from_fn(|i, j| match (i == j, i) {
            (true, 9..=11) => v * (i - 8) as f64,
            (true, DEVIATION) => v,
            _ => 0.0,
        });
        prop_assert!(added.plus(&expected, -1.0).largest() < 1e-13);
    }
}

/// One random operation of those the filter does, at the filter's sizes.
fn disturb(p: &mut Covariance, random: &mut Normal) {
    match random.below(5) {
        0 | 1 => {
            let i = random.below(6);
            let j = (i + 1 + random.below(5)) % 6;
            p.shear(BLOCKS[i], any_matrix(random, 0.02), BLOCKS[j]);
        }
        2 => p.scale(random.below(STATES - 2), 3, 0.999),
        3 => p.add_variances(BLOCKS[random.below(6)], random.vector(1e-3).abs()),
        _ => {
            let h = any_sparse(random);
            let ph = p.times(&h);
            // From far better to far worse than what is known.
            let r = 10_f64.powf(3.0 * random.number() - 4.0).clamp(1e-10, 1e4);
            p.deflate(&ph, inner(&h, &ph) + r);
        }
    }
    p.restore();
}

#[test]
fn long_sequences_keep_it_symmetric_and_positive() {
    for seed in 0..4 {
        let mut random = Normal::seeded(seed);
        let mut p = any_covariance(&mut random);
        for round in 0..3_000 {
            disturb(&mut p, &mut random);
            if round % 100 == 0 {
                let dense = Dense::of(&p);
                assert!(p.is_finite() && dense.is_symmetric(), "seed {seed}, round {round}");
                assert!(dense.is_positive_semidefinite(1e-9), "seed {seed}, round {round}");
            }
        }
    }
}

#[test]
fn restoring_lifts_the_diagonal() {
    let mut p = Covariance::ZERO;
    p.rows[7][7] = -1e-20;
    p.restore();
    assert!((0..STATES).all(|i| p.variance(i) > 0.0));
}

#[test]
fn one_entry_that_is_not_finite_is_noticed() {
    for bad in [f64::NAN, f64::INFINITY] {
        let mut p = Covariance::ZERO;
        assert!(p.is_finite());
        p.set(18, 4, bad);
        assert!(!p.is_finite());
    }
}
