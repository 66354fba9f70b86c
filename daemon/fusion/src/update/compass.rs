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

use super::{Outcome, apply, innovation_variance};
use crate::covariance::{DEVIATION, ORIENTATION, Row, STATES};
use crate::parameters::{CompassParameters, HeadingMode};
use crate::state::State;

/// The undisturbed field, as learnt at the alignment and followed slowly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldReference {
    /// Strength, µT.
    pub norm_ut: f64,
    /// Upward part, µT (negative in the north).
    pub vertical_ut: f64,
}

impl FieldReference {
    /// The reference that a field given in levelled coordinates makes.
    pub fn of(field: DVec3) -> Self {
        Self { norm_ut: libm::sqrt(field.length_squared()), vertical_ut: field.z }
    }

    /// Horizontal part, µT.
    pub fn horizontal_ut(&self) -> f64 {
        let squared = self.norm_ut * self.norm_ut - self.vertical_ut * self.vertical_ut;
        libm::sqrt(squared.max(0.0))
    }

    /// How badly a field in the world fits, µT: the root of the squared misfits in strength and
    /// vertical part.
    pub fn mismatch_ut(&self, field: DVec3) -> f64 {
        let norm = libm::sqrt(field.length_squared()) - self.norm_ut;
        let vertical = field.z - self.vertical_ut;
        libm::sqrt(norm * norm + vertical * vertical)
    }

    fn follow(&mut self, field: DVec3, share: f64) {
        let new = Self::of(field);
        self.norm_ut += share * (new.norm_ut - self.norm_ut);
        self.vertical_ut += share * (new.vertical_ut - self.vertical_ut);
    }
}

/// Angle by which a horizontal field lies east of the world's north, rad: the residual with
/// opposite sign, since the world's north is where the field should be.
///
/// `None` where the field has no horizontal direction.
pub fn residual(field: DVec3) -> Option<f64> {
    let horizontal = field.x * field.x + field.y * field.y;
    // Below a microtesla the direction is noise.
    (horizontal > 1.0).then(|| libm::atan2(field.x, field.y))
}

/// Row of the Jacobian of [`residual`]: heading error plus deviation error.
pub fn jacobian() -> Row {
    let mut row = [0.0; STATES];
    row[ORIENTATION.0 + 2] = 1.0;
    row[DEVIATION] = 1.0;
    row
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

/// The compass: the field it expects, and the readings it is averaging.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compass {
    reference: Option<FieldReference>,
    sum: DVec3,
    count: f64,
    span_s: f64,
    smooth_mismatch_ut: f64,
    previous: Option<FieldReference>,
    disturbed: bool,
}

impl Compass {
    /// A compass that has seen nothing.
    pub const fn new() -> Self {
        Self {
            reference: None,
            sum: DVec3::ZERO,
            count: 0.0,
            span_s: 0.0,
            smooth_mismatch_ut: 0.0,
            previous: None,
            disturbed: false,
        }
    }

    /// Takes the field at the alignment as the reference.
    pub fn set_reference(&mut self, field: DVec3) {
        self.reference = Some(FieldReference::of(field));
    }

    /// The undisturbed field, if one is known.
    pub const fn reference(&self) -> Option<FieldReference> {
        self.reference
    }

    /// Whether the field does not fit the reference.
    pub const fn is_disturbed(&self) -> bool {
        self.disturbed
    }

    /// Adds a step with the reading it brought, in the world; gives the average when it is due.
    pub(crate) fn average(
        &mut self,
        field: Option<DVec3>,
        span_s: f64,
        p: &CompassParameters,
    ) -> Option<(DVec3, f64)> {
        self.span_s += span_s;
        if let Some(field) = field {
            self.sum += field;
            self.count += 1.0;
        }
        if self.count == 0.0 || self.span_s < p.interval_s {
            return None;
        }
        let average = (self.sum / self.count, self.count);
        self.sum = DVec3::ZERO;
        self.count = 0.0;
        self.span_s = 0.0;
        Some(average)
    }

    /// Updates the heading with an average of `count` readings, `field` in the world.
    pub(crate) fn update(
        &mut self,
        state: &mut State,
        (field, count): (DVec3, f64),
        sigma_ut: f64,
        mode: HeadingMode,
        p: &CompassParameters,
    ) -> Option<CompassReport> {
        let mut reference = self.reference?;
        let mismatch_ut = reference.mismatch_ut(field);
        let angle = residual(field)?;
        let horizontal = libm::sqrt(field.x * field.x + field.y * field.y);
        let noise_ut2 = sigma_ut * sigma_ut / count;

        if mode == HeadingMode::Adaptive {
            self.renew_deviation(state, field, horizontal, noise_ut2);
        }
        self.disturbed = mismatch_ut > p.mismatch_limit_ut;

        let excess = if mode == HeadingMode::Adaptive {
            (mismatch_ut * mismatch_ut - p.mismatch_sigma_ut * p.mismatch_sigma_ut).max(0.0)
        } else {
            0.0
        };
        let slope = field.z / horizontal;
        let tilt = state.covariance.variances(ORIENTATION);
        let variance = (noise_ut2 + excess) / (horizontal * horizontal)
            + slope * slope * 0.5 * (tilt.x + tilt.y);
        let row = jacobian();
        let residual = wrap(angle - state.deviation);
        let innovation = innovation_variance(state, &row, variance);
        let nis = residual * residual / innovation;
        let refused = mode == HeadingMode::InitialOnly
            || (mode == HeadingMode::Adaptive && nis > p.gate_sigma * p.gate_sigma);
        let outcome = if refused {
            Outcome { residual, nis, used: false }
        } else {
            apply(state, &row, residual, variance)
        };
        if !self.disturbed {
            reference.follow(field, (p.interval_s / p.reference_time_constant_s).min(1.0));
            self.reference = Some(reference);
        }
        Some(CompassReport { outcome, norm_ut: libm::sqrt(field.length_squared()), mismatch_ut })
    }

    /// A change of strength or dip is a change of the disturbance, so the deviation is less known.
    fn renew_deviation(
        &mut self,
        state: &mut State,
        field: DVec3,
        horizontal: f64,
        noise_ut2: f64,
    ) {
        let now = FieldReference::of(field);
        let before = self.previous.replace(now).unwrap_or(now);
        let norm = now.norm_ut - before.norm_ut;
        let vertical = now.vertical_ut - before.vertical_ut;
        let change = (0.5 * (norm * norm + vertical * vertical) - 2.0 * noise_ut2).max(0.0);
        state.covariance.add_variance(DEVIATION, change / (horizontal * horizontal));
    }
}

impl Default for Compass {
    fn default() -> Self {
        Self::new()
    }
}

/// Brings an angle into −π to π.
fn wrap(angle: f64) -> f64 {
    use core::f64::consts::{PI, TAU};
    if angle > PI {
        angle - TAU
    } else if angle < -PI {
        angle + TAU
    } else {
        angle
    }
}
