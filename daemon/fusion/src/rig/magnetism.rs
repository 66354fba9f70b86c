//! The field as the whole rig sees it: a mean for the compass, and which magnetometer stands alone.
//!
//! A magnet beside one camera disturbs that camera; steel in a wall bends the field for all. So each
//! magnetometer is compared with what the others say about its place: their field and gradient where
//! they tell one, else their mean, give or take the gradient that steel makes. One that differs by more
//! while the others agree is left out. So is one whose reading is suddenly not what the gradient's
//! filter foresaw, while the others' are: steel comes on as the rig moves, and for all.

use glam::DVec3;

use super::array::FieldFit;
use super::geometry::{Geometry, MAX_MEMBERS};
use super::gradient::Readings;
use crate::so3;

/// Parameters of the comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MagnetismParameters {
    /// Difference from what the others say that is usual, µT: noise, calibration. Default 3.5.
    pub limit_ut: f64,
    /// Gradient that steel may make, µT/m, where the others cannot tell it. Default 40.
    pub steel_ut_m: f64,
    /// Time over which differences are averaged, s. Default 0.3.
    pub average_s: f64,
}

impl Default for MagnetismParameters {
    fn default() -> Self {
        Self { limit_ut: 3.5, steel_ut_m: 40.0, average_s: 0.3 }
    }
}

/// A magnetometer's latest reading.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Latest {
    /// Carried along in the rig's axes, µT.
    field: DVec3,
    age_s: f64,
    /// Not averaged yet.
    fresh: bool,
}

/// The state of the comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Magnetism {
    p: MagnetismParameters,
    latest: [Option<Latest>; MAX_MEMBERS],
    /// Smoothed differences from what the others say, µT.
    beside: [DVec3; MAX_MEMBERS],
    alone: [bool; MAX_MEMBERS],
    /// Told by the gradient's filter, which sees the field change over time.
    odd: [bool; MAX_MEMBERS],
    waiting_s: f64,
}

/// A reading older than this says nothing about now, s.
const STALE_S: f64 = 0.1;
/// Longest wait for all members' readings before a mean is made of what there is, s.
const WAIT_S: f64 = 0.03;
/// A disturbance ends at this part of the limit at which it began.
const END: f64 = 0.6;

impl Magnetism {
    pub(crate) const fn new(p: MagnetismParameters) -> Self {
        Self {
            p,
            latest: [None; MAX_MEMBERS],
            beside: [DVec3::ZERO; MAX_MEMBERS],
            alone: [false; MAX_MEMBERS],
            odd: [false; MAX_MEMBERS],
            waiting_s: 0.0,
        }
    }

    /// Whether a member's magnetometer is disturbed and the others' are not.
    pub(crate) const fn is_alone(&self, member: usize) -> bool {
        self.alone[member] || self.odd[member]
    }

    /// Whether a member's magnetometer is far from the others', by itself.
    pub(crate) const fn is_far(&self, member: usize) -> bool {
        self.alone[member]
    }

    /// Takes the readings of a step in which the rig turned by an angle, rad; gives the mean field in the
    /// rig's axes once every member has spoken, or has had its time.
    pub(crate) fn step(
        &mut self,
        readings: &Readings,
        odd: [bool; MAX_MEMBERS],
        (angle, span_s): (DVec3, f64),
        geometry: &Geometry,
    ) -> Option<DVec3> {
        let back = so3::exp(-angle);
        for (latest, reading) in self.latest.iter_mut().zip(readings) {
            if let Some(field) = *reading {
                *latest = Some(Latest { field, age_s: 0.0, fresh: true });
            } else if let Some(old) = latest {
                old.field = back * old.field;
                old.age_s += span_s;
            }
            *latest = latest.filter(|l| l.age_s < STALE_S);
        }
        self.compare(readings, geometry);
        self.odd = odd;
        self.mean(span_s)
    }

    fn compare(&mut self, readings: &Readings, geometry: &Geometry) {
        for member in (0..geometry.count()).filter(|&k| readings[k].is_some()) {
            let Some((others, allowed_ut)) = self.by_others(member, geometry) else {
                self.alone[member] = false;
                continue;
            };
            let Some(own) = self.latest[member] else { continue };
            // Readings come every 20 ms or so.
            let share = 0.02 / (0.02 + self.p.average_s);
            self.beside[member] += share * (own.field - others - self.beside[member]);
            let size = libm::sqrt(self.beside[member].length_squared());
            let limit = allowed_ut * if self.alone[member] { END } else { 1.0 };
            let largest = (0..geometry.count())
                .filter(|&k| k != member && !self.is_alone(k))
                .all(|k| self.beside[k].length_squared() < self.beside[member].length_squared());
            self.alone[member] = size > limit && (self.alone[member] || largest);
        }
    }

    /// What the others say about a member's place, µT, and how far it may differ.
    fn by_others(&self, member: usize, geometry: &Geometry) -> Option<(DVec3, f64)> {
        let others =
            (0..geometry.count()).filter(|&k| k != member && !self.is_alone(k)).filter_map(|k| {
                self.latest[k].map(|latest| (geometry.magnetometer_arm_m(k), latest.field))
            });
        let count = others.clone().count();
        if count < 2 {
            return None;
        }
        let place = geometry.magnetometer_arm_m(member);
        let fit = if count < 3 { None } else { FieldFit::of(others.clone()) };
        if let Some(fit) = fit {
            let reach = libm::sqrt(place.length_squared());
            let noise = fit.gradient_noise_per_m * reach;
            return Some((fit.at(place), self.p.limit_ut * (1.0 + noise)));
        }
        let n = count as f64;
        let (arms, fields) = others.fold((DVec3::ZERO, DVec3::ZERO), |s, o| (s.0 + o.0, s.1 + o.1));
        let distance = libm::sqrt((place - arms / n).length_squared());
        Some((fields / n, self.p.limit_ut + self.p.steel_ut_m * distance))
    }

    fn mean(&mut self, span_s: f64) -> Option<DVec3> {
        let latest = self.latest;
        let out: [bool; MAX_MEMBERS] = core::array::from_fn(|k| self.is_alone(k));
        let taken = || {
            let all = latest.iter().enumerate().filter(|(k, _)| !out[*k]);
            all.filter_map(|(_, latest)| *latest)
        };
        if !taken().any(|l| l.fresh) {
            self.waiting_s = 0.0;
            return None;
        }
        self.waiting_s += span_s;
        if self.waiting_s < WAIT_S && !taken().all(|l| l.fresh) {
            return None;
        }
        let (sum, count) = taken().fold((DVec3::ZERO, 0.0), |s, l| (s.0 + l.field, s.1 + 1.0));
        self.waiting_s = 0.0;
        for latest in self.latest.iter_mut().flatten() {
            latest.fresh = false;
        }
        Some(sum / count)
    }
}
