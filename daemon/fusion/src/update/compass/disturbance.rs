//! Whether the field is the expected one, and how the expectation follows it.

use glam::DVec3;

use super::reference::FieldReference;
use super::smoothing_share;
use crate::parameters::CompassParameters;

/// The expected field, and how the field has lately differed from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Expectation {
    pub(super) reference: FieldReference,
    /// Time over which the reference has been averaged, s.
    age_s: f64,
    /// What the field has too much of, in the world, smoothed, µT.
    excess_ut: DVec3,
    pub(super) disturbed: bool,
    disturbed_s: f64,
    candidate: Option<Candidate>,
}

/// A steady field that is not the expected one: perhaps the new one to expect.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Candidate {
    field: FieldReference,
    span_s: f64,
    turn_rad: f64,
}

/// What a compass average says about the field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen {
    /// The field in the world, µT.
    pub(super) field: DVec3,
    /// What timing and tilt make uncertain about it, µT.
    pub(super) blur_ut: f64,
    /// Where the horizontal field should point, from the world's north, east positive, rad.
    pub(super) bearing_rad: f64,
    /// Time since the last average, s, and the turn meanwhile, rad.
    pub(super) span_s: f64,
    pub(super) turn_rad: f64,
}

/// A disturbance ends at this part of the limit at which it began.
const END: f64 = 0.6;
/// A steady field is expected from then on when the camera has turned so far in it, so long: what is
/// fixed to the camera would have changed meanwhile (Laidig and Seel 2023 accept a new norm and dip
/// so).
const ACCEPT_TURN_RAD: f64 = 6.0;
const ACCEPT_S: f64 = 120.0;

impl Expectation {
    /// Expects a field that was averaged over some time, s.
    pub(super) fn of(field: DVec3, age_s: f64) -> Self {
        Self {
            reference: FieldReference::of(field),
            age_s,
            excess_ut: DVec3::ZERO,
            disturbed: false,
            disturbed_s: 0.0,
            candidate: None,
        }
    }

    /// Judges what is seen, with hysteresis, and lets the expectation follow.
    pub(super) fn judge(&mut self, seen: &Seen, p: &CompassParameters) {
        let share = smoothing_share(seen.span_s, p.mismatch_time_constant_s);
        let excess_ut = seen.field - self.reference.in_world(seen.bearing_rad);
        self.excess_ut += share * (excess_ut - self.excess_ut);
        let limit_ut = if self.disturbed { END } else { 1.0 } * p.mismatch_limit_ut;
        let size_ut = libm::sqrt(self.excess_ut.length_squared());
        self.disturbed = size_ut > limit_ut + seen.blur_ut;
        if self.disturbed {
            self.disturbed_s += seen.span_s;
            self.consider(seen, p);
        } else {
            self.disturbed_s = 0.0;
            self.candidate = None;
            self.age_s += seen.span_s;
            let time_constant_s = p.reference_time_constant_s.min(self.age_s);
            self.reference.follow(seen.field, (seen.span_s / time_constant_s).min(1.0));
        }
    }

    /// Whether the field is disturbed, and not for longer than patience lasts, s.
    pub(super) fn is_doubted(&self, patience_s: f64) -> bool {
        self.disturbed && self.disturbed_s < patience_s
    }

    /// Size of a disturbance, µT, in which what turns the heading counts as well; 0 without one, and
    /// when it lasts longer than patience, s: then it may be the heading that is wrong.
    pub(super) fn doubt_ut(&self, patience_s: f64) -> f64 {
        if self.is_doubted(patience_s) { libm::sqrt(self.excess_ut.length_squared()) } else { 0.0 }
    }

    /// Gets used to another field, if it is the same wherever the camera turns.
    fn consider(&mut self, seen: &Seen, p: &CompassParameters) {
        let now = FieldReference::of(seen.field);
        let fresh = Candidate { field: now, span_s: 0.0, turn_rad: 0.0 };
        let mut candidate = self.candidate.unwrap_or(fresh);
        if candidate.field.distance_ut(&now) > p.mismatch_limit_ut + seen.blur_ut {
            candidate = fresh;
        }
        candidate.span_s += seen.span_s;
        candidate.turn_rad += seen.turn_rad;
        let time_constant_s = candidate.span_s.min(p.reference_time_constant_s);
        candidate.field.follow(seen.field, (seen.span_s / time_constant_s).min(1.0));
        if candidate.span_s > ACCEPT_S && candidate.turn_rad > ACCEPT_TURN_RAD {
            self.reference = candidate.field;
            self.age_s = candidate.span_s;
        }
        self.candidate = Some(candidate);
    }
}
