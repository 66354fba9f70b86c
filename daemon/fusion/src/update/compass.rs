//! Heading by the magnetometer.
//!
//! Readings are turned into the world and averaged over a short interval. Only their horizontal
//! direction corrects the state: with the world's north along y, `z = atan2(B_x, B_y)` is heading
//! error plus compass deviation. Tilt is left to gravity, which knows it far better (Laidig and
//! Seel 2023, the decoupling of inclination and heading); what the tilt's own uncertainty does to
//! `z` is counted as noise.
//!
//! Strength and vertical part of the field do not depend on the heading, so their mismatch against
//! the reference measures the disturbance in two of three directions, and is the best guess of its
//! size in the third, which turns the heading.

use glam::DVec3;

mod deviation;
mod disturbance;
mod reference;

use deviation::{Moved, renew};
use disturbance::{Expectation, Seen};
pub use reference::FieldReference;

use super::{Outcome, dot};
use crate::covariance::{DEVIATION, GYRO_BIAS, MAG_DELAY, ORIENTATION, Row, STATES};
use crate::parameters::{CompassParameters, HeadingMode, Parameters};
use crate::so3;
use crate::state::State;

/// Angle from the world's north to the horizontal part of a field in the world, east positive, rad.
///
/// What it is too much against the expected bearing is the residual: heading error plus deviation.
/// `None` where the field has no horizontal direction.
pub fn bearing(field: DVec3) -> Option<f64> {
    let horizontal = field.x * field.x + field.y * field.y;
    // Below a microtesla the direction is noise.
    (horizontal > 1.0).then(|| libm::atan2(field.x, field.y))
}

/// Row of the Jacobian of [`bearing`] for a field in the world: heading error, deviation error,
/// the tilt that mixes the vertical part in, and the delay, by the field's swing `ω × B`, µT/s.
///
/// With `B̂ = Exp(−δθ) B` the field moves by `B × δθ`, and `z = atan2(B_x, B_y)` by the gradient
/// `(B_y, −B_x) / B_h²` of that: `∂z/∂δθ = ∇z × B`. `None` where the field has no horizontal
/// direction.
pub fn jacobian(field: DVec3, swing: DVec3) -> Option<Row> {
    bearing(field)?;
    let horizontal = field.x * field.x + field.y * field.y;
    let gradient = DVec3::new(field.y, -field.x, 0.0) / horizontal;
    let by_turn = gradient.cross(field);
    let mut row = [0.0; STATES];
    row[ORIENTATION.0] = by_turn.x;
    row[ORIENTATION.0 + 1] = by_turn.y;
    row[ORIENTATION.0 + 2] = by_turn.z;
    row[DEVIATION] = 1.0;
    row[MAG_DELAY] = gradient.dot(swing);
    Some(row)
}

/// What the compass made of its latest average of readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompassReport {
    /// The heading update.
    pub outcome: Outcome,
    /// Strength of the field, µT.
    pub norm_ut: f64,
    /// Mismatch against the reference, µT.
    pub mismatch_ut: f64,
}

/// Readings over a short interval: their mean, or, while it is collected, their sum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct FieldAverage {
    /// The field in the world, µT.
    pub(crate) field: DVec3,
    /// What a second of delay would do to it: `ω × B`, µT/s.
    pub(crate) swing: DVec3,
    /// Number of readings.
    pub(crate) count: f64,
}

/// What speaks against a field.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Doubt {
    /// Size of what is wrong with it, as far as can be seen, µT.
    size_ut: f64,
    /// How much it changed of late, if notably, µT.
    change_ut: f64,
}

impl Doubt {
    const NONE: Self = Self { size_ut: 0.0, change_ut: 0.0 };
}

/// A field compared with the expected one.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Examined {
    doubt: Doubt,
    /// Misfit of strength and vertical part beyond a turning camera's blur, µT.
    mismatch_ut: f64,
    /// Strength of the expected field, µT.
    strength_ut: f64,
}

/// A bearing against the expected one.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Innovation {
    row: Row,
    /// rad.
    residual: f64,
    /// Of the reading alone, rad².
    variance: f64,
}

