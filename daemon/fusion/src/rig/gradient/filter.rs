//! The field around the rig and the velocity that carries the rig through it: a small filter beside
//! the pose's.
//!
//! States: velocity `v`, the field's polynomial `c` around the filter point, and each magnetometer's
//! residual bias. All vectors stand in axes that the gyroscopes alone carry (`N`), so that no correction
//! of the heading turns the field. Prediction moves the polynomial with the rig (MAINS: Huang, Hendeby,
//! Fourati, Prieur, Skog 2023, there in body axes):
//!
//! ```text
//! c ← F(d) c,  d = v dt + ½ Δv dt        ∂b/∂v = G dt,  ∂G/∂v = T dt        v ← v + Δv
//! ```
//!
//! A magnetometer at `l` reads `Rᵀ B(R l) + bias`. That is `Ḃ = −ω × B + (Rᵀ G R) v` (the paper's
//! `MagneticFieldV1` with its sign set right), with nothing differentiated.

use glam::{DMat3, DVec3};

use super::super::geometry::MAX_MEMBERS;
use super::super::harmonic::{
    self, COEFFICIENTS, Coefficients, DEGREE, GRADIENT, GRADIENTS, MOVING, degree, slope,
    translation,
};
use super::GradientParameters;

/// Index of the velocity, of the polynomial, of the first bias.
const VELOCITY: usize = 0;
const FIELD: usize = 3;
const BIAS: usize = FIELD + COEFFICIENTS;
/// States of the largest rig.
const STATES: usize = BIAS + 3 * MAX_MEMBERS;

type Row = [f64; STATES];

/// One span of time as the rig went through it, in `N`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moved {
    /// s.
    pub(crate) span_s: f64,
    /// Gain of velocity, m/s.
    pub(crate) gain: DVec3,
    /// Way beyond that of the velocity at the span's begin, m.
    pub(crate) way: DVec3,
    /// Angle turned through, rad.
    pub(crate) turn_rad: f64,
}

/// Estimate and covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FieldFilter {
    /// States in use.
    used: usize,
    x: Row,
    p: [Row; STATES],
}

/// A velocity that is not known, 1σ, m/s.
const UNKNOWN_SPEED_M_S: f64 = 3.0;
/// What is known of each coefficient before the first reading, 1σ, µT, µT/m, µT/m² and so on.
const UNKNOWN_FIELD: f64 = 100.0;

impl FieldFilter {
    /// A filter for so many magnetometers that knows neither field nor velocity.
    pub(crate) fn new(members: usize, p: &GradientParameters) -> Self {
        let used = BIAS + 3 * members;
        let mut filter = Self { used, x: [0.0; STATES], p: [[0.0; STATES]; STATES] };
        let square = |x: f64| x * x;
        for k in 0..used {
            filter.p[k][k] = match k {
                0..FIELD => square(UNKNOWN_SPEED_M_S),
                FIELD..BIAS => square(UNKNOWN_FIELD),
                _ => square(p.residual_bias_ut),
            };
        }
        filter
    }

    /// Velocity, m/s in `N`.
    pub(crate) fn velocity(&self) -> DVec3 {
        self.vector(VELOCITY)
    }

    /// Covariance of the velocity, (m/s)².
    pub(crate) fn velocity_covariance(&self) -> DMat3 {
        let column = |c: usize| DVec3::new(self.p[0][c], self.p[1][c], self.p[2][c]);
        DMat3::from_cols(column(0), column(1), column(2))
    }

    /// Field at the filter point, µT in `N`.
    pub(crate) fn field(&self) -> DVec3 {
        self.vector(FIELD)
    }

    /// Gradient, µT/m in `N`.
    pub(crate) fn gradient(&self) -> DMat3 {
        harmonic::gradient(&self.x[FIELD + GRADIENT..FIELD + GRADIENT + GRADIENTS])
    }

    /// Expected square of the gradient's error, `E[δG δG]`, (µT/m)².
    pub(crate) fn gradient_error_square(&self) -> DMat3 {
        let mut sum = DMat3::ZERO;
        for m in 0..GRADIENTS {
            for n in 0..GRADIENTS {
                let weight = self.p[FIELD + GRADIENT + m][FIELD + GRADIENT + n];
                sum += unit_gradient(m) * unit_gradient(n) * weight;
            }
        }
        sum
    }

