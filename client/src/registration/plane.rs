//! The plane through a point's neighbours.

use glam::{DMat3, DVec3};
use nalgebra::SymmetricEigen;

use super::prior::matrix3;

/// A small piece of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    /// Where it is, m.
    pub(super) point: DVec3,
    /// Unit normal; of either sign.
    pub(super) normal: DVec3,
    /// Variance of the plane's height at its point, m².
    pub(super) height_variance_m2: f64,
    /// Variance of its points' distances to it, m².
    pub(super) thickness_m2: f64,
    /// Variance of the normal's direction, about one axis, rad².
    pub(super) tilt_variance_rad2: f64,
}

impl Plane {
    /// Without noise.
    #[cfg(test)]
    pub(super) const fn ideal(point: DVec3, normal: DVec3) -> Self {
        let (height_variance_m2, thickness_m2, tilt_variance_rad2) = (0.0, 0.0, 0.0);
        Self { point, normal, height_variance_m2, thickness_m2, tilt_variance_rad2 }
    }

    /// Principal components of a point's neighbours, each with its weight; with their planarity
    /// `(σ₁ − σ₀) / σ₂`, `σ₀ ≤ σ₁ ≤ σ₂`: 1 is a disc, 0 a line or a ball (Demantké et al. 2011,
    /// "Dimensionality based scale selection in 3D lidar point clouds").
    pub(super) fn fit(at: DVec3, neighbours: &[(DVec3, f64)]) -> (Self, f64) {
        let total: f64 = neighbours.iter().map(|(_, weight)| weight).sum();
        let middle = neighbours.iter().map(|(p, weight)| *p * *weight).sum::<DVec3>() / total;
        let (mut scatter, mut squares) = (DMat3::ZERO, 0.0);
        for (neighbour, weight) in neighbours {
            let (d, share) = (*neighbour - middle, weight / total);
            scatter += DMat3::from_cols(d * d.x, d * d.y, d * d.z) * share;
            squares += share * share;
        }
        let eigen = SymmetricEigen::new(matrix3(scatter));
        let order = ascending(eigen.eigenvalues.as_slice());
        let [thin, wide, wider] = order.map(|i| eigen.eigenvalues[i].max(0.0));
        let normal = eigen.eigenvectors.column(order[0]);
        let normal = DVec3::new(normal[0], normal[1], normal[2]);
        let count = squares.recip();
        let plane = Self {
            point: at - normal * normal.dot(at - middle),
            normal,
            height_variance_m2: thin / (count - 3.0).max(1.0),
            thickness_m2: thin,
            tilt_variance_rad2: thin / (wide * count),
        };
        let planarity = if wider > 0.0 { (wide.sqrt() - thin.sqrt()) / wider.sqrt() } else { 0.0 };
        (plane, planarity)
    }
}

fn ascending(values: &[f64]) -> [usize; 3] {
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(of: impl Fn(f64, f64) -> DVec3) -> Vec<(DVec3, f64)> {
        (0..49).map(|i| (of(f64::from(i % 7) - 3.0, f64::from(i / 7) - 3.0), 1.0)).collect()
    }

    #[test]
    fn a_disc_is_a_plane_with_its_normal() {
        let points = grid(|u, v| DVec3::new(1.0, u * 0.1, v * 0.1));
        let (plane, planarity) = Plane::fit(DVec3::new(1.0, 0.1, 0.0), &points);
        assert!(planarity > 0.99);
        assert!(plane.normal.x.abs() > 1.0 - 1e-12);
        assert!(plane.point.abs_diff_eq(DVec3::new(1.0, 0.1, 0.0), 1e-12));
        assert!(plane.height_variance_m2 < 1e-12);
    }

    #[test]
    fn an_edge_a_line_and_a_heap_are_not_planar() {
        let edge = grid(|u, v| DVec3::new(u.max(0.0), (-u).max(0.0), v));
        let line = grid(|u, v| DVec3::new(u * 7.0 + v, 0.0, 0.0));
        let heap = grid(|u, v| DVec3::new(u, v, (u * v * 1.7).sin() * 3.0));
        let one_place = grid(|_, _| DVec3::X);
        for points in [edge, line, heap, one_place] {
            assert!(Plane::fit(DVec3::ZERO, &points).1 < 0.5);
        }
    }
}
