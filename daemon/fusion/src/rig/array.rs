//! Field and gradient out of one reading of each magnetometer, by least squares.
//!
//! Eight unknowns under Maxwell's constraints: `B` (3) and `G`, symmetric and traceless (5), at the
//! filter point; three readings from a triangle give nine equations. A set whose geometry does not tell
//! them apart (two, or in a line) gives nothing.

use glam::{DMat3, DVec3};

use super::harmonic::{GRADIENT, GRADIENTS, basis, gradient};

/// Unknowns.
const UNKNOWNS: usize = GRADIENT + GRADIENTS;

/// The field around the filter point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldFit {
    /// µT.
    pub field_ut: DVec3,
    /// µT/m.
    pub gradient_ut_m: DMat3,
    /// 1σ of the gradient's error (Frobenius norm) for each µT of a reading's noise, 1/m.
    pub gradient_noise_per_m: f64,
    weights: [f64; UNKNOWNS],
}

/// Least pivot of the normal equations, m² for the gradient's part, that counts as told.
const LEAST_PIVOT: f64 = 1e-3;

impl FieldFit {
    /// Fits readings, µT, at places from the filter point, m; nothing if they do not tell.
    pub fn of(readings: impl Iterator<Item = (DVec3, DVec3)>) -> Option<Self> {
        let mut normal = [[0.0; UNKNOWNS]; UNKNOWNS];
        let mut right = [0.0; UNKNOWNS];
        for (place, seen) in readings {
            for (row, seen) in basis(place).iter().zip(seen.to_array()) {
                for i in 0..UNKNOWNS {
                    right[i] += row[i] * seen;
                    for j in 0..UNKNOWNS {
                        normal[i][j] += row[i] * row[j];
                    }
                }
            }
        }
        let factor = cholesky(&normal)?;
        let weights = solve(&factor, &right);
        let mut variance = 0.0;
        for k in GRADIENT..UNKNOWNS {
            let mut unit = [0.0; UNKNOWNS];
            unit[k] = 1.0;
            variance += solve(&factor, &unit)[k];
        }
        Some(Self {
            field_ut: DVec3::new(weights[0], weights[1], weights[2]),
            gradient_ut_m: gradient(&weights[GRADIENT..]),
            gradient_noise_per_m: libm::sqrt(variance),
            weights,
        })
    }

    /// The field at a place from the filter point, µT.
    pub fn at(&self, place: DVec3) -> DVec3 {
        let value = |row: &[f64]| row.iter().zip(&self.weights).map(|(a, b)| a * b).sum();
        DVec3::from_array(basis(place).map(|row| value(&row[..UNKNOWNS])))
    }
}

type Matrix = [[f64; UNKNOWNS]; UNKNOWNS];

/// The lower factor; nothing if a pivot is too small.
fn cholesky(m: &Matrix) -> Option<Matrix> {
    let mut l = [[0.0; UNKNOWNS]; UNKNOWNS];
    for j in 0..UNKNOWNS {
        let square = m[j][j] - (0..j).map(|k| l[j][k] * l[j][k]).sum::<f64>();
        if square.is_nan() || square < LEAST_PIVOT {
            return None;
        }
        l[j][j] = libm::sqrt(square);
        for i in j + 1..UNKNOWNS {
            let known: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            l[i][j] = (m[i][j] - known) / l[j][j];
        }
    }
    Some(l)
}

fn solve(l: &Matrix, right: &[f64; UNKNOWNS]) -> [f64; UNKNOWNS] {
    let mut x = *right;
    for i in 0..UNKNOWNS {
        let known: f64 = (0..i).map(|k| l[i][k] * x[k]).sum();
        x[i] = (x[i] - known) / l[i][i];
    }
    for i in (0..UNKNOWNS).rev() {
        let known: f64 = (i + 1..UNKNOWNS).map(|k| l[k][i] * x[k]).sum();
        x[i] = (x[i] - known) / l[i][i];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Normal;

    fn dipole(r: DVec3) -> DVec3 {
        let (place, moment) = (DVec3::new(6.0, -8.0, 4.0), DVec3::new(48e3, -16e3, 64e3));
        let d = r - place;
        let n = d.normalize();
        DVec3::new(0.0, 21.0, -43.0)
            + (n * (3.0 * moment.dot(n)) - moment) * (0.1 / d.length().powi(3))
    }

    fn triangle() -> [DVec3; 3] {
        [0.0, 2.094, 4.189].map(|a: f64| DVec3::new(a.cos(), a.sin(), 0.0) * 0.29)
    }

    #[test]
    fn three_magnetometers_see_a_dipoles_gradient() {
        // Given a dipole eleven metres away, when three read it, then field and gradient at their centre
        // are those of the closed form, to what its curvature leaves.
        let fit = FieldFit::of(triangle().into_iter().map(|r| (r, dipole(r)))).unwrap();
        assert!((fit.field_ut - dipole(DVec3::ZERO)).length() < 0.1);
        for (axis, unit) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
            let exact = (dipole(unit * 1e-4) - dipole(unit * -1e-4)) / 2e-4;
            let off = (fit.gradient_ut_m.col(axis) - exact).length();
            assert!(off < 0.1 * exact.length().max(2.0), "axis {axis}: {off} of {exact}");
        }
    }

    #[test]
    fn the_gradients_noise_is_as_predicted() {
        let mut random = Normal::seeded(5);
        let (mut square, runs, sigma) = (0.0, 2000.0, 0.5);
        let quiet = FieldFit::of(triangle().into_iter().map(|r| (r, DVec3::Z))).unwrap();
        for _ in 0..2000 {
            let noisy = triangle().map(|r| (r, DVec3::Z + random.vector(sigma)));
            let fit = FieldFit::of(noisy.into_iter()).unwrap();
            let off = fit.weights[GRADIENT..].iter().map(|g| g * g).sum::<f64>();
            square += off / runs;
        }
        let ratio = square.sqrt() / (sigma * quiet.gradient_noise_per_m);
        assert!((0.9..1.1).contains(&ratio), "{ratio}");
    }

    #[test]
    fn two_or_three_in_a_line_tell_no_gradient() {
        let line = [-0.3, 0.0, 0.3].map(|x| (DVec3::X * x, DVec3::Z));
        assert_eq!(FieldFit::of(line.into_iter()), None);
        assert_eq!(FieldFit::of(line.into_iter().take(2)), None);
        assert_eq!(FieldFit::of(core::iter::empty()), None);
    }
}