    /// A magnetometer's residual bias in the rig's axes, µT, and its variances.
    pub(crate) fn bias(&self, member: usize) -> (DVec3, DVec3) {
        let at = BIAS + 3 * member;
        let variances = DVec3::new(self.p[at][at], self.p[at + 1][at + 1], self.p[at + 2][at + 2]);
        (self.vector(at), variances)
    }

    /// Begins anew with a velocity, m/s in `N`, and its covariance, (m/s)²; what the field knew of the
    /// velocity is forgotten.
    pub(crate) fn restart_velocity(&mut self, velocity: DVec3, covariance: DMat3) {
        for k in 0..3 {
            for j in 0..self.used {
                self.p[k][j] = 0.0;
                self.p[j][k] = 0.0;
            }
            self.x[k] = velocity[k];
        }
        for k in 0..3 {
            for j in 0..3 {
                self.p[k][j] = covariance.col(j)[k];
            }
        }
    }

    /// Forgets the field, after a stretch unseen.
    pub(crate) fn forget_field(&mut self) {
        for k in FIELD..BIAS {
            for j in 0..self.used {
                self.p[k][j] = 0.0;
                self.p[j][k] = 0.0;
            }
            self.p[k][k] = UNKNOWN_FIELD * UNKNOWN_FIELD;
            self.x[k] = 0.0;
        }
    }

    /// Moves the rig on; `roughness_ut_m2` is how far the curvature walks in a metre.
    pub(crate) fn predict(&mut self, moved: &Moved, roughness_ut_m2: f64, p: &GradientParameters) {
        let way = self.velocity() * moved.span_s + moved.way;
        let f = translation(way);
        let before: Coefficients = core::array::from_fn(|k| self.x[FIELD + k]);
        for (k, row) in f.iter().enumerate() {
            self.x[FIELD + k] = row.iter().zip(&before).map(|(a, b)| a * b).sum();
        }
        let after: Coefficients = core::array::from_fn(|k| self.x[FIELD + k]);
        self.spread(&f, &slope(&after), moved.span_s);
        for k in 0..3 {
            self.x[k] += moved.gain[k];
        }
        self.add_noise(moved, libm::sqrt(way.length_squared()), roughness_ut_m2, p);
    }

    /// `P ← A P Aᵀ` for the rows that change: field and gradient, by field, gradient, curvature and
    /// velocity.
    fn spread(
        &mut self,
        f: &[Coefficients; COEFFICIENTS],
        slope: &[[f64; 3]; MOVING],
        span_s: f64,
    ) {
        let mut weights = [[0.0; BIAS]; MOVING];
        for (k, row) in weights.iter_mut().enumerate() {
            for axis in 0..3 {
                row[axis] = slope[k][axis] * span_s;
            }
            row[FIELD..].copy_from_slice(&f[k]);
        }
        let mut rows = [[0.0; STATES]; MOVING];
        for (row, weights) in rows.iter_mut().zip(&weights) {
            for (weight, from) in weights.iter().zip(&self.p).filter(|(w, _)| **w != 0.0) {
                for j in 0..self.used {
                    row[j] += weight * from[j];
                }
            }
        }
        self.p[FIELD..FIELD + MOVING].copy_from_slice(&rows);
        for j in 0..self.used {
            // The changed rows are still to be multiplied from the right, the others mirrored.
            let row: [f64; BIAS] = core::array::from_fn(|k| self.p[j][k]);
            for (k, weights) in weights.iter().enumerate() {
                self.p[j][FIELD + k] = weights.iter().zip(&row).map(|(a, b)| a * b).sum();
            }
        }
    }

    fn add_noise(&mut self, moved: &Moved, way_m: f64, roughness: f64, p: &GradientParameters) {
        let square = |x: f64| x * x;
        let force = square(p.acceleration_density) * moved.span_s;
        let strength2 = self.field().length_squared();
        let turn = square(p.turn_error_rad) * moved.turn_rad;
        // What the polynomial leaves out over its reach, in proportion to what it cannot foresee.
        let top = square(roughness) + square(p.liveliness_per_m) * self.top_square();
        let mut walks = [top * way_m; DEGREE + 1];
        for k in (0..DEGREE).rev() {
            walks[k] = walks[k + 1] * square(p.reach_m / (DEGREE - k) as f64);
        }
        for k in 0..self.used {
            self.p[k][k] += match k {
                0..FIELD => force,
                FIELD..BIAS => match degree(k - FIELD) {
                    1 => walks[1] + strength2 * turn,
                    higher => walks[higher],
                },
                _ => square(p.bias_walk_ut) * (moved.span_s + moved.turn_rad),
            };
        }
    }