/// The compass: the field it expects, and the readings it is averaging.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compass {
    expected: Option<Expectation>,
    sum: FieldAverage,
    span_s: f64,
    smooth_mismatch_ut: f64,
    smooth: Option<DVec3>,
    /// What the camera did since the deviation was last renewed.
    moved: Moved,
    /// Time since an innovation was last within twice the gate, s.
    refused_s: f64,
    /// The field when it last changed notably.
    anchor: Option<DVec3>,
    /// What steel nearby does to the field, as far as others than the compass can tell, 1σ, µT.
    bend_ut: f64,
}

impl Compass {
    /// A compass that has seen nothing.
    pub const fn new() -> Self {
        Self {
            expected: None,
            sum: FieldAverage { field: DVec3::ZERO, swing: DVec3::ZERO, count: 0.0 },
            span_s: 0.0,
            smooth_mismatch_ut: 0.0,
            smooth: None,
            moved: Moved { way_m: 0.0, turn_rad: 0.0, time_s: 0.0 },
            refused_s: 0.0,
            anchor: None,
            bend_ut: 0.0,
        }
    }

    /// Takes note of what steel nearby does to the field, 1σ, µT; 0 where there is none. Such a field is
    /// not refused, since it may be all there is, but each renewal of the deviation counts for less.
    pub(crate) const fn note_bend(&mut self, bend_ut: f64) {
        self.bend_ut = bend_ut;
    }

    /// Takes the field at the alignment, averaged over some time, s, as the one to expect.
    pub fn expect(&mut self, field: DVec3, averaged_s: f64) {
        self.expected = Some(Expectation::of(field, averaged_s));
    }

    /// The first field after an alignment without one: the reference, and the angle by which the
    /// world must turn about up for the field to point where it belongs.
    pub(crate) fn adopt(&mut self, field: DVec3, field_bearing_rad: f64) -> Option<f64> {
        let excess = bearing(field)? - field_bearing_rad;
        self.expect(field, 0.0);
        Some(excess)
    }

    /// The undisturbed field, if one is known.
    pub fn reference(&self) -> Option<FieldReference> {
        self.expected.map(|expected| expected.reference)
    }

    /// The field in the world, smoothed over some tenths of a second, µT.
    pub(crate) const fn field_ut(&self) -> Option<DVec3> {
        self.smooth
    }

    /// Whether the field does not fit the reference.
    pub fn is_disturbed(&self) -> bool {
        self.expected.is_some_and(|expected| expected.disturbed)
    }

    /// Takes note of what the camera did during a step: its length, its turn, its speed.
    pub(crate) fn note_motion(&mut self, span_s: f64, turn_rad: f64, speed_m_s: f64) {
        self.moved.time_s += span_s;
        self.moved.turn_rad += turn_rad;
        self.moved.way_m += speed_m_s * span_s;
    }

    /// Adds a step with the reading it brought, in the world, and the camera's rate there, rad/s;
    /// gives the average when it is due.
    ///
    /// A reading that is late by τ shows the field where it was: turned by `ω τ` too far. So it is
    /// turned back by the delay that is known.
    pub(crate) fn average(
        &mut self,
        reading: Option<(DVec3, DVec3)>,
        delay_s: f64,
        span_s: f64,
        p: &CompassParameters,
    ) -> Option<FieldAverage> {
        self.span_s += span_s;
        if let Some((field, rate)) = reading {
            let field = so3::exp(rate * -delay_s) * field;
            self.sum.field += field;
            self.sum.swing += rate.cross(field);
            self.sum.count += 1.0;
        }
        if self.sum.count == 0.0 || self.span_s < p.interval_s {
            return None;
        }
        self.span_s = 0.0;
        let sum = core::mem::take(&mut self.sum);
        let share = sum.count.recip();
        Some(FieldAverage { field: sum.field * share, swing: sum.swing * share, ..sum })
    }

