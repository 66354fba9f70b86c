//! Both halves of the matrix stay equal, whatever the filter does to it: not a bit apart but for the
//! sign of a zero.

use proptest::prelude::*;

use super::*;

const BLOCKS: [Block; 6] = [ORIENTATION, VELOCITY, POSITION, GYRO_BIAS, ACCEL_BIAS, LEAKY_VELOCITY];

#[derive(Clone, Debug)]
enum Operation {
    Shear(usize, usize, [f64; 9]),
    ShearScalar(usize, usize, f64),
    ShearAlike([f64; 9], [f64; 9]),
    Scale(usize, usize, f64),
    Deflate([f64; 3], f64),
    AnyGain([f64; 3], f64),
    FewGains([f64; 3], f64),
    Noise(usize, f64),
}

fn operation() -> impl Strategy<Value = Operation> {
    let number = || -1.0..1.0_f64;
    let matrix = || prop::array::uniform9(-1.0..1.0_f64);
    let row = || prop::array::uniform3(-1.0..1.0_f64);
    let other = 1..6_usize;
    prop_oneof![
        (0..6_usize, other.clone(), matrix()).prop_map(|(i, o, m)| Operation::Shear(i, o, m)),
        (0..6_usize, other, number()).prop_map(|(i, o, s)| Operation::ShearScalar(i, o, s)),
        (matrix(), matrix()).prop_map(|(a, b)| Operation::ShearAlike(a, b)),
        (0..16_usize, 0..4_usize, number()).prop_map(|(f, n, s)| Operation::Scale(f, n, s)),
        (row(), 1e-3..1e3_f64).prop_map(|(h, r)| Operation::Deflate(h, r)),
        (row(), 1e-3..1e3_f64).prop_map(|(h, r)| Operation::AnyGain(h, r)),
        (row(), 1e-3..1e3_f64).prop_map(|(h, r)| Operation::FewGains(h, r)),
        (0..6_usize, 0.0..1.0_f64).prop_map(|(i, v)| Operation::Noise(i, v)),
    ]
}

fn apply(p: &mut Covariance, operation: &Operation) {
    let two = |i: usize, off: usize| (BLOCKS[i], BLOCKS[(i + off) % 6]);
    let matrix = DMat3::from_cols_array;
    match operation {
        Operation::Shear(i, off, m) => {
            let (i, j) = two(*i, *off);
            p.shear(i, matrix(m), j);
        }
        Operation::ShearScalar(i, off, s) => {
            let (i, j) = two(*i, *off);
            p.shear_scalar(i, *s, j);
        }
        Operation::ShearAlike(a, b) => p.shear_alike(
            [VELOCITY, LEAKY_VELOCITY],
            [(matrix(a), ORIENTATION), (matrix(b), ACCEL_BIAS)],
        ),
        Operation::Scale(first, count, s) => p.scale(*first, *count, *s),
        Operation::Deflate(h, r) => {
            let (ph, s) = innovation(p, h, *r);
            p.deflate(&ph, s);
        }
        Operation::AnyGain(h, r) => {
            let (ph, s) = innovation(p, h, *r);
            p.update_with_gain(&ph, &ph.map(|x| 0.3 * x / s), s);
        }
        Operation::FewGains(h, r) => {
            let (ph, s) = innovation(p, h, *r);
            let gain = |k: usize| if k % 4 == 1 { 0.3 * ph[k] / s } else { 0.0 };
            p.update_few(&ph, &core::array::from_fn(gain), s);
        }
        Operation::Noise(i, v) => p.add_variances(BLOCKS[*i], DVec3::splat(*v)),
    }
    p.restore();
}

/// `P h` and `hᵀ P h + r` for a row that sees three states of different kinds.
fn innovation(p: &Covariance, [a, b, c]: &[f64; 3], r: f64) -> (Row, f64) {
    let mut h = [0.0; STATES];
    (h[1], h[5], h[DEVIATION]) = (*a, *b, *c);
    let ph = p.times(&h);
    let s = h.iter().zip(&ph).map(|(x, y)| x * y).sum::<f64>().max(0.0) + r;
    (ph, s)
}

proptest! {
    #[test]
    fn both_halves_are_equal(operations in prop::collection::vec(operation(), 1..40)) {
        let mut p = Covariance::ZERO;
        (0..STATES).for_each(|i| p.add_variance(i, 1.0 + i as f64));
        for operation in &operations {
            apply(&mut p, operation);
            for i in 0..STATES {
                for k in 0..i {
                    let apart = p.rows[i][k] - p.rows[k][i];
                    prop_assert!(apart == 0.0, "{i}, {k}: {apart} apart after {operation:?}");
                }
            }
        }
    }

    /// Two blocks that gain alike are as good as two blocks that gain one after the other.
    #[test]
    fn gaining_alike_is_gaining_in_turn(
        before in prop::collection::vec(operation(), 1..20),
        a in prop::array::uniform9(-1.0..1.0_f64),
        b in prop::array::uniform9(-1.0..1.0_f64),
    ) {
        let (a, b) = (DMat3::from_cols_array(&a), DMat3::from_cols_array(&b));
        let mut at_once = Covariance::ZERO;
        (0..STATES).for_each(|i| at_once.add_variance(i, 1.0));
        for operation in &before {
            apply(&mut at_once, operation);
        }
        let mut in_turn = at_once;
        at_once.shear_alike([VELOCITY, LEAKY_VELOCITY], [(a, ORIENTATION), (b, ACCEL_BIAS)]);
        for target in [VELOCITY, LEAKY_VELOCITY] {
            in_turn.shear(target, a, ORIENTATION);
            in_turn.shear(target, b, ACCEL_BIAS);
        }
        let largest = in_turn.rows.iter().flatten().fold(1.0, |m: f64, x| m.max(x.abs()));
        for (x, y) in at_once.rows.iter().flatten().zip(in_turn.rows.iter().flatten()) {
            prop_assert!((x - y).abs() < 1e-13 * largest, "{} {}", x, y);
        }
    }
}