    /// Mean square of the coefficients of the highest degree.
    fn top_square(&self) -> f64 {
        let top = &self.x[FIELD + MOVING..BIAS];
        top.iter().map(|c| c * c).sum::<f64>() / top.len() as f64
    }

    /// Takes one reading of a magnetometer; gives its normalised innovation squared per component.
    ///
    /// `turned` is the rig's axes in `N`, `arm` the magnetometer's place from the filter point and
    /// `reading` its field, both in the rig's axes.
    pub(crate) fn take(
        &mut self,
        (member, turned): (usize, DMat3),
        arm: DVec3,
        reading: DVec3,
        sigma_ut: f64,
    ) -> f64 {
        let (seen, basis) = (turned * reading, harmonic::basis(turned * arm));
        let mut nis = 0.0;
        for axis in 0..3 {
            let h = Self::row(&basis[axis], member, turned, axis);
            nis += self.update(&h, seen[axis], sigma_ut * sigma_ut) / 3.0;
        }
        nis
    }

    /// How far a reading is from what the filter foresees, µT, and the 1σ of that.
    pub(crate) fn surprise(
        &self,
        (member, turned): (usize, DMat3),
        arm: DVec3,
        reading: DVec3,
        sigma_ut: f64,
    ) -> (f64, f64) {
        let (seen, basis) = (turned * reading, harmonic::basis(turned * arm));
        let (mut off2, mut variance) = (0.0, 0.0);
        for axis in 0..3 {
            let h = Self::row(&basis[axis], member, turned, axis);
            let ph = self.times(&h);
            let innovation = seen[axis] - self.dot(&h, &self.x);
            off2 += innovation * innovation;
            variance += self.dot(&h, &ph) + sigma_ut * sigma_ut;
        }
        (libm::sqrt(off2), libm::sqrt(variance))
    }

    /// Row of the Jacobian of one component of a reading turned into `N`.
    fn row(basis: &Coefficients, member: usize, turned: DMat3, axis: usize) -> Row {
        let mut h = [0.0; STATES];
        h[FIELD..BIAS].copy_from_slice(basis);
        for k in 0..3 {
            h[BIAS + 3 * member + k] = turned.col(k)[axis];
        }
        h
    }

    fn times(&self, h: &Row) -> Row {
        let mut ph = [0.0; STATES];
        for (weight, row) in h.iter().zip(&self.p).filter(|(w, _)| **w != 0.0) {
            for k in 0..self.used {
                ph[k] += weight * row[k];
            }
        }
        ph
    }

    fn dot(&self, a: &Row, b: &Row) -> f64 {
        a[..self.used].iter().zip(&b[..self.used]).map(|(x, y)| x * y).sum()
    }

    fn update(&mut self, h: &Row, seen: f64, variance: f64) -> f64 {
        let n = self.used;
        let ph = self.times(h);
        let innovation = seen - self.dot(h, &self.x);
        let s = self.dot(h, &ph) + variance;
        let scale = libm::sqrt(s).recip();
        let scaled = ph.map(|x| x * scale);
        for i in 0..n {
            self.x[i] += ph[i] * (innovation / s);
            for k in 0..n {
                self.p[i][k] -= scaled[i] * scaled[k];
            }
            self.p[i][i] = self.p[i][i].max(1e-12);
        }
        innovation * innovation / s
    }

    /// Whether the estimate is finite.
    pub(crate) fn is_finite(&self) -> bool {
        let sum: f64 = (0..self.used).map(|k| self.x[k] + self.p[k][k]).sum();
        sum.is_finite()
    }

    fn vector(&self, at: usize) -> DVec3 {
        DVec3::new(self.x[at], self.x[at + 1], self.x[at + 2])
    }
}

fn unit_gradient(n: usize) -> DMat3 {
    let mut unit = [0.0; GRADIENTS];
    unit[n] = 1.0;
    harmonic::gradient(&unit)
}
