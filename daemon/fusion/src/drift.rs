//! How far a camera's errors may have moved on since an instant, as sums that another camera can compare.
//!
//! Two cameras whose relative pose was measured share their errors from then on, until each goes its own
//! way. What leads them apart is, for each of them,
//!
//! - noise of the gyroscope, whose variances add up;
//! - biases and velocities: these errors last, in whatever direction the camera turns meanwhile. By
//!   Minkowski's inequality `σ(∫ x dt) ≤ ∫ σ(x) dt`, so their standard deviations are integrated;
//! - corrections by its own measurements, which the other one does not make. An innovation is white, so
//!   their squares add up; on average a correction's square is what the covariance loses by it
//!   (`K S Kᵀ = P⁻ − P⁺`, Bar-Shalom, Li, Kirubarajan 2001, ch. 5.2). What they came to is known, and a
//!   camera that is tied to this one makes them too ([`crate::Estimator::follow`]).
//!
//! All are kept as sums since the filter began, which never decrease: the difference of two readings
//! is the drift in between.

use glam::DVec3;

use crate::covariance::{Block, Covariance, GYRO_BIAS, ORIENTATION, POSITION, Row, VELOCITY};
use crate::time::SensorTime;

/// Sums since a filter began. Two of them compare if `began` is the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    /// When the filter was aligned, crossed a gap, or was put elsewhere: nothing before compares.
    pub began: SensorTime,
    /// Variance of the orientation by the gyroscope's noise, per axis, rad².
    pub angle_rad2: f64,
    /// Standard deviation of the orientation by the gyroscope's bias, rad.
    pub bias_rad: f64,
    /// Standard deviation of the position by the velocity while the camera moves, m.
    pub way_m: f64,
    /// Squares of the corrections of the orientation about the world's axes, rad².
    pub turned_rad2: DVec3,
    /// Squares of the corrections of the position along the world's axes, m².
    pub shifted_m2: DVec3,
    /// What the corrections of the orientation came to, rad.
    pub turned_rad: DVec3,
    /// What the corrections of the position came to, m.
    pub shifted_m: DVec3,
}

/// Variances by which two instants differ, about and along the world's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drifted {
    /// Of the orientation, rad².
    pub orientation_rad2: DVec3,
    /// Of the position, m².
    pub position_m2: DVec3,
}

impl Drifted {
    /// One instant.
    pub const NOTHING: Self = Self { orientation_rad2: DVec3::ZERO, position_m2: DVec3::ZERO };
}

impl Drift {
    /// Nothing yet.
    pub const fn new(began: SensorTime) -> Self {
        Self {
            began,
            angle_rad2: 0.0,
            bias_rad: 0.0,
            way_m: 0.0,
            turned_rad2: DVec3::ZERO,
            shifted_m2: DVec3::ZERO,
            turned_rad: DVec3::ZERO,
            shifted_m: DVec3::ZERO,
        }
    }

    /// Time passes: `noise_rad2` is the gyroscope's over the span; the position followed the velocity for
    /// `moved_s` of it.
    pub(crate) fn pass(&mut self, p: &Covariance, noise_rad2: f64, (span_s, moved_s): (f64, f64)) {
        let sigma = |block| libm::sqrt(p.variances(block).max_element().max(0.0));
        self.angle_rad2 += noise_rad2;
        self.bias_rad += sigma(GYRO_BIAS) * span_s;
        if moved_s > 0.0 {
            self.way_m += sigma(VELOCITY) * moved_s;
        }
    }

    /// The state is corrected by an error.
    pub(crate) fn correct(&mut self, error: &Row) {
        let part = |b: Block| DVec3::new(error[b.0], error[b.0 + 1], error[b.0 + 2]);
        let (turned, shifted) = (part(ORIENTATION), part(POSITION));
        self.turned_rad += turned;
        self.turned_rad2 += turned * turned;
        self.shifted_m += shifted;
        self.shifted_m2 += shifted * shifted;
    }

    /// The corrections since an earlier reading, of orientation, rad, and position, m.
    pub(crate) fn corrections_since(&self, earlier: &Self) -> [DVec3; 2] {
        [self.turned_rad - earlier.turned_rad, self.shifted_m - earlier.shifted_m]
    }

    /// An earlier reading with the corrections up to this one: they were made up for.
    pub(crate) const fn corrected_as(&self, now: &Self) -> Self {
        Self {
            turned_rad: now.turned_rad,
            turned_rad2: now.turned_rad2,
            shifted_m: now.shifted_m,
            shifted_m2: now.shifted_m2,
            ..*self
        }
    }

    /// A reading between this one and a later one, by the share of the time; `None` if they do not compare.
    pub fn towards(&self, later: &Self, share: f64) -> Option<Self> {
        let number = |from: f64, to: f64| from + (to - from) * share;
        let vector = |from: DVec3, to: DVec3| from + (to - from) * share;
        (self.began == later.began).then(|| Self {
            began: self.began,
            angle_rad2: number(self.angle_rad2, later.angle_rad2),
            bias_rad: number(self.bias_rad, later.bias_rad),
            way_m: number(self.way_m, later.way_m),
            turned_rad2: vector(self.turned_rad2, later.turned_rad2),
            shifted_m2: vector(self.shifted_m2, later.shifted_m2),
            turned_rad: vector(self.turned_rad, later.turned_rad),
            shifted_m: vector(self.shifted_m, later.shifted_m),
        })
    }

    /// What lies between two readings, whichever is the earlier one; `None` if they do not compare.
    pub fn between(&self, other: &Self) -> Option<Drifted> {
        let (one, two) = (self.since(other)?, other.since(self)?);
        Some(Drifted {
            orientation_rad2: one.orientation_rad2.max(two.orientation_rad2),
            position_m2: one.position_m2.max(two.position_m2),
        })
    }

    /// What lies between an earlier reading and this one; `None` if they do not compare.
    pub fn since(&self, earlier: &Self) -> Option<Drifted> {
        if self.began != earlier.began {
            return None;
        }
        let square = |x: f64| x * x;
        let angle = self.angle_rad2 - earlier.angle_rad2 + square(self.bias_rad - earlier.bias_rad);
        let way = square(self.way_m - earlier.way_m);
        // Rounding must not make a variance negative.
        let sum = |common: f64, own: DVec3| (DVec3::splat(common) + own).max(DVec3::ZERO);
        Some(Drifted {
            orientation_rad2: sum(angle, self.turned_rad2 - earlier.turned_rad2),
            position_m2: sum(way, self.shifted_m2 - earlier.shifted_m2),
        })
    }
}
