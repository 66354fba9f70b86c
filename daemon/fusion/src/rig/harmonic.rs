//! A magnetic field around a point, as a polynomial that obeys Maxwell's equations.
//!
//! Where no current flows the field is the gradient of a harmonic potential, so that a polynomial of
//! second order has 3 + 5 + 7 free numbers instead of 3 + 9 + 18 (Skog, Hendeby, Gustafsson, "Magnetic
//! odometry: a model-based approach using a sensor array", FUSION 2018):
//!
//! ```text
//! B(r) = b + G r + ½ T(r, r)      G symmetric, traceless;  T symmetric in all indices, traceless
//! ```

use glam::{DMat3, DVec3};

/// Free numbers of the polynomial.
pub(crate) const COEFFICIENTS: usize = 15;
/// Index of the first number of the gradient, and how many there are.
pub(crate) const GRADIENT: usize = 3;
pub(crate) const GRADIENTS: usize = 5;
/// Index of the first number of the curvature.
pub(crate) const CURVATURE: usize = 8;

/// The five independent entries of `G`: xx, xy, xz, yy, yz.
const G_INDEX: [(usize, usize); GRADIENTS] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2)];

/// Coefficients of the field, µT, µT/m, µT/m², or weights for them.
pub(crate) type Coefficients = [f64; COEFFICIENTS];

/// The gradient matrix `∂B/∂r` out of five numbers, µT/m.
pub(crate) fn gradient(g: &[f64]) -> DMat3 {
    let [xx, xy, xz, yy, yz] = [g[0], g[1], g[2], g[3], g[4]];
    DMat3::from_cols(
        DVec3::new(xx, xy, xz),
        DVec3::new(xy, yy, yz),
        DVec3::new(xz, yz, -xx - yy),
    )
}

/// `∂(G r)/∂g`: what each of the five numbers makes of a place, by component of the field.
pub(crate) fn gradient_basis(r: DVec3) -> [[f64; GRADIENTS]; 3] {
    [
        [r.x, r.y, r.z, 0.0, 0.0],
        [0.0, r.x, 0.0, r.y, r.z],
        [-r.z, 0.0, r.x, -r.z, r.y],
    ]
}

/// `T · r`, a matrix of gradient differences, out of the seven numbers of the curvature: xxx, xxy,
/// xxz, xyy, xyz, yyy, yyz.
pub(crate) fn curvature_times(t: &[f64], r: DVec3) -> DMat3 {
    let [xxx, xxy, xxz, xyy, xyz, yyy, yyz] = [t[0], t[1], t[2], t[3], t[4], t[5], t[6]];
    let (xzz, yzz, zzz) = (-xxx - xyy, -xxy - yyy, -xxz - yyz);
    let xx = xxx * r.x + xxy * r.y + xxz * r.z;
    let xy = xxy * r.x + xyy * r.y + xyz * r.z;
    let xz = xxz * r.x + xyz * r.y + xzz * r.z;
    let yy = xyy * r.x + yyy * r.y + yyz * r.z;
    let yz = xyz * r.x + yyz * r.y + yzz * r.z;
    let zz = xzz * r.x + yzz * r.y + zzz * r.z;
    DMat3::from_cols(DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz))
}

/// The field at a place, µT.
#[cfg(test)]
pub(crate) fn field(c: &Coefficients, r: DVec3) -> DVec3 {
    let by_curvature = curvature_times(&c[CURVATURE..], r) * r * 0.5;
    DVec3::new(c[0], c[1], c[2]) + gradient(&c[GRADIENT..CURVATURE]) * r + by_curvature
}

/// `∂B(r)/∂c`: one row of weights for each component of the field.
pub(crate) fn basis(r: DVec3) -> [Coefficients; 3] {
    let mut rows = [[0.0; COEFFICIENTS]; 3];
    let by_gradient = gradient_basis(r);
    for (k, row) in rows.iter_mut().enumerate() {
        row[k] = 1.0;
        row[GRADIENT..CURVATURE].copy_from_slice(&by_gradient[k]);
    }
    for n in 0..COEFFICIENTS - CURVATURE {
        let column = curvature_times(&unit_curvature(n), r) * r * 0.5;
        for (k, row) in rows.iter_mut().enumerate() {
            row[CURVATURE + n] = column[k];
        }
    }
    rows
}

