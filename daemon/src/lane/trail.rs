//! What a camera's anchor had drifted at instants of the last seconds.
//!
//! A measurement against an anchor is some tenths of a second old when it comes, and was given in the world by
//! the anchor's pose of then. What the anchor has corrected since, its follower must make up for.

use lodestone_fusion::{Anchor, Drift};

/// Looks at the anchor that are kept: at ten a second, the age that a measurement may have, and some.
const KEPT: usize = 24;

/// Looks at one anchor, the oldest one being overwritten.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trail {
    anchor: Option<u16>,
    /// Times of validity, `CLOCK_MONOTONIC`, ns.
    looks: [Option<(i64, Drift)>; KEPT],
    next: usize,
}

impl Trail {
    pub(super) const NONE: Self = Self { anchor: None, looks: [None; KEPT], next: 0 };

    /// Takes a look at an anchor; one at another anchor is the first one.
    pub(super) fn note(&mut self, anchor: &Anchor, time_ns: i64) {
        if self.anchor != Some(anchor.id) {
            *self = Self { anchor: Some(anchor.id), ..Self::NONE };
        }
        self.looks[self.next] = Some((time_ns, anchor.drift));
        self.next = (self.next + 1) % KEPT;
    }

    /// What an anchor had drifted at an instant between two looks; `None` where it was not looked at.
    pub(super) fn at(&self, anchor: u16, time_ns: i64) -> Option<Drift> {
        if self.anchor != Some(anchor) {
            return None;
        }
        let looks = || self.looks.iter().flatten();
        let (before_ns, before) =
            looks().filter(|(at_ns, _)| *at_ns <= time_ns).max_by_key(|(at_ns, _)| *at_ns)?;
        let (after_ns, after) =
            looks().filter(|(at_ns, _)| *at_ns > time_ns).min_by_key(|(at_ns, _)| *at_ns)?;
        let share = (time_ns - before_ns) as f64 / (after_ns - before_ns) as f64;
        before.towards(after, share)
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};
    use lodestone_fusion::SensorTime;

    use super::*;

    fn anchor(id: u16, way_m: f64, began: i64) -> Anchor {
        Anchor {
            id,
            position_m: DVec3::ZERO,
            orientation_covariance: DMat3::ZERO,
            position_covariance: DMat3::ZERO,
            drift: Drift { way_m, ..Drift::new(SensorTime::from_nanos(began)) },
        }
    }

    #[test]
    fn between_two_looks_the_drift_is_between_them_and_beyond_it_is_not_known() {
        let mut trail = Trail::NONE;
        for k in 0..40 {
            trail.note(&anchor(3, 0.1 * f64::from(k), 0), i64::from(k) * 100);
        }
        let way_m = |id, time_ns| trail.at(id, time_ns).map(|drift| drift.way_m);
        assert!((way_m(3, 3_250).unwrap() - 3.25).abs() < 1e-12);
        assert_eq!((way_m(3, 3_950), way_m(3, 100), way_m(2, 3_250)), (None, None, None));
        // One that began anew in between is not to be compared, and another one is looked at from now on.
        trail.note(&anchor(3, 0.0, 77), 4_000);
        assert_eq!(trail.at(3, 3_950), None);
        trail.note(&anchor(2, 0.0, 0), 4_100);
        assert_eq!(trail.at(3, 3_250), None);
    }
}
