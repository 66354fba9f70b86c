//! What is drawn: coloured points in the world, and the cameras that saw them.

use glam::DVec3;

/// A point of a cloud.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    /// Position in the world (east, north, up), m.
    pub position_m: DVec3,
    /// Red, green, blue, as on a screen.
    pub colour: [u8; 3],
    /// Which cameras saw it: bit n for the n-th.
    pub seen_by: u32,
}

/// A camera as it is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Viewer {
    /// Its name.
    pub name: String,
    /// Where it is in the world (east, north, up), m.
    pub position_m: DVec3,
    /// Unit vector to where it looks, in the world.
    pub forward: DVec3,
    /// Half of its horizontal field of view, rad.
    pub half_view_rad: f64,
}

/// A box in the world, along its axes, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    /// Lowest coordinates.
    pub(super) low: DVec3,
    /// Highest coordinates.
    pub(super) high: DVec3,
}

impl Bounds {
    /// The box that holds all but a few points on each side: `outside` is the share of them that may be beyond
    /// each of its six faces. `None` without points.
    pub(super) fn of(dots: &[Dot], outside: f64) -> Option<Self> {
        let [x, y, z] = [0, 1, 2].map(|axis| range(dots, axis, outside));
        let (x, y, z) = (x?, y?, z?);
        Some(Self { low: DVec3::new(x.0, y.0, z.0), high: DVec3::new(x.1, y.1, z.1) })
    }

    /// The same box, larger by a margin on each side, m.
    #[must_use]
    pub(super) fn grown(self, margin_m: f64) -> Self {
        Self { low: self.low - DVec3::splat(margin_m), high: self.high + DVec3::splat(margin_m) }
    }

    /// The middle.
    pub(super) fn centre(self) -> DVec3 {
        (self.low + self.high) / 2.0
    }

    /// Length, width, height.
    pub(super) fn size(self) -> DVec3 {
        self.high - self.low
    }

    /// The eight corners.
    pub(super) fn corners(self) -> [DVec3; 8] {
        std::array::from_fn(|n| {
            let pick =
                |axis: usize, low: f64, high: f64| if n >> axis & 1 == 0 { low } else { high };
            let (low, high) = (self.low, self.high);
            DVec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z))
        })
    }
}

fn range(dots: &[Dot], axis: usize, outside: f64) -> Option<(f64, f64)> {
    let mut values: Vec<f64> = dots.iter().map(|dot| dot.position_m[axis]).collect();
    let last = values.len().checked_sub(1)?;
    let rank = (outside * last as f64) as usize;
    let low = *values.select_nth_unstable_by(rank, f64::total_cmp).1;
    let high = *values.select_nth_unstable_by(last - rank, f64::total_cmp).1;
    Some((low, high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_leave_out_strays_alone() {
        let at = |x: f64| Dot { position_m: DVec3::new(x, 1.0, 2.0), colour: [0; 3], seen_by: 1 };
        let mut dots: Vec<Dot> = (0..=1000).map(|n| at(f64::from(n) / 100.0)).collect();
        dots.push(at(500.0));
        let bounds = Bounds::of(&dots, 0.002).unwrap();
        assert!(bounds.low.x < 0.05 && (bounds.high.x - 10.0).abs() < 0.05, "{bounds:?}");
        assert_eq!((bounds.low.y, bounds.high.z), (1.0, 2.0));
        assert!(Bounds::of(&[], 0.002).is_none());
    }

    #[test]
    fn corners_are_all_different() {
        let bounds = Bounds { low: DVec3::ZERO, high: DVec3::ONE };
        let sum = bounds.corners().iter().fold(DVec3::ZERO, |sum, corner| sum + *corner);
        assert_eq!(sum, DVec3::splat(4.0));
        assert_eq!(bounds.grown(1.0).size(), DVec3::splat(3.0));
    }
}