    /// Updates the heading with an average of readings.
    ///
    /// The variance of an innovation beyond the gate is raised until it sits on the gate. Beyond twice
    /// the gate, and from a disturbed field, it is refused, but not for ever, which could lock a wrong
    /// heading in.
    pub(crate) fn update(
        &mut self,
        state: &mut State,
        average: &FieldAverage,
        parameters: &Parameters,
    ) -> Option<CompassReport> {
        let p = &parameters.compass;
        let field = average.field;
        let angle = bearing(field)?;
        let row = jacobian(field, average.swing)?;
        let horizontal_ut2 = field.x * field.x + field.y * field.y;
        let moved = core::mem::take(&mut self.moved);
        let examined = self.examine(state, field, &moved, parameters)?;
        let doubt = match parameters.heading {
            HeadingMode::Adaptive => examined.doubt,
            HeadingMode::Continuous | HeadingMode::InitialOnly => Doubt::NONE,
        };
        let size_rad = doubt.size_ut / libm::sqrt(horizontal_ut2);
        let (reasons, change_ut) = self.reasons_to_renew(&moved, doubt.change_ut, p);
        renew(state, &reasons, change_ut, size_rad, p);

        let jitter_ut = moved.rate_rad_s() * p.timing_sigma_s * examined.strength_ut;
        let noise_ut2 = square(parameters.noise.mag_sigma_ut) / average.count + square(jitter_ut);
        let residual = wrap(angle - parameters.field_bearing_rad - state.deviation);
        let innovation = Innovation { row, residual, variance: noise_ut2 / horizontal_ut2 };
        Some(CompassReport {
            outcome: self.steer_as_allowed(state, &innovation, moved.time_s, parameters),
            norm_ut: libm::sqrt(field.length_squared()),
            mismatch_ut: examined.mismatch_ut,
        })
    }

    /// What the camera did, as far as it renews the deviation: by steel that bends the field it is the same
    /// for metres, however the field changes and the camera turns meanwhile.
    fn reasons_to_renew(
        &self,
        moved: &Moved,
        change_ut: f64,
        p: &CompassParameters,
    ) -> (Moved, f64) {
        if self.bend_ut == 0.0 {
            return (*moved, change_ut);
        }
        let way_m = moved.way_m * p.deviation_way_m / BEND_WAY_M;
        (Moved { way_m, turn_rad: 0.0, ..*moved }, 0.0)
    }

    /// Compares a field with the expected one and with itself a moment ago.
    fn examine(
        &mut self,
        state: &State,
        field: DVec3,
        moved: &Moved,
        parameters: &Parameters,
    ) -> Option<Examined> {
        let p = &parameters.compass;
        let expected = self.expected.as_mut()?;
        let reference = expected.reference;
        let timing_s2 = square(p.timing_sigma_s) + state.covariance.variance(MAG_DELAY);
        let tilt2 = state.covariance.variances(ORIENTATION).truncate().max_element();
        let blur_ut = moved.rate_rad_s() * libm::sqrt(timing_s2) * reference.norm_ut;
        let mismatch_ut = (reference.mismatch_ut(field) - blur_ut).max(0.0);
        let seen = Seen {
            field,
            blur_ut: blur_ut + libm::sqrt(tilt2) * reference.norm_ut,
            bearing_rad: parameters.field_bearing_rad,
            span_s: moved.time_s,
            turn_rad: moved.turn_rad,
        };
        expected.judge(&seen, p);
        let disturbance_ut = expected.doubt_ut(p.patience_s);
        self.smoothen(
            field,
            mismatch_ut,
            smoothing_share(moved.time_s, p.mismatch_time_constant_s),
        );
        let change_ut = self.change_ut(blur_ut, p);
        let size_ut = self.smooth_mismatch_ut.max(disturbance_ut).max(change_ut);
        let size_ut = if self.bend_ut > 0.0 { self.bend_ut } else { size_ut };
        let doubt = Doubt { size_ut, change_ut };
        Some(Examined { doubt, mismatch_ut, strength_ut: reference.norm_ut })
    }

