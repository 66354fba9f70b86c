//! Symmetric 3x3 matrices as messages hold them: the upper triangle `xx xy xz yy yz zz`.

use glam::{DMat3, DVec3};

/// The full matrix.
pub(crate) const fn matrix([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> DMat3 {
    DMat3::from_cols(DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz))
}

/// The upper triangle.
pub(crate) const fn triangle(m: &DMat3) -> [f64; 6] {
    [m.x_axis.x, m.y_axis.x, m.z_axis.x, m.y_axis.y, m.z_axis.y, m.z_axis.z]
}

/// `(1 - s) a + s b`: a mean of two covariances is one again.
pub(crate) fn mix(a: &[f64; 6], b: &[f64; 6], s: f64) -> [f64; 6] {
    core::array::from_fn(|i| a[i] * (1.0 - s) + b[i] * s)
}

pub(crate) fn trace(m: &DMat3) -> f64 {
    m.x_axis.x + m.y_axis.y + m.z_axis.z
}

/// `σ² I`.
pub(crate) fn isotropic(sigma: f64) -> DMat3 {
    DMat3::from_diagonal(DVec3::splat(sigma * sigma))
}

/// An upper bound of the covariance of `a + k b` when the correlation of `a` and `b` is unknown.
///
/// `P_a + k² P_b + k (r P_a + P_b / r)` bounds it for every `r > 0` (`P` plus the square of
/// `√r a - b / √r`); `r = √(tr P_b / tr P_a)` makes the trace of the bound smallest.
pub(crate) fn bound_of_sum(a: &DMat3, b: &DMat3, k: f64) -> DMat3 {
    let plain = *a + *b * (k * k);
    let r = (trace(b) / trace(a)).sqrt();
    let usable = r.is_finite() && r > 0.0;
    if usable { plain + (*a * r + *b * r.recip()) * k } else { plain }
}

/// `[v]×`, so that `[v]× w = v × w`.
pub(crate) const fn cross_matrix(v: DVec3) -> DMat3 {
    DMat3::from_cols(
        DVec3::new(0.0, v.z, -v.y),
        DVec3::new(-v.z, 0.0, v.x),
        DVec3::new(v.y, -v.x, 0.0),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangle_and_matrix_are_inverse() {
        let entries = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        assert_eq!(triangle(&matrix(entries)), entries);
        assert_eq!(matrix(entries), matrix(entries).transpose());
    }

    #[test]
    fn cross_matrix_is_the_cross_product() {
        let (v, w) = (DVec3::new(1.0, -2.0, 3.0), DVec3::new(0.5, 4.0, -1.0));
        assert!((cross_matrix(v) * w).abs_diff_eq(v.cross(w), 1e-15));
    }

    #[test]
    fn sigmas_of_fully_correlated_parts_add_up() {
        // Given one-axis parts that move together, then the bound is reached exactly.
        let bound = bound_of_sum(&isotropic(2.0), &isotropic(3.0), 0.5);
        assert!((bound.x_axis.x - (2.0_f64 + 0.5 * 3.0).powi(2)).abs() < 1e-12);
    }
}
