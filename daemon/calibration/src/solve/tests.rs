//! Every Jacobian against central differences, and the arrow against a dense solve.

use glam::{DQuat, DVec3};
use lodestone_fusion::so3;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

use super::arrow::{Arrow, Residual};
use super::parameters::{
    DELAY, FIELD, GLOBALS, GRAVITY, GYRO, GYRO_SLOPE, GlobalStep, Globals, HARD, HARD_SLOPE, Knot,
    LOCALS, LocalStep, MAG_DELAY, SCALE, SOFT,
};
use super::segments::{Integrator, Segment, Turn};
use super::turned::Turned;
use super::{field, force, link};
use crate::heading::HeadingError;
use crate::stream::Step;

const STEP: f64 = 1e-6;
const WARMER_K: f64 = 7.0;

fn steps() -> Vec<Step> {
    (0..20)
        .map(|k| {
            let t = f64::from(k);
            Step {
                time_s: 0.02 * t,
                dt_s: 0.02,
                gyro: DVec3::new(2.0 * t.sin(), 1.0 + t.cos(), -3.0 + 0.1 * t),
                accel: DVec3::new(0.3, -0.5, 9.7),
                mag: Some(DVec3::new(20.0, t, -40.0)),
                warmer_k: WARMER_K,
            }
        })
        .collect()
}

fn segment() -> Segment {
    Segment {
        samples: 0..20,
        bins: std::iter::once(0..20).collect(),
        warmer_k: WARMER_K,
        duration_s: 0.4,
        gap_s: 0.0,
    }
}

fn globals() -> Globals {
    let mut globals = Globals(GlobalStep::zeros());
    let soft = [1.1, 0.03, -0.04, 0.02, 0.93, 0.05, -0.01, 0.04, 1.02];
    globals.0.fixed_rows_mut::<9>(SOFT).copy_from_slice(&soft);
    globals.set(HARD, DVec3::new(10.0, -20.0, 30.0));
    globals.set(HARD_SLOPE, DVec3::new(0.1, 0.2, -0.3));
    (globals.0[FIELD], globals.0[FIELD + 1]) = (19.0, 46.0);
    globals.set(GYRO, DVec3::new(0.01, -0.02, 0.015));
    globals.set(GYRO_SLOPE, DVec3::new(1e-4, -2e-4, 3e-4));
    globals.set(SCALE, DVec3::new(0.01, -0.005, 0.002));
    globals.0[GRAVITY] = 9.8;
    globals
}

fn attitudes() -> [DQuat; 5] {
    [
        DQuat::IDENTITY,
        so3::exp(DVec3::new(1e-7, -1e-7, 2e-7)),
        so3::exp(DVec3::new(0.3, -1.2, 0.8)),
        DQuat::from_rotation_x(std::f64::consts::PI),
        DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2),
    ]
}

fn turn_to_the_end(globals: &Globals, knot: &Knot, mut each: impl FnMut(&Turn)) -> Turn {
    let (steps, segment) = (steps(), segment());
    let mut integrator = Integrator::new(globals, knot, &segment);
    let mut last = *integrator.at_knot(&steps[0]);
    each(&last);
    for step in &steps[1..] {
        last = *integrator.step(step);
        each(&last);
    }
    last
}

fn mag(globals: &Globals, knot: &Knot) -> Residual<3> {
    let mut turned = Turned::new(knot.attitude.inverse() * globals.field());
    turn_to_the_end(globals, knot, |turn| turned.add(turn));
    let mean = turned.mean().expect("twenty readings");
    field::residual(globals, knot, &mean, DVec3::new(20.0, -3.0, -40.0), WARMER_K)
}

fn accel(globals: &Globals, knot: &Knot) -> Residual<3> {
    let mut turned = Turned::new(knot.attitude.inverse() * globals.gravity());
    turn_to_the_end(globals, knot, |turn| turned.add(turn));
    let mean = turned.mean().expect("twenty readings");
    force::residual(globals, knot, &mean, DVec3::new(0.3, -0.5, 9.7), WARMER_K)
}

