//! Where the search begins: attitude level by gravity, its drift about the vertical and its
//! heading from the magnetometer as if there were no soft iron.
//!
//! With soft iron `A = I` the reading is linear in field and hard iron, `m = Rᵀ Rz(c t) h + b`,
//! for each drift `c` of the heading; the drift with the smallest residual begins.

use glam::{DMat3, DQuat, DVec3};
use nalgebra::{SMatrix, SVector};

use super::parameters::{FIELD, GRAVITY, GYRO, GlobalStep, Globals, HARD, Knot, SOFT, State};
use super::segments::Segment;
use crate::levelling::Levelling;
use crate::stream::Stream;

/// Largest drift tried, rad/s: 2 °/s.
const MOST_DRIFT: f64 = 0.035;
/// Drift over the whole recording from one try to the next one, rad.
const DRIFT_STEP: f64 = 0.4;
/// Knowledge of the field before anything is seen, 1σ, µT.
const FIELD_SIGMA_UT: f64 = 60.0;
/// And of the hard iron, µT.
const HARD_SIGMA_UT: f64 = 100.0;

/// A reading with the level attitude it was taken in.
struct Reading {
    time_s: f64,
    /// Sensor to level frame.
    attitude: DMat3,
    mag: DVec3,
}

/// Field in the level frame and hard iron, and how badly they fit.
struct Flat {
    field: DVec3,
    hard_iron: DVec3,
    residual_ut: f64,
}

/// The start, and the residual it leaves of one reading, µT.
pub(crate) fn start(stream: &Stream, segments: &[Segment]) -> (State, f64) {
    let (levels, bias) = level(stream);
    let readings = readings(stream, &levels);
    let (drift, flat) = best_drift(&readings, stream.duration_s());
    let north = DQuat::from_rotation_z(flat.field.x.atan2(flat.field.y));
    let knots: Vec<Knot> = segments
        .iter()
        .map(|segment| {
            let i = segment.samples.start;
            let back = DQuat::from_rotation_z(-drift * stream.steps[i].time_s);
            Knot { attitude: (north * back * levels[i]).normalize(), bias: DVec3::ZERO }
        })
        .collect();
    let up = mean_up(&levels);
    let globals = globals(&flat, bias + up * drift);
    (State { globals, knots }, flat.residual_ut)
}

/// Level attitudes of all samples, and the bias that gravity shows; run twice, so that the first
/// seconds know the bias too.
fn level(stream: &Stream) -> (Vec<DQuat>, DVec3) {
    let first = stream.steps.first().map_or(DVec3::Z, |step| step.accel);
    let mut levelling = Levelling::start(first);
    for step in &stream.steps {
        levelling.step(step.dt_s, step.gyro, step.accel);
    }
    let bias = levelling.bias.clamp_length_max(MOST_DRIFT);
    levelling = Levelling { bias, ..Levelling::start(first) };
    let levels = stream.steps.iter().map(|step| {
        levelling.step(step.dt_s, step.gyro, step.accel);
        levelling.attitude
    });
    (levels.collect(), bias)
}

fn mean_up(levels: &[DQuat]) -> DVec3 {
    let sum = levels.iter().fold(DVec3::ZERO, |sum, level| sum + level.inverse() * DVec3::Z);
    sum / levels.len().max(1) as f64
}

/// At most ten readings a second.
fn readings(stream: &Stream, levels: &[DQuat]) -> Vec<Reading> {
    let mut readings: Vec<Reading> = Vec::new();
    for (step, level) in stream.steps.iter().zip(levels) {
        let is_due = readings.last().is_none_or(|last| step.time_s - last.time_s > 0.09);
        if let (true, Some(mag)) = (is_due, step.mag) {
            readings.push(Reading { time_s: step.time_s, attitude: DMat3::from_quat(*level), mag });
        }
    }
    readings
}

/// The best of a grid, refined by the parabola through it and its neighbours.
fn best_drift(readings: &[Reading], duration_s: f64) -> (f64, Flat) {
    let step = (DRIFT_STEP / duration_s.max(1.0)).min(0.2 * MOST_DRIFT);
    let count = (MOST_DRIFT / step).ceil() as i32;
    let at = |drift: f64| flat(readings, drift);
    let tries = (-count..=count).map(|k| (f64::from(k) * step, at(f64::from(k) * step)));
    let best = tries.min_by(|a, b| a.1.residual_ut.total_cmp(&b.1.residual_ut));
    let (drift, flat) = best.unwrap_or_else(|| (0.0, at(0.0)));
    let [before, here, after] =
        [at(drift - step).residual_ut, flat.residual_ut, at(drift + step).residual_ut];
    let bend = before - 2.0 * here + after;
    if bend <= 0.0 {
        return (drift, flat);
    }
    let refined = drift + 0.5 * step * ((before - after) / bend).clamp(-1.0, 1.0);
    let fit = at(refined);
    if fit.residual_ut < here { (refined, fit) } else { (drift, flat) }
}

/// Least squares for field and hard iron, with the heading drifting by `drift` rad/s.
fn flat(readings: &[Reading], drift: f64) -> Flat {
    let mut normal = SMatrix::<f64, 6, 6>::zeros();
    let mut right = SVector::<f64, 6>::zeros();
    let mut square = 0.0;
    for reading in readings {
        let level = DMat3::from_rotation_z(-drift * reading.time_s) * reading.attitude;
        let mut by = SMatrix::<f64, 3, 6>::zeros();
        by.fixed_columns_mut::<3>(0).copy_from(&crate::linear::matrix(level.transpose()));
        by.fixed_columns_mut::<3>(3).fill_with_identity();
        let mag = crate::linear::vector(reading.mag);
        normal += by.transpose() * by;
        right += by.transpose() * mag;
        square += mag.norm_squared();
    }
    for i in 0..6 {
        let sigma = if i < 3 { FIELD_SIGMA_UT } else { HARD_SIGMA_UT };
        normal[(i, i)] += sigma.powi(-2);
    }
    let x = normal.cholesky().map_or_else(SVector::zeros, |factor| factor.solve(&right));
    let left = (square - x.dot(&right)).max(0.0);
    Flat {
        field: DVec3::new(x[0], x[1], x[2]),
        hard_iron: DVec3::new(x[3], x[4], x[5]),
        residual_ut: (left / (3 * readings.len().max(1)) as f64).sqrt(),
    }
}

fn globals(flat: &Flat, bias: DVec3) -> Globals {
    let mut globals = Globals(GlobalStep::zeros());
    for i in [0, 4, 8] {
        globals.0[SOFT + i] = 1.0;
    }
    globals.set(HARD, flat.hard_iron);
    globals.0[FIELD] = flat.field.x.hypot(flat.field.y).max(5.0);
    globals.0[FIELD + 1] = -flat.field.z;
    globals.set(GYRO, bias);
    globals.0[GRAVITY] = 9.81;
    globals
}
