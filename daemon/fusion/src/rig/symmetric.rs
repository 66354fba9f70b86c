//! Eigenvalues and eigenvectors of a symmetric 3 × 3 matrix, by cyclic Jacobi rotations (Golub and
//! Van Loan, Matrix Computations, ch. 8.5): no square root of a difference, no lost digits.

use glam::{DMat3, DVec3};

/// The decomposition `m = V diag(values) Vᵀ`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Eigen {
    /// In descending order.
    pub(crate) values: DVec3,
    /// Unit vectors, one per column, in that order.
    pub(crate) vectors: DMat3,
}

/// Sweeps; convergence is quadratic, six reach the last bit.
const SWEEPS: usize = 8;

/// Decomposes a symmetric matrix; of an unsymmetric one, the lower half counts.
pub(crate) fn eigen(matrix: DMat3) -> Eigen {
    let mut a = [[0.0; 3]; 3];
    for (r, row) in a.iter_mut().enumerate() {
        for (c, value) in row.iter_mut().enumerate() {
            *value = if c <= r { matrix.col(c)[r] } else { matrix.col(r)[c] };
        }
    }
    let mut v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            rotate(&mut a, &mut v, p, q);
        }
    }
    sorted(&a, &v)
}

/// One rotation that makes `a[p][q]` zero.
fn rotate(a: &mut [[f64; 3]; 3], v: &mut [[f64; 3]; 3], p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let sign = if theta < 0.0 { -1.0 } else { 1.0 };
    let t = sign / (theta.abs() + libm::sqrt(theta * theta + 1.0));
    let c = libm::sqrt(t * t + 1.0).recip();
    let s = t * c;
    for row in a.iter_mut() {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
    let (above, below) = (a[p], a[q]);
    a[p] = core::array::from_fn(|k| c * above[k] - s * below[k]);
    a[q] = core::array::from_fn(|k| s * above[k] + c * below[k]);
    for row in v.iter_mut() {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
}

fn sorted(a: &[[f64; 3]; 3], v: &[[f64; 3]; 3]) -> Eigen {
    let mut order = [0, 1, 2];
    order.sort_unstable_by(|&i, &j| a[j][j].total_cmp(&a[i][i]));
    let column = |k: usize| DVec3::new(v[0][k], v[1][k], v[2][k]);
    Eigen {
        values: DVec3::from_array(order.map(|k| a[k][k])),
        vectors: DMat3::from_cols(column(order[0]), column(order[1]), column(order[2])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Normal;

    #[test]
    fn the_parts_make_the_whole_again() {
        let mut random = Normal::seeded(3);
        for _ in 0..200 {
            let m = DMat3::from_cols(random.vector(1.0), random.vector(1.0), random.vector(1.0));
            let m = m * m.transpose();
            let Eigen { values, vectors } = eigen(m);
            let again = vectors * DMat3::from_diagonal(values) * vectors.transpose();
            assert!(again.abs_diff_eq(m, 1e-12), "{again} for {m}");
            assert!(values.x >= values.y && values.y >= values.z);
        }
    }

    #[test]
    fn a_diagonal_matrix_and_none_at_all_are_no_trouble() {
        assert_eq!(eigen(DMat3::ZERO).values, DVec3::ZERO);
        assert_eq!(
            eigen(DMat3::from_diagonal(DVec3::new(1.0, 3.0, 2.0))).values,
            DVec3::new(3.0, 2.0, 1.0)
        );
    }
}