/// Columns of central differences of a residual by steps of `N` parameters.
fn differences<const N: usize>(
    value: impl Fn(&SVector<f64, N>) -> SVector<f64, 3>,
) -> SMatrix<f64, 3, N> {
    SMatrix::from_columns(&std::array::from_fn::<_, N, _>(|i| {
        let mut step = SVector::<f64, N>::zeros();
        step[i] = STEP;
        (value(&step) - value(&-step)) / (2.0 * STEP)
    }))
}

fn assert_near<const N: usize>(jacobian: &SMatrix<f64, 3, N>, truth: &SMatrix<f64, 3, N>) {
    for column in 0..N {
        let (found, truth) = (jacobian.column(column), truth.column(column));
        let scale = truth.norm().max(1.0);
        assert!((found - truth).norm() < 1e-6 * scale, "{column}: {found} against {truth}");
    }
}

fn check(residual: impl Fn(&Globals, &Knot) -> Residual<3>) {
    let globals = globals();
    for attitude in attitudes() {
        let knot = Knot { attitude, bias: DVec3::new(1e-3, 2e-3, -1e-3) };
        let r = residual(&globals, &knot);
        let by_globals = |step: &GlobalStep| residual(&globals.stepped(step), &knot).value;
        assert_near(&r.global, &differences(by_globals));
        let by_knot = |step: &LocalStep| residual(&globals, &knot.stepped(step)).value;
        assert_near(&r.local, &differences(by_knot));
    }
}

#[test]
fn the_magnetometers_jacobians_are_right() {
    check(mag);
}

#[test]
fn the_accelerometers_jacobians_are_right() {
    check(accel);
}

#[test]
fn delays_act_to_the_first_order() {
    let knot = Knot { attitude: attitudes()[2], bias: DVec3::ZERO };
    let mut late = globals();
    (late.0[DELAY], late.0[MAG_DELAY]) = (0.003, 0.002);
    let turned = (mag(&late, &knot).value - mag(&globals(), &knot).value) / 0.005;
    let column = mag(&globals(), &knot).global.column(DELAY).into_owned();
    assert!((turned - column).norm() < 1e-9 * column.norm(), "{turned} {column}");
}

#[test]
fn the_links_jacobians_are_right() {
    let globals = globals();
    for attitude in attitudes() {
        for off in [DVec3::ZERO, DVec3::new(0.003, -0.002, 0.004)] {
            let knot = Knot { attitude, bias: DVec3::new(1e-3, 2e-3, -1e-3) };
            let turn = turn_to_the_end(&globals, &knot, |_| {});
            let turned = DQuat::from_mat3(&turn.rotation) * so3::exp(off);
            let next = Knot { attitude: attitude * turned, bias: DVec3::ZERO };
            let at = |globals: &Globals, knot: &Knot| {
                let turn = turn_to_the_end(globals, knot, |_| {});
                link::rotation(knot, &next, &turn, &segment()).residual
            };
            let r = at(&globals, &knot);
            let by_globals = |step: &GlobalStep| at(&globals.stepped(step), &knot).value;
            assert_near(&r.global, &differences(by_globals));
            let by_knot = |step: &LocalStep| at(&globals, &knot.stepped(step)).value;
            assert_near(&r.local, &differences(by_knot));
        }
    }
}

#[test]
fn the_links_jacobian_by_the_next_knot_is_right() {
    let knot = Knot { attitude: attitudes()[2], bias: DVec3::new(1e-3, 0.0, 0.0) };
    let turn = turn_to_the_end(&globals(), &knot, |_| {});
    let off = so3::exp(DVec3::new(0.003, -0.002, 0.004));
    let attitude = knot.attitude * DQuat::from_mat3(&turn.rotation) * off;
    let next = Knot { attitude, bias: DVec3::new(0.0, 2e-3, 0.0) };
    for between in [link::bias, |k: &Knot, n: &Knot, s: &Segment| {
        let turn = turn_to_the_end(&globals(), k, |_| {});
        link::rotation(k, n, &turn, s)
    }] {
        let at = between(&knot, &next, &segment());
        let by_next =
            |step: &LocalStep| between(&knot, &next.stepped(step), &segment()).residual.value;
        assert_near(&at.next, &differences(by_next));
        let by_knot =
            |step: &LocalStep| between(&knot.stepped(step), &next, &segment()).residual.value;
        assert_near(&at.residual.local, &differences(by_knot));
    }
}

