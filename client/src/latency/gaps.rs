//! Times at which a core did not run what was to run on it.

use core::time::Duration;

/// What keeps a core from its work for longer is a gap: far above a step, far below a late pose.
pub const GAP_THRESHOLD: Duration = Duration::from_micros(50);

/// From the last sign of life to the next, `CLOCK_MONOTONIC`, ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gap {
    /// The last sign of life before.
    pub begin_ns: i64,
    /// The first one after.
    pub end_ns: i64,
}

impl Gap {
    /// How long it lasted, ns.
    pub const fn span_ns(&self) -> i64 {
        self.end_ns.saturating_sub(self.begin_ns)
    }
}

/// Gaps, ordered and apart: those that touch become one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Gaps(Vec<Gap>);

impl Gaps {
    /// Puts gaps of any origin and order together; those that end before they begin are none.
    pub fn of(gaps: impl IntoIterator<Item = Gap>) -> Self {
        let mut sorted: Vec<Gap> = gaps.into_iter().filter(|gap| gap.span_ns() >= 0).collect();
        sorted.sort_by_key(|gap| gap.begin_ns);
        let mut apart: Vec<Gap> = Vec::with_capacity(sorted.len());
        for gap in sorted {
            match apart.last_mut() {
                Some(last) if gap.begin_ns <= last.end_ns => {
                    last.end_ns = last.end_ns.max(gap.end_ns);
                }
                _ => apart.push(gap),
            }
        }
        Self(apart)
    }

    /// Whether one of them lies, wholly or in part, between two times.
    pub fn cross(&self, from_ns: i64, to_ns: i64) -> bool {
        let first = self.0.partition_point(|gap| gap.end_ns < from_ns);
        self.0.get(first).is_some_and(|gap| gap.begin_ns <= to_ns)
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// All together, ns.
    pub fn total_ns(&self) -> i64 {
        self.0.iter().map(Gap::span_ns).sum()
    }

    /// The longest, ns; 0 without any.
    pub fn longest_ns(&self) -> i64 {
        self.0.iter().map(Gap::span_ns).max().unwrap_or(0)
    }

    /// In their order.
    pub fn iter(&self) -> impl Iterator<Item = Gap> + '_ {
        self.0.iter().copied()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn gap(begin_ns: i64, end_ns: i64) -> Gap {
        Gap { begin_ns, end_ns }
    }

    #[test]
    fn gaps_of_two_cores_that_overlap_are_one() {
        // Given a host that stopped both cores at about the same time, and one of them again later
        let gaps = Gaps::of([gap(500, 600), gap(100, 200), gap(150, 260), gap(9, 3)]);
        assert_eq!(gaps.iter().collect::<Vec<_>>(), [gap(100, 260), gap(500, 600)]);
        assert_eq!((gaps.count(), gaps.total_ns(), gaps.longest_ns()), (2, 260, 160));
    }

    #[test]
    fn a_way_crosses_a_gap_if_any_part_of_it_does() {
        let gaps = Gaps::of([gap(100, 200), gap(500, 600)]);
        for (way, crosses) in [
            ((10, 99), false),
            ((10, 100), true),
            ((120, 130), true),
            ((200, 210), true),
            ((201, 499), false),
            ((201, 700), true),
            ((601, 900), false),
        ] {
            assert_eq!(gaps.cross(way.0, way.1), crosses, "{way:?}");
        }
        assert!(!Gaps::default().cross(i64::MIN, i64::MAX));
        assert_eq!(Gaps::default().longest_ns(), 0);
    }

    proptest! {
        #[test]
        fn a_search_finds_what_a_look_at_each_gap_finds(
            begins in prop::collection::vec((0_i64..1000, 0_i64..50), 0..40),
            from in 0_i64..1000, span in 0_i64..100,
        ) {
            let gaps: Vec<Gap> = begins.iter().map(|(at, span)| gap(*at, at + span)).collect();
            let each = gaps.iter().any(|g| g.begin_ns <= from + span && g.end_ns >= from);
            prop_assert_eq!(Gaps::of(gaps).cross(from, from + span), each);
        }
    }
}
