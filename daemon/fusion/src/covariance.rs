//! The covariance of the error state, propagated by shears and updated one scalar at a time.

use glam::{DMat3, DVec3};

/// Number of error states.
pub const STATES: usize = 19;

/// A row of a measurement Jacobian, or a gain: one number per error state.
pub type Row = [f64; STATES];

/// A block of three error states, by its first index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block(pub(crate) usize);

/// Orientation error, a small rotation about the world axes, rad: `R_true = Exp(δθ) R`.
pub const ORIENTATION: Block = Block(0);
/// Velocity error in the world, m/s.
pub const VELOCITY: Block = Block(3);
/// Position error in the world, m.
pub const POSITION: Block = Block(6);
/// Gyroscope bias error in the body, rad/s.
pub const GYRO_BIAS: Block = Block(9);
/// Accelerometer bias error in the body, m/s².
pub const ACCEL_BIAS: Block = Block(12);
/// Leaky-velocity error in the world, m/s.
pub const LEAKY_VELOCITY: Block = Block(15);
/// Index of the compass deviation error, rad.
pub const DEVIATION: usize = 18;

/// A symmetric positive semi-definite matrix over the error states; units are those of the states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Covariance {
    rows: [Row; STATES],
}

impl Covariance {
    /// No uncertainty at all.
    pub const ZERO: Self = Self { rows: [[0.0; STATES]; STATES] };

    /// The covariance of one block with another.
    pub fn block(&self, i: Block, j: Block) -> DMat3 {
        let column = |c: usize| {
            DVec3::new(
                self.rows[i.0][j.0 + c],
                self.rows[i.0 + 1][j.0 + c],
                self.rows[i.0 + 2][j.0 + c],
            )
        };
        DMat3::from_cols(column(0), column(1), column(2))
    }

    /// The variance of one error state.
    pub fn variance(&self, index: usize) -> f64 {
        self.rows[index][index]
    }

    /// The variances of a block.
    pub fn variances(&self, block: Block) -> DVec3 {
        let at = |k: usize| self.variance(block.0 + k);
        DVec3::new(at(0), at(1), at(2))
    }

    /// Sets a block's own covariance and removes its correlation with everything else.
    pub fn set_independent(&mut self, block: Block, covariance: DMat3) {
        for r in 0..3 {
            for c in 0..STATES {
                self.rows[block.0 + r][c] = 0.0;
                self.rows[c][block.0 + r] = 0.0;
            }
        }
        for r in 0..3 {
            for c in 0..3 {
                self.rows[block.0 + r][block.0 + c] = covariance.col(c)[r];
            }
        }
    }

    /// Sets one state's variance and removes its correlation with everything else.
    pub fn forget(&mut self, index: usize, variance: f64) {
        for k in 0..STATES {
            self.set(index, k, 0.0);
        }
        self.set(index, index, variance);
    }

    /// The error model `x ← m x` for one block.
    pub fn rotate(&mut self, block: Block, m: DMat3) {
        let rows = [self.rows[block.0], self.rows[block.0 + 1], self.rows[block.0 + 2]];
        for r in 0..3 {
            for k in 0..STATES {
                self.rows[block.0 + r][k] =
                    m.x_axis[r] * rows[0][k] + m.y_axis[r] * rows[1][k] + m.z_axis[r] * rows[2][k];
            }
        }
        let own = self.block(block, block) * m.transpose();
        for r in 0..3 {
            for c in 0..3 {
                self.rows[block.0 + r][block.0 + c] = own.col(c)[r];
            }
        }
        self.mirror(block.0, 3);
    }

    /// Sets the covariance between two single states.
    pub fn set(&mut self, i: usize, j: usize, value: f64) {
        self.rows[i][j] = value;
        self.rows[j][i] = value;
    }

    /// Adds to the variances of a block.
    pub fn add_variances(&mut self, block: Block, variances: DVec3) {
        for k in 0..3 {
            self.rows[block.0 + k][block.0 + k] += variances[k];
        }
    }

