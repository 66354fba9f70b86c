//! A closed path in the plane, by arc length.
//!
//! The heading is given, the position is its integral: straights, and turns in which the heading
//! follows the quintic blend of the arc length. So curvature begins and ends at zero with zero
//! slope, the way a road or a rail is laid out, and position is C³ in arc length. The integral of
//! a turn has no closed form; Gauss-Legendre quadrature over short pieces is exact to rounding.

use std::f64::consts::PI;

use glam::DVec2;

use crate::driver::synthetic::jet::{Blend, Jet};

/// A stretch of the path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    /// Arc length, m.
    pub(crate) length_m: f64,
    /// Change of heading along it, rad, left positive; 0 is straight.
    pub(crate) turn_rad: f64,
}

impl Segment {
    /// Goes straight on.
    pub(crate) const fn straight(length_m: f64) -> Self {
        Self { length_m, turn_rad: 0.0 }
    }

    /// Turns by `turn_rad` (left positive) with a smallest radius of `radius_m`.
    pub(crate) fn turn(turn_rad: f64, radius_m: f64) -> Self {
        // The blend is steepest in the middle, with slope 1.875.
        Self { length_m: 1.875 * turn_rad.abs() * radius_m, turn_rad }
    }

    fn pieces(&self) -> usize {
        const TURN_OF_ONE_PIECE: f64 = PI / 16.0;
        (self.turn_rad.abs() / TURN_OF_ONE_PIECE).ceil().max(1.0) as usize
    }
}

/// A part of a segment, short enough for the quadrature.
#[derive(Clone, Copy, Debug)]
struct Piece {
    start_m: f64,
    start: DVec2,
    segment: Segment,
    segment_start_m: f64,
    /// Heading where the segment begins, rad.
    heading_rad: f64,
}

impl Piece {
    fn heading(&self, distance: Jet) -> Jet {
        let part = (distance + -self.segment_start_m) * self.segment.length_m.recip();
        part.blend() * self.segment.turn_rad + self.heading_rad
    }

    fn curvature(&self, distance: Jet) -> Jet {
        let rate = self.segment.length_m.recip();
        let blend = Blend::at((distance.value - self.segment_start_m) * rate);
        let scale = self.segment.turn_rad * rate;
        let (first, second) = (scale * blend.second * rate, scale * blend.third * rate * rate);
        distance.chain(scale * blend.first, first, second)
    }

