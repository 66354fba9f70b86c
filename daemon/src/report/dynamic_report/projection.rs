//! How a way in space is laid on paper: along the stairs, from the side, from above, isometric.

use std::f64::consts::FRAC_PI_6;

use glam::{DMat3, DVec3};

use crate::evaluation::dynamic::track::Track;

/// One way to look at it.
#[derive(Clone, Copy)]
pub(super) struct View {
    /// What it is called.
    pub(super) name: &'static str,
    /// Labels of the axes; `None` where the picture draws its own.
    pub(super) labels: Option<(&'static str, &'static str)>,
    /// Where a point (along the stairs, across to the left, up, m) lies, m.
    pub(super) project: fn(DVec3) -> (f64, f64),
}

/// The paper's perspective, and the two in which lengths can be read.
pub(super) const VIEWS: [View; 3] = [
    View { name: "isometric", labels: None, project: isometric },
    View {
        name: "from the side",
        labels: Some(("along the stairs, m", "height, m")),
        project: |p| (p.x, p.z),
    },
    View {
        name: "from above",
        labels: Some(("along the stairs, m", "to the left, m")),
        project: |p| (p.x, p.y),
    },
];

/// An isometric drawing (ISO 5456-3): lengths along all three axes are true.
fn isometric(p: DVec3) -> (f64, f64) {
    let (sin, cos) = FRAC_PI_6.sin_cos();
    ((p.x - p.y) * cos, p.z + (p.x + p.y) * sin)
}

/// The turn about the vertical that lays a way's longer horizontal direction along x, its beginning
/// forward. It serves the drawing alone.
pub(super) fn along(truth: &Track) -> DMat3 {
    let count = truth.0.len().max(1) as f64;
    let middle = truth.0.iter().map(|p| p.position_m).sum::<DVec3>() / count;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for point in &truth.0 {
        let from = point.position_m - middle;
        xx += from.x * from.x;
        xy += from.x * from.y;
        yy += from.y * from.y;
    }
    // Direction of the larger principal axis of [[xx, xy], [xy, yy]].
    let bearing = 0.5 * (2.0 * xy).atan2(xx - yy);
    let turn = DMat3::from_rotation_z(-bearing);
    let first = truth.0.get(truth.0.len() / 10).map_or(DVec3::ZERO, |p| turn * p.position_m);
    if first.x < 0.0 { DMat3::from_rotation_z(std::f64::consts::PI) * turn } else { turn }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::dynamic::track::TrackPoint;
    use lodestone_fusion::Rotation;

    #[test]
    fn an_isometric_drawing_keeps_lengths_along_the_axes() {
        for axis in DVec3::AXES {
            let (x, y) = isometric(axis);
            assert!((x.hypot(y) - 1.0).abs() < 1e-12, "{axis}");
        }
    }

    #[test]
    fn the_way_is_laid_along_x_and_begins_forward() {
        for bearing in [0.3_f64, 1.9, -2.5] {
            let ahead = DVec3::new(bearing.cos(), bearing.sin(), 0.0);
            let point = |k: u32| TrackPoint {
                time_s: f64::from(k),
                position_m: ahead * f64::from(k) + DVec3::Z * 0.5 * f64::from(k),
                orientation: Rotation::IDENTITY,
            };
            let turn = along(&Track((0..30).map(point).collect()));
            assert!((turn * ahead - DVec3::X).length() < 1e-9, "{bearing}");
        }
    }
}
