//! Measurements of up to three numbers at once: gate by their joint innovation, update one by one.

use glam::{DMat3, DVec3};

use super::{HEADING, UNKNOWN_HEADING, dot};
use crate::covariance::{Row, STATES};
use crate::state::State;

/// Square of the innovation, by its variance, that one in a thousand exceeds, for one, two and three
/// numbers (chi-square).
pub(crate) const GATE: [f64; 3] = [10.83, 13.82, 16.27];

/// Numbers measured together whose errors are independent and of unit variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Whitened<const N: usize> {
    rows: [Row; N],
    residual: [f64; N],
}

impl<const N: usize> Whitened<N> {
    /// Numbers with independent errors of given standard deviations.
    pub(crate) fn independent(rows: [Row; N], residual: [f64; N], sigma: [f64; N]) -> Self {
        Self {
            rows: core::array::from_fn(|k| rows[k].map(|x| x / sigma[k])),
            residual: core::array::from_fn(|k| residual[k] / sigma[k]),
        }
    }

    /// Square of the innovation by its covariance; 1 on average per number if the filter is honest.
    pub(crate) fn nis(&self, state: &State) -> f64 {
        // With S = L Lᵀ, rᵀ S⁻¹ r = |L⁻¹ r|², forward substitution on the way.
        let mut factor = [[0.0; N]; N];
        let mut solved = [0.0; N];
        for i in 0..N {
            let ph = state.covariance.times(&self.rows[i]);
            for j in 0..=i {
                let inner: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
                let own = dot(&self.rows[j], &ph) + f64::from(i == j) - inner;
                factor[i][j] = if i == j {
                    libm::sqrt(own.max(f64::MIN_POSITIVE))
                } else {
                    own / factor[j][j]
                };
            }
            let known: f64 = (0..i).map(|k| factor[i][k] * solved[k]).sum();
            solved[i] = (self.residual[i] - known) / factor[i][i];
        }
        solved.iter().map(|x| x * x).sum()
    }

    /// Corrects the state, with the variances of all numbers multiplied by a factor.
    ///
    /// An unknown heading is spared as in [`super::apply_blind`].
    pub(crate) fn apply(&self, state: &mut State, weakened: f64) {
        let mut correction = [0.0; STATES];
        for (row, residual) in self.rows.iter().zip(&self.residual) {
            let ph = state.covariance.times(row);
            let variance = dot(row, &ph) + weakened;
            let mut gain = ph.map(|x| x / variance);
            let left = residual - dot(row, &correction);
            if state.covariance.variance(HEADING) < UNKNOWN_HEADING {
                state.learn(row, &ph, variance);
            } else {
                gain[HEADING] = 0.0;
                state.learn_by(row, &ph, &gain, variance);
            }
            for (sum, k) in correction.iter_mut().zip(&gain) {
                *sum += k * left;
            }
        }
        state.correct(&correction);
    }
}

impl Whitened<3> {
    /// A vector with a covariance; `None` if that is no covariance.
    pub(crate) fn correlated(rows: &[Row; 3], residual: DVec3, covariance: DMat3) -> Option<Self> {
        let whiten = inverse_root(covariance)?;
        let row = |k: usize| {
            let weights = whiten.row(k);
            core::array::from_fn(|i| {
                weights.x * rows[0][i] + weights.y * rows[1][i] + weights.z * rows[2][i]
            })
        };
        let residual = whiten * residual;
        Some(Self { rows: [row(0), row(1), row(2)], residual: residual.to_array() })
    }
}

/// `L⁻¹` of a covariance `C = L Lᵀ`; `None` unless it is symmetric, finite and positive.
pub(crate) fn inverse_root(c: DMat3) -> Option<DMat3> {
    let skewed = c - c.transpose();
    let scale = c.x_axis.x.max(c.y_axis.y).max(c.z_axis.z);
    let symmetric = skewed.to_cols_array().iter().all(|x| x.abs() <= 1e-9 * scale);
    let root = |x: f64| (x > 1e-12 * scale).then(|| libm::sqrt(x));
    let a = root(c.x_axis.x)?;
    let (b, d) = (c.x_axis.y / a, c.x_axis.z / a);
    let e = root(c.y_axis.y - b * b)?;
    let f = (c.y_axis.z - b * d) / e;
    let g = root(c.z_axis.z - d * d - f * f)?;
    let inverse = DMat3::from_cols(
        DVec3::new(1.0 / a, -b / (a * e), (b * f - d * e) / (a * e * g)),
        DVec3::new(0.0, 1.0 / e, -f / (e * g)),
        DVec3::new(0.0, 0.0, 1.0 / g),
    );
    (symmetric && c.is_finite() && inverse.is_finite()).then_some(inverse)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::covariance::{POSITION, VELOCITY};
    use crate::testing::{Normal, attitudes, state_at, unit};

    const COVARIANCE: DMat3 =
        DMat3::from_cols_array(&[4.0, 1.0, -0.5, 1.0, 2.0, 0.3, -0.5, 0.3, 1.0]);

    #[test]
    fn the_inverse_root_whitens() {
        let whiten = inverse_root(COVARIANCE).unwrap();
        let white = whiten * COVARIANCE * whiten.transpose();
        assert!(white.abs_diff_eq(DMat3::IDENTITY, 1e-12), "{white}");
    }

    #[test]
    fn what_is_no_covariance_is_refused() {
        let mut lopsided = COVARIANCE;
        lopsided.x_axis.y = 0.5;
        let negative = DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0));
        let flat = DMat3::from_diagonal(DVec3::new(1.0, 0.0, 1.0));
        let endless = DMat3::from_diagonal(DVec3::new(1.0, f64::INFINITY, 1.0));
        for matrix in [lopsided, negative, flat, endless, DMat3::ZERO, DMat3::NAN] {
            assert_eq!(inverse_root(matrix), None, "{matrix}");
        }
    }

    /// A state whose position is correlated with its velocity.
    fn correlated() -> State {
        let mut state = state_at(attitudes()[0], &mut Normal::seeded(3));
        state.covariance.set_independent(VELOCITY, DMat3::IDENTITY * 0.5);
        state.covariance.set_independent(POSITION, DMat3::IDENTITY * 2.0);
        state.covariance.shear_scalar(POSITION, 0.7, VELOCITY);
        state
    }

    fn rows() -> [Row; 3] {
        core::array::from_fn(|k| unit(POSITION.0 + k, 1.0))
    }

    #[test]
    fn one_by_one_is_as_good_as_all_at_once() {
        let residual = DVec3::new(0.3, -0.8, 0.5);
        let before = correlated();
        let prior = before.covariance.block(POSITION, POSITION);
        let gain = prior * (prior + COVARIANCE).inverse();
        let measured = Whitened::correlated(&rows(), residual, COVARIANCE).unwrap();
        let joint = residual.dot((prior + COVARIANCE).inverse() * residual);
        assert!((measured.nis(&before) - joint).abs() < 1e-9);

        let mut after = before;
        measured.apply(&mut after, 1.0);
        assert!((after.position - before.position - gain * residual).length() < 1e-9);
        let posterior = after.covariance.block(POSITION, POSITION);
        let expected = prior - gain * prior;
        assert!(posterior.abs_diff_eq(expected, 1e-9), "{posterior} {expected}");
    }
}