#[test]
fn the_headings_jacobian_is_right() {
    let globals = globals();
    let covariance = SMatrix::identity();
    let error = HeadingError::new(&globals, &covariance);
    let truth = globals.soft_iron();
    for attitude in attitudes() {
        let reading = truth * (attitude.inverse() * globals.field()) + globals.hard_iron(WARMER_K);
        let heading = |step: &SVector<f64, 15>| {
            let mut all = GlobalStep::zeros();
            all.fixed_rows_mut::<15>(SOFT).copy_from(step);
            let with = globals.stepped(&all);
            let field = with.soft_iron().inverse() * (reading - with.hard_iron(WARMER_K));
            let world = attitude * field;
            -world.x.atan2(world.y)
        };
        let jacobian = error.jacobian(attitude, WARMER_K);
        for i in 0..15 {
            let mut step = SVector::<f64, 15>::zeros();
            step[i] = STEP;
            let truth = (heading(&step) - heading(&-step)) / (2.0 * STEP);
            assert!((jacobian[i].abs() - truth.abs()).abs() < 1e-6 * truth.abs().max(1.0), "{i}");
        }
    }
}

/// A number that looks random, from −1 to 1.
fn scattered(seed: usize) -> f64 {
    2.0 * (((seed as f64 + 0.5) * 12.9898).sin() * 43_758.545_3).fract().abs() - 1.0
}

#[test]
fn the_arrow_agrees_with_a_dense_solve() {
    const KNOTS: usize = 4;
    let size = KNOTS * LOCALS + GLOBALS;
    let mut arrow = Arrow::new(KNOTS);
    let (mut dense, mut right) = (DMatrix::zeros(size, size), DVector::zeros(size));
    let mut add = |rows: &DMatrix<f64>, value: &SVector<f64, 3>, weight: f64| {
        dense += rows.transpose() * rows * weight;
        right += rows.transpose() * value * weight;
    };
    for n in 0..60 {
        let knot = n % KNOTS;
        let seed = 1000 * n;
        let local = SMatrix::<f64, 3, LOCALS>::from_fn(|i, j| scattered(seed + 7 * i + j));
        let next = SMatrix::<f64, 3, LOCALS>::from_fn(|i, j| scattered(seed + 100 + 7 * i + j));
        let global = SMatrix::<f64, 3, GLOBALS>::from_fn(|i, j| scattered(seed + 200 + 40 * i + j));
        let value = SVector::<f64, 3>::from_fn(|i, _| scattered(seed + 500 + i));
        let r = Residual { value, local, global, weight: 1.0 + scattered(n).abs() };
        let mut rows = DMatrix::zeros(3, size);
        rows.view_mut((0, knot * LOCALS), (3, LOCALS)).copy_from(&local);
        rows.view_mut((0, KNOTS * LOCALS), (3, GLOBALS)).copy_from(&global);
        if n % 2 == 0 && knot + 1 < KNOTS {
            rows.view_mut((0, (knot + 1) * LOCALS), (3, LOCALS)).copy_from(&next);
            arrow.add_link(knot, &r, &next);
        } else {
            arrow.add(knot, &r);
        }
        add(&rows, &value, r.weight);
    }
    let solution = arrow.solve(0.0).expect("positive definite");
    let factor = dense.cholesky().expect("positive definite");
    let truth = -factor.solve(&right);
    let covariance = factor.inverse();
    for (k, local) in solution.locals.iter().enumerate() {
        assert!((local - truth.rows(k * LOCALS, LOCALS)).norm() < 1e-8);
    }
    let at = KNOTS * LOCALS;
    assert!((solution.globals - truth.rows(at, GLOBALS)).norm() < 1e-8);
    let block = covariance.view((at, at), (GLOBALS, GLOBALS));
    assert!((solution.covariance - block).norm() < 1e-8 * block.norm());
    let log_determinant = 2.0 * factor.l_dirty().diagonal().iter().map(|l| l.ln()).sum::<f64>();
    assert!((solution.log_determinant - log_determinant).abs() < 1e-8);
}

#[test]
fn the_soft_iron_is_kept_row_by_row() {
    let soft_iron = globals().soft_iron();
    assert_eq!(soft_iron * DVec3::Y, DVec3::new(0.03, 0.93, 0.04));
}