    /// Adds to the variance of one state.
    pub fn add_variance(&mut self, index: usize, variance: f64) {
        self.rows[index][index] += variance;
    }

    /// The error model `x_i += m x_j`, for two different blocks: `P ← F P Fᵀ` with that shear.
    ///
    /// Rows first, then the block on the diagonal, then the columns by symmetry: half the work of
    /// the full product.
    pub fn shear(&mut self, i: Block, m: DMat3, j: Block) {
        let source = [self.rows[j.0], self.rows[j.0 + 1], self.rows[j.0 + 2]];
        for r in 0..3 {
            let (a, b, c) = (m.x_axis[r], m.y_axis[r], m.z_axis[r]);
            let row = &mut self.rows[i.0 + r];
            for k in 0..STATES {
                row[k] += a * source[0][k] + b * source[1][k] + c * source[2][k];
            }
        }
        let own = self.block(i, i) + self.block(i, j) * m.transpose();
        for r in 0..3 {
            for c in 0..3 {
                self.rows[i.0 + r][i.0 + c] = own.col(c)[r];
            }
        }
        self.mirror(i.0, 3);
    }

    /// The error model `x_i += s x_j` with a scalar.
    pub fn shear_scalar(&mut self, i: Block, s: f64, j: Block) {
        self.shear(i, DMat3::from_diagonal(DVec3::splat(s)), j);
    }

    /// The error model `x ← s x` for `count` states from `first`.
    pub fn scale(&mut self, first: usize, count: usize, s: f64) {
        for index in first..first + count {
            for k in 0..STATES {
                self.rows[index][k] *= s;
                self.rows[k][index] *= s;
            }
        }
    }

    fn mirror(&mut self, first: usize, count: usize) {
        for r in first..first + count {
            let row = self.rows[r];
            for (k, value) in row.iter().enumerate() {
                if !(first..first + count).contains(&k) {
                    self.rows[k][r] = *value;
                }
            }
        }
    }

    /// `P h` for a sparse row `h`.
    pub fn times(&self, h: &Row) -> Row {
        let mut product = [0.0; STATES];
        for (weight, row) in h.iter().zip(&self.rows) {
            if *weight != 0.0 {
                for k in 0..STATES {
                    product[k] += weight * row[k];
                }
            }
        }
        product
    }

    /// The Kalman update for one scalar measurement: `P ← P − (P h)(P h)ᵀ / s`.
    ///
    /// Takes `ph = P h` and the innovation variance `s`. Equal to the Joseph form for the optimal
    /// gain; [`Covariance::restore`] removes what rounding leaves.
    pub fn deflate(&mut self, ph: &Row, s: f64) {
        let inverse = s.recip();
        for (row, weight) in self.rows.iter_mut().zip(ph) {
            let factor = weight * inverse;
            for k in 0..STATES {
                row[k] -= factor * ph[k];
            }
        }
    }

    /// The Joseph form for any gain: `P ← (I − k hᵀ) P (I − k hᵀ)ᵀ + k r kᵀ`, given `ph = P h`,
    /// `s = hᵀ P h + r`.
    pub fn update_with_gain(&mut self, ph: &Row, gain: &Row, s: f64) {
        for i in 0..STATES {
            for k in 0..STATES {
                self.rows[i][k] += gain[i] * s * gain[k] - gain[i] * ph[k] - ph[i] * gain[k];
            }
        }
    }

    /// Makes the matrix exactly symmetric and keeps every variance at least at a tiny floor.
    pub fn restore(&mut self) {
        const FLOOR: f64 = 1e-18;
        for i in 0..STATES {
            for k in 0..i {
                let mean = 0.5 * (self.rows[i][k] + self.rows[k][i]);
                self.rows[i][k] = mean;
                self.rows[k][i] = mean;
            }
            self.rows[i][i] = self.rows[i][i].max(FLOOR);
        }
    }

    /// Whether every entry is finite.
    pub fn is_finite(&self) -> bool {
        self.rows.iter().flatten().all(|x| x.is_finite())
    }
}

#[cfg(test)]
mod tests;
