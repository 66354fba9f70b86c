//! The covariance of the error state, propagated by shears and updated one scalar at a time.

use glam::{DMat3, DVec3};

#[cfg(test)]
mod symmetry;

/// Number of error states.
pub const STATES: usize = 23;

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
/// Index of the error of the magnetometer's delay, s.
pub const MAG_DELAY: usize = 19;
/// Index of the first of two errors of a camera's mounting on its vehicle, rad: a small rotation of
/// the vehicle's axes about their y (pitch), and next to it about their z (yaw).
pub const MOUNTING: usize = 20;
/// Index of the error of the speed's scale factor, a part of one.
pub const SPEED_SCALE: usize = 22;

/// A symmetric positive semi-definite matrix over the error states; units are those of the states.
///
/// Both halves are stored, so that rows can be read whole; every operation leaves them equal, but for
/// the sign of a zero.
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

    /// The covariance of a block with one error state.
    pub fn with_state(&self, block: Block, index: usize) -> DVec3 {
        let at = |k: usize| self.rows[block.0 + k][index];
        DVec3::new(at(0), at(1), at(2))
    }

    /// The variance of one error state.
    pub fn variance(&self, index: usize) -> f64 {
        self.rows[index][index]
    }

    /// The covariance of two single error states.
    pub fn covariance(&self, i: usize, j: usize) -> f64 {
        self.rows[i][j]
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

    /// Makes one error what `row · error + noise = 0` demands, where `row[index]` is 1; `noise` is a
    /// variance.
    pub(crate) fn tie(&mut self, index: usize, row: &Row, noise: f64) {
        self.forget(index, 0.0);
        let by_others = self.times(row);
        let variance: f64 = row.iter().zip(&by_others).map(|(a, b)| a * b).sum();
        for (k, by_other) in by_others.iter().enumerate() {
            self.set(index, k, -by_other);
        }
        self.set(index, index, variance + noise);
    }

    /// The error model `x ← m x` for one block.
    pub fn rotate(&mut self, block: Block, m: DMat3) {
        let rows = [self.rows[block.0], self.rows[block.0 + 1], self.rows[block.0 + 2]];
        for r in 0..3 {
            let (a, b, c) = (m.x_axis[r], m.y_axis[r], m.z_axis[r]);
            self.rows[block.0 + r] =
                core::array::from_fn(|k| a * rows[0][k] + b * rows[1][k] + c * rows[2][k]);
        }
        let own = self.block(block, block) * m.transpose();
        let own = (own + own.transpose()) * 0.5;
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
    #[inline]
    pub fn shear(&mut self, i: Block, m: DMat3, j: Block) {
        self.shear_alike([i], [(m, j)]);
    }

    /// The error model `x_i += s x_j` with a scalar.
    #[inline]
    pub fn shear_scalar(&mut self, i: Block, s: f64, j: Block) {
        let gained = core::array::from_fn(|r| self.rows[j.0 + r].map(|x| s * x));
        self.shear_by([i], &gained, part(&gained, j) * s);
    }

    /// The error model `x_i += Σ m x_j` for several blocks `i` that gain the same from the sources
    /// `j`; no block is both.
    ///
    /// With `F = I + E`, whose sources do not change, `P ← P + E P + (E P)ᵀ + E P Eᵀ`; the rows of
    /// `E P` are worked out once for all blocks `i`.
    #[inline]
    pub fn shear_alike<const I: usize, const J: usize>(
        &mut self,
        targets: [Block; I],
        sources: [(DMat3, Block); J],
    ) {
        let mut gained = [[0.0; STATES]; 3];
        for (m, j) in sources {
            let [x, y, z] = [&self.rows[j.0], &self.rows[j.0 + 1], &self.rows[j.0 + 2]];
            for (r, row) in gained.iter_mut().enumerate() {
                let (a, b, c) = (m.x_axis[r], m.y_axis[r], m.z_axis[r]);
                for k in 0..STATES {
                    row[k] += a * x[k] + b * y[k] + c * z[k];
                }
            }
        }
        let mut both = DMat3::ZERO;
        for (m, j) in sources {
            both += part(&gained, j) * m.transpose();
        }
        self.shear_by(targets, &gained, both);
    }

    /// Adds `gained` = rows of `E P`, its transpose, and `both` = block of `E P Eᵀ`.
    #[inline]
    fn shear_by<const I: usize>(&mut self, targets: [Block; I], gained: &[Row; 3], both: DMat3) {
        for i in targets {
            for (r, gain) in gained.iter().enumerate() {
                let row = &mut self.rows[i.0 + r];
                for k in 0..STATES {
                    row[k] += gain[k];
                }
                for j in targets {
                    for c in 0..3 {
                        row[j.0 + c] += gained[c][i.0 + r] + both.col(c)[r];
                    }
                }
            }
        }
        for i in targets {
            self.mirror(i.0, 3);
        }
    }

    /// The error model `x ← s x` for `count` states from `first`.
    pub fn scale(&mut self, first: usize, count: usize, s: f64) {
        for i in first..first + count {
            for value in &mut self.rows[i] {
                *value *= s;
            }
            self.rows[i][i] *= s;
            self.mirror(i, 1);
        }
    }

    /// Copies rows into the columns of the same indices. Afterwards the two agree.
    #[inline]
    fn mirror(&mut self, first: usize, count: usize) {
        for i in first..first + count {
            for k in 0..STATES {
                self.rows[k][i] = self.rows[i][k];
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
    /// gain; [`Covariance::restore`] lifts what rounding may push below zero.
    pub fn deflate(&mut self, ph: &Row, s: f64) {
        // A factor that both sides share keeps the product symmetric.
        let scale = libm::sqrt(s).recip();
        self.add_square(-1.0, &ph.map(|x| x * scale));
    }

    /// The Joseph form for any gain: `P ← (I − k hᵀ) P (I − k hᵀ)ᵀ + k r kᵀ`, given `ph = P h`,
    /// `s = hᵀ P h + r`.
    ///
    /// That is the update with the optimal gain `P h / s`, and what this one leaves unlearnt given back:
    /// `P − (P h)(P h)ᵀ / s + s e eᵀ` with `e = P h / s − k`, which is zero where the gain is optimal.
    pub fn update_with_gain(&mut self, ph: &Row, gain: &Row, s: f64) {
        self.deflate(ph, s);
        let root = libm::sqrt(s);
        self.add_square(1.0, &core::array::from_fn(|k| (ph[k] / s - gain[k]) * root));
    }

    /// [`Covariance::update_with_gain`] for a gain that teaches few states: only their rows and columns
    /// change.
    pub fn update_few(&mut self, ph: &Row, gain: &Row, s: f64) {
        // With w = P h − ½ s k it is P − k wᵀ − w kᵀ.
        let w: Row = core::array::from_fn(|k| ph[k] - 0.5 * s * gain[k]);
        let is_taught = |i: &usize| gain[*i] != 0.0;
        for i in (0..STATES).filter(is_taught) {
            for k in 0..STATES {
                self.rows[i][k] -= gain[i] * w[k] + w[i] * gain[k];
            }
        }
        for i in (0..STATES).filter(is_taught) {
            self.mirror(i, 1);
        }
    }

    /// `P ← P ± v vᵀ`; states that have no part in `v` cost nothing.
    pub(crate) fn add_square(&mut self, sign: f64, v: &Row) {
        for (row, weight) in self.rows.iter_mut().zip(v) {
            if *weight != 0.0 {
                let weight = sign * weight;
                for k in 0..STATES {
                    row[k] += weight * v[k];
                }
            }
        }
    }

    /// Keeps every variance at least at a tiny floor.
    ///
    /// Symmetry needs no care: every operation writes both halves alike.
    pub fn restore(&mut self) {
        const FLOOR: f64 = 1e-18;
        for i in 0..STATES {
            self.rows[i][i] = self.rows[i][i].max(FLOOR);
        }
    }

    /// Whether every entry is finite.
    pub fn is_finite(&self) -> bool {
        // NaN and infinity survive every sum; eight sums run side by side. Entries near 1e308 could
        // overflow one, and deserve no more trust.
        let (eights, rest) = self.rows.as_flattened().as_chunks::<8>();
        let mut sums = [0.0; 8];
        for eight in eights {
            for k in 0..8 {
                sums[k] += eight[k];
            }
        }
        sums.iter().chain(rest).all(|sum| sum.is_finite())
    }
}

/// The columns of a block out of three rows.
fn part(rows: &[Row; 3], block: Block) -> DMat3 {
    let column = |c: usize| DVec3::from_array(rows.map(|row| row[block.0 + c]));
    DMat3::from_cols(column(0), column(1), column(2))
}

#[cfg(test)]
mod tests;
