//! What the tests share: a seeded generator, attitudes worth trying, plain dense matrices.

use std::vec;
use std::vec::Vec;

use glam::{DQuat, DVec3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use crate::covariance::{Covariance, Row, STATES};
use crate::so3;
use crate::state::State;

/// A portable seeded generator of normal numbers.
pub(crate) struct Normal(ChaCha8Rng);

impl Normal {
    pub(crate) fn seeded(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    pub(crate) fn number(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    pub(crate) fn vector(&mut self, sigma: f64) -> DVec3 {
        DVec3::new(self.number(), self.number(), self.number()) * sigma
    }

    pub(crate) fn row(&mut self, sigma: f64) -> Row {
        core::array::from_fn(|_| sigma * self.number())
    }

    /// A whole number below `limit`, near enough to uniform for choosing.
    pub(crate) fn below(&mut self, limit: usize) -> usize {
        (self.number().abs() * 1e6) as usize % limit
    }
}

/// Identity, tiny, half turns, gimbal lock, upside down, and random attitudes.
pub(crate) fn attitudes() -> Vec<DQuat> {
    use core::f64::consts::{FRAC_PI_2, PI};
    let mut random = Normal::seeded(7);
    let vectors = [
        DVec3::ZERO,
        DVec3::new(1e-7, -2e-7, 3e-7),
        DVec3::X * PI,
        DVec3::Y * PI,
        DVec3::Z * PI,
        DVec3::new(1.0, 1.0, 1.0).normalize() * PI,
        DVec3::Y * FRAC_PI_2,
        DVec3::Y * -FRAC_PI_2,
        DVec3::X * (PI - 1e-3),
    ];
    let mut all: Vec<DQuat> = vectors.into_iter().map(so3::exp).collect();
    all.extend((0..20).map(|_| so3::exp(random.vector(2.0))));
    all
}

/// A state with every part different from zero but the deviation, at an attitude.
pub(crate) fn state_at(orientation: DQuat, random: &mut Normal) -> State {
    State {
        orientation,
        velocity: random.vector(1.0),
        position: random.vector(1.0),
        gyro_bias: random.vector(0.005),
        accel_bias: random.vector(0.1),
        leaky_velocity: random.vector(0.5),
        deviation: 0.0,
        mag_delay_s: 0.0,
        mounting_rad: [0.02 * random.number(), 0.02 * random.number()],
        speed_scale: 0.01 * random.number(),
        ..State::at(orientation)
    }
}

/// The row with a value at one place.
pub(crate) fn unit(index: usize, value: f64) -> Row {
    let mut row = [0.0; STATES];
    row[index] = value;
    row
}

/// The state moved by an error.
pub(crate) fn moved(state: &State, error: &Row) -> State {
    let mut moved = *state;
    moved.correct(error);
    moved
}

/// A plain matrix over the error states, for references that are slow and obvious.
#[derive(Clone, Debug)]
pub(crate) struct Dense(Vec<Row>);

impl Dense {
    pub(crate) fn from_fn(at: impl Fn(usize, usize) -> f64) -> Self {
        let mut rows = vec![[0.0; STATES]; STATES];
        for (i, row) in rows.iter_mut().enumerate() {
            for (j, value) in row.iter_mut().enumerate() {
                *value = at(i, j);
            }
        }
        Self(rows)
    }

    pub(crate) fn identity() -> Self {
        Self::from_fn(|i, j| f64::from(i == j))
    }

    pub(crate) fn of(p: &Covariance) -> Self {
        let columns: Vec<Row> = (0..STATES).map(|j| p.times(&unit(j, 1.0))).collect();
        // `times` forms sums of rows, so this reads row j.
        Self::from_fn(|i, j| columns[i][j])
    }

    pub(crate) fn outer(a: &Row, b: &Row) -> Self {
        Self::from_fn(|i, j| a[i] * b[j])
    }

    pub(crate) fn at(&self, i: usize, j: usize) -> f64 {
        self.0[i][j]
    }

    pub(crate) fn set(&mut self, i: usize, j: usize, value: f64) {
        self.0[i][j] = value;
    }

    pub(crate) fn plus(&self, other: &Self, factor: f64) -> Self {
        Self::from_fn(|i, j| self.at(i, j) + factor * other.at(i, j))
    }

    pub(crate) fn times(&self, other: &Self) -> Self {
        Self::from_fn(|i, j| (0..STATES).map(|k| self.at(i, k) * other.at(k, j)).sum())
    }

    pub(crate) fn transposed(&self) -> Self {
        Self::from_fn(|i, j| self.at(j, i))
    }

    /// `F self Fᵀ`.
    pub(crate) fn mapped(&self, f: &Self) -> Self {
        f.times(self).times(&f.transposed())
    }

    pub(crate) fn largest(&self) -> f64 {
        self.0.iter().flatten().fold(0.0, |most, x| x.abs().max(most))
    }

    /// The largest difference of two entries, relative to the largest entry.
    pub(crate) fn relative_difference(&self, other: &Self) -> f64 {
        self.plus(other, -1.0).largest() / other.largest().max(f64::MIN_POSITIVE)
    }

    pub(crate) fn is_symmetric(&self) -> bool {
        (0..STATES).all(|i| (0..i).all(|j| self.at(i, j).to_bits() == self.at(j, i).to_bits()))
    }

    /// Whether the matrix of correlations, raised by `jitter` on the diagonal, has a Cholesky
    /// factor; so the units of the states do not matter.
    pub(crate) fn is_positive_semidefinite(&self, jitter: f64) -> bool {
        let scale = |i: usize| self.at(i, i).max(1e-30).sqrt();
        let mut factor = Self::from_fn(|i, j| {
            self.at(i, j) / (scale(i) * scale(j)) + jitter * f64::from(i == j)
        });
        for j in 0..STATES {
            let square = factor.at(j, j) - (0..j).map(|k| factor.at(j, k).powi(2)).sum::<f64>();
            if square.is_nan() || square <= 0.0 {
                return false;
            }
            let pivot = square.sqrt();
            factor.set(j, j, pivot);
            for i in j + 1..STATES {
                let known: f64 = (0..j).map(|k| factor.at(i, k) * factor.at(j, k)).sum();
                factor.set(i, j, (factor.at(i, j) - known) / pivot);
            }
        }
        true
    }
}