/// The matrix that moves the coefficients' point by a way: `c ← F(d) c`, exactly.
pub(crate) fn translation(d: DVec3) -> [Coefficients; COEFFICIENTS] {
    let mut f = [[0.0; COEFFICIENTS]; COEFFICIENTS];
    f[..3].copy_from_slice(&basis(d));
    for (k, row) in f.iter_mut().enumerate().skip(GRADIENT) {
        row[k] = 1.0;
    }
    for n in 0..COEFFICIENTS - CURVATURE {
        let added = curvature_times(&unit_curvature(n), d);
        for (k, (i, j)) in G_INDEX.into_iter().enumerate() {
            f[GRADIENT + k][CURVATURE + n] = added.col(j)[i];
        }
    }
    f
}

/// `∂(F(d) c)/∂d` at `d = 0` for the moved coefficients: the field changes by `G`, the gradient by `T`.
pub(crate) fn slope(c: &Coefficients) -> [[f64; 3]; CURVATURE] {
    let mut rows = [[0.0; 3]; CURVATURE];
    let g = gradient(&c[GRADIENT..CURVATURE]);
    for (axis, unit) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
        let by_field = g * unit;
        let by_gradient = curvature_times(&c[CURVATURE..], unit);
        for k in 0..3 {
            rows[k][axis] = by_field[k];
        }
        for (k, (i, j)) in G_INDEX.into_iter().enumerate() {
            rows[GRADIENT + k][axis] = by_gradient.col(j)[i];
        }
    }
    rows
}

fn unit_curvature(n: usize) -> [f64; COEFFICIENTS - CURVATURE] {
    let mut unit = [0.0; COEFFICIENTS - CURVATURE];
    unit[n] = 1.0;
    unit
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Normal;

    fn random_coefficients(random: &mut Normal) -> Coefficients {
        core::array::from_fn(|_| random.number())
    }

    fn product(rows: &[Coefficients], c: &Coefficients) -> std::vec::Vec<f64> {
        rows.iter().map(|row| row.iter().zip(c).map(|(a, b)| a * b).sum()).collect()
    }

    #[test]
    fn neither_sources_nor_currents() {
        let mut random = Normal::seeded(1);
        for _ in 0..50 {
            let (c, r) = (random_coefficients(&mut random), random.vector(1.0));
            let step = 1e-4;
            let by = |d: DVec3| (field(&c, r + d * step) - field(&c, r - d * step)) / (2.0 * step);
            let (x, y, z) = (by(DVec3::X), by(DVec3::Y), by(DVec3::Z));
            assert!((x.x + y.y + z.z).abs() < 1e-9);
            let curl = DVec3::new(y.z - z.y, z.x - x.z, x.y - y.x);
            assert!(curl.length() < 1e-9);
        }
    }

    #[test]
    fn the_basis_is_the_field_and_moving_the_point_leaves_it() {
        let mut random = Normal::seeded(2);
        for _ in 0..50 {
            let (c, r, d) =
                (random_coefficients(&mut random), random.vector(1.0), random.vector(1.0));
            let by_basis = DVec3::from_slice(&product(&basis(r), &c));
            assert!((by_basis - field(&c, r)).length() < 1e-12);
            let moved = product(&translation(d), &c).try_into().unwrap();
            assert!((field(&moved, r) - field(&c, r + d)).length() < 1e-12);
        }
    }

    #[test]
    fn the_slope_is_that_of_moving() {
        let mut random = Normal::seeded(3);
        for _ in 0..50 {
            let c = random_coefficients(&mut random);
            for (axis, unit) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
                let ahead = product(&translation(unit * 1e-6), &c);
                let behind = product(&translation(unit * -1e-6), &c);
                for (k, row) in slope(&c).iter().enumerate() {
                    let exact = (ahead[k] - behind[k]) / 2e-6;
                    assert!((row[axis] - exact).abs() < 1e-8, "row {k} axis {axis}");
                }
            }
        }
    }
}