    /// Steers by an innovation as far as the mode and the gate allow.
    fn steer_as_allowed(
        &mut self,
        state: &mut State,
        innovation: &Innovation,
        span_s: f64,
        parameters: &Parameters,
    ) -> Outcome {
        let Innovation { row, residual, variance } = innovation;
        let p = &parameters.compass;
        let ph = state.covariance.times(row);
        let expected = dot(row, &ph);
        let nis = residual * residual / (expected + variance);
        let excess = nis / (p.gate_sigma * p.gate_sigma);
        let unused = Outcome { residual: *residual, nis, used: false };
        let bent = self.bend_ut > 0.0;
        let disturbed = !bent && self.expected.is_some_and(|e| e.is_doubted(p.patience_s));
        match parameters.heading {
            HeadingMode::InitialOnly => unused,
            HeadingMode::Continuous => steer(state, (row, &ph), *residual, expected + variance),
            HeadingMode::Adaptive if disturbed || !bent && self.refuses(excess, span_s, p) => {
                unused
            }
            HeadingMode::Adaptive => Outcome {
                used: excess <= REFUSED,
                nis,
                ..steer(state, (row, &ph), *residual, expected + variance * excess.max(1.0))
            },
        }
    }

    /// Whether an innovation, as a multiple of the gate, squared, is refused: beyond twice the gate, but
    /// no longer than patience lasts.
    fn refuses(&mut self, excess: f64, span_s: f64, p: &CompassParameters) -> bool {
        if excess <= REFUSED {
            self.refused_s = 0.0;
            return false;
        }
        self.refused_s += span_s;
        self.refused_s < p.patience_s
    }

    /// How much the field changed, if notably: by more than a turning camera's blur.
    fn change_ut(&mut self, blur_ut: f64, p: &CompassParameters) -> f64 {
        let Some(now) = self.smooth else { return 0.0 };
        let anchor = self.anchor.get_or_insert(now);
        let change_ut = libm::sqrt((now - *anchor).length_squared());
        if change_ut < p.change_ut + 2.0 * blur_ut {
            return 0.0;
        }
        *anchor = now;
        change_ut
    }

    /// Smooths the field and its mismatch.
    fn smoothen(&mut self, field: DVec3, mismatch_ut: f64, share: f64) {
        let smooth = self.smooth.get_or_insert(field);
        *smooth += share * (field - *smooth);
        self.smooth_mismatch_ut += share * (mismatch_ut - self.smooth_mismatch_ut);
    }
}

/// Applies a heading residual to what it is allowed to teach: heading, deviation, delay and
/// gyroscope bias.
///
/// Tilt and everything that hangs on it are considered, not learnt (Schmidt's consider states):
/// their part in the innovation is counted, and their correlations are kept. Takes `h`, `P h` and the
/// innovation's variance, rad².
fn steer(state: &mut State, (row, ph): (&Row, &Row), residual: f64, innovation: f64) -> Outcome {
    let mut gain = [0.0; STATES];
    let own = state.own_part(row, ph);
    for learnt in LEARNT {
        gain[learnt] = own[learnt] / innovation;
    }
    // Of the gyroscope's bias only what turns the heading: the rest would be learnt from how a tilt
    // shows in the bearing.
    let up = state.orientation.conjugate() * DVec3::Z;
    let bias = DVec3::from_slice(&own[GYRO_BIAS.0..GYRO_BIAS.0 + 3]);
    let vertical = up * (up.dot(bias) / innovation);
    gain[GYRO_BIAS.0..GYRO_BIAS.0 + 3].copy_from_slice(&vertical.to_array());
    state.correct(&gain.map(|k| k * residual));
    if let Some(tie) = &mut state.tie {
        tie.learn(row, &gain);
    }
    state.covariance.update_few(ph, &gain, innovation);
    Outcome { residual, nis: residual * residual / innovation, used: true }
}

/// Way past steel after which it bends the field another way, m.
const BEND_WAY_M: f64 = 2.0;

/// Square of the multiple of the gate beyond which an innovation is refused.
const REFUSED: f64 = 4.0;

/// The states that the heading teaches.
const LEARNT: [usize; 3] = [ORIENTATION.0 + 2, DEVIATION, MAG_DELAY];

impl Default for Compass {
    fn default() -> Self {
        Self::new()
    }
}

/// Share of a new value in an exponential average, after a span, s.
fn smoothing_share(span_s: f64, time_constant_s: f64) -> f64 {
    1.0 - libm::exp(-span_s / time_constant_s)
}

/// Brings an angle into −π to π.
fn wrap(angle: f64) -> f64 {
    libm::remainder(angle, core::f64::consts::TAU)
}

fn square(x: f64) -> f64 {
    x * x
}