    /// Position at an arc length within the piece, by five-point Gauss-Legendre quadrature.
    fn position(&self, distance_m: f64) -> DVec2 {
        const NODES: [(f64, f64); 5] = [
            (0.0, 0.568_888_888_888_888_9),
            (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
            (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
            (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
            (0.906_179_845_938_664, 0.236_926_885_056_189_08),
        ];
        let half = 0.5 * (distance_m - self.start_m);
        if self.segment.turn_rad == 0.0 {
            return self.start + DVec2::from_angle(self.heading_rad) * (2.0 * half);
        }
        NODES.iter().fold(self.start, |sum, (node, weight)| {
            let at = Jet::constant(self.start_m + half * (1.0 + node));
            sum + DVec2::from_angle(self.heading(at).value) * (half * weight)
        })
    }
}

/// Where a path is at one arc length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathPoint {
    /// Position, m.
    pub(crate) x: Jet,
    /// Position, m.
    pub(crate) y: Jet,
    /// Heading, rad from x toward y; grows over the laps.
    pub(crate) heading: Jet,
    /// Curvature, rad/m, left positive.
    pub(crate) curvature: Jet,
    /// Arc length within the lap, m.
    pub(crate) within: Jet,
}

/// A closed path that begins at the origin.
#[derive(Clone, Debug)]
pub(crate) struct Path {
    pieces: Vec<Piece>,
    lap_m: f64,
    lap_turn_rad: f64,
}

impl Path {
    /// Lays the segments one behind the other, beginning at the origin with `heading_rad`. They
    /// must close: end at the origin with the first heading, up to whole turns.
    pub(crate) fn closed(heading_rad: f64, segments: &[Segment]) -> Self {
        let mut path = Self { pieces: Vec::new(), lap_m: 0.0, lap_turn_rad: 0.0 };
        let mut end = DVec2::ZERO;
        for &segment in segments {
            end = path.lay(end, heading_rad, segment);
        }
        debug_assert!(end.length() < 1e-6, "the path does not close: it ends at {end}");
        path
    }

    /// A path of `times` equal blocks, which closes if one block turns by a whole turn over `times`
    /// (any block that turns by ±180°, laid twice, comes back to where it began).
    pub(crate) fn repeated(heading_rad: f64, block: &[Segment], times: usize) -> Self {
        Self::closed(heading_rad, &block.repeat(times))
    }

    fn lay(&mut self, from: DVec2, first_heading_rad: f64, segment: Segment) -> DVec2 {
        let count = segment.pieces();
        let mut piece = Piece {
            start_m: self.lap_m,
            start: from,
            segment,
            segment_start_m: self.lap_m,
            heading_rad: first_heading_rad + self.lap_turn_rad,
        };
        for k in 1..=count {
            self.pieces.push(piece);
            let end_m = piece.segment_start_m + segment.length_m * k as f64 / count as f64;
            piece.start = piece.position(end_m);
            piece.start_m = end_m;
        }
        self.lap_m += segment.length_m;
        self.lap_turn_rad += segment.turn_rad;
        piece.start
    }

    /// The path at an arc length since its beginning.
    pub(crate) fn at(&self, distance: Jet) -> PathPoint {
        let lap = (distance.value / self.lap_m).floor();
        let within = Jet {
            // Rounding may put the remainder a hair outside of the lap.
            value: (distance.value - lap * self.lap_m).clamp(0.0, self.lap_m),
            ..distance
        };
        let after = self.pieces.partition_point(|p| p.start_m <= within.value);
        let piece = &self.pieces[after.max(1) - 1];
        let position = piece.position(within.value);
        let heading = piece.heading(within) + lap * self.lap_turn_rad;
        let (sin, cos) = heading.sin_cos();
        PathPoint {
            x: Jet::integral(position.x, cos, within),
            y: Jet::integral(position.y, sin, within),
            heading,
            curvature: piece.curvature(within),
            within,
        }
    }

    /// Length of one lap, m.
    #[cfg(test)]
    pub(crate) fn lap_m(&self) -> f64 {
        self.lap_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::FRAC_PI_2;

    fn path() -> Path {
        let block = [
            Segment::straight(30.0),
            Segment::turn(0.4, 10.0),
            Segment::turn(-0.4, 10.0),
            Segment::turn(FRAC_PI_2, 8.0),
            Segment::straight(7.0),
            Segment::turn(FRAC_PI_2, 12.0),
        ];
        Path::repeated(0.7, &block, 2)
    }

    #[test]
    fn a_block_that_turns_back_laid_twice_closes() {
        let path = path();
        let end = path.at(Jet::constant(path.lap_m() - 1e-12));
        assert!(end.x.value.hypot(end.y.value) < 1e-9, "{end:?}");
        let after_laps = path.at(Jet::constant(5.0 * path.lap_m() + 3.0));
        let first = path.at(Jet::constant(3.0));
        assert!((after_laps.x.value - first.x.value).abs() < 1e-9);
        assert!((after_laps.heading.value - first.heading.value - 10.0 * PI).abs() < 1e-9);
    }

    proptest! {
        #[test]
        fn derivatives_agree_with_central_differences(s in 0.5..500.0f64) {
            const STEP: f64 = 1e-4;
            let path = path();
            let at = |s: f64| path.at(Jet::new(s, 1.0, 0.0));
            let (a, b, c) = (at(s - STEP), at(s), at(s + STEP));
            for (a, b, c) in [(a.x, b.x, c.x), (a.y, b.y, c.y), (a.heading, b.heading, c.heading)] {
                prop_assert!(((c.value - a.value) / (2.0 * STEP) - b.first).abs() < 1e-7);
                prop_assert!(((c.first - a.first) / (2.0 * STEP) - b.second).abs() < 1e-6);
            }
            prop_assert!((b.heading.first - b.curvature.value).abs() < 1e-12);
            prop_assert!((b.heading.second - b.curvature.first).abs() < 1e-12);
        }
    }

    #[test]
    fn a_turn_keeps_its_smallest_radius() {
        let path = path();
        let sharpest = (0..50_000)
            .map(|k| path.at(Jet::constant(f64::from(k) * path.lap_m() / 50_000.0)).curvature.value)
            .fold(0.0, f64::max);
        assert!((sharpest - 1.0 / 8.0).abs() < 1e-6, "{sharpest}");
    }
}
