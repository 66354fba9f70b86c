//! A magnetic field around a point, as a polynomial that obeys Maxwell's equations.
//!
//! Where no current flows, the field is the gradient of a harmonic potential `φ`. One of degree `l` has
//! `2 l + 1` free numbers: its derivatives `∂x^a ∂y^b ∂z^c φ` with `a + b + c = l` and `c` 0 or 1, for
//! `∂zz φ = −(∂xx + ∂yy) φ` gives all others. So the coefficients are derivatives of the potential:
//! degree 1 the field (3, µT), degree 2 its gradient (5, µT/m), degree 3 its curvature (7), and so on
//! (Skog, Hendeby, Gustafsson, "Magnetic odometry: a model-based approach using a sensor array", FUSION
//! 2018, count alike).
//!
//! The basis belonging to the coefficient `(a, b, c)`, with `x_n = x^n / n!`, is
//!
//! ```text
//! h_abc = Σ_k (−1)^k z_(c + 2k) Σ_j C(k, j) x_(a − 2j) y_(b − 2(k − j))
//! ∂x h_abc = h_(a−1)bc     ∂y h_abc = h_a(b−1)c     ∂z h_ab1 = h_ab0     ∂z h_ab0 = −(∂xx + ∂yy) h_ab1
//! ```

use glam::{DMat3, DVec3};

/// Degree of the potential: one more than the order of the field.
pub(crate) const DEGREE: usize = 3;
/// Free numbers of the polynomial; the potential's value does not count.
pub(crate) const COEFFICIENTS: usize = DEGREE * (DEGREE + 2);
/// Index of the first number of the gradient, and how many there are.
pub(crate) const GRADIENT: usize = 3;
pub(crate) const GRADIENTS: usize = 5;

/// Coefficients of the field, or weights for them.
pub(crate) type Coefficients = [f64; COEFFICIENTS];

/// How often a coefficient differentiates by x, y, z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Order {
    x: i32,
    y: i32,
    z: i32,
}

/// All coefficients in order of their degree.
const ORDERS: [Order; COEFFICIENTS] = orders();

/// [`DEGREE`] as what is counted with here.
#[allow(clippy::cast_possible_wrap, reason = "a few")]
const HIGHEST: i32 = DEGREE as i32;

const fn orders() -> [Order; COEFFICIENTS] {
    let mut all = [Order { x: 0, y: 0, z: 0 }; COEFFICIENTS];
    let (mut next, mut degree) = (0, 1);
    while degree <= HIGHEST {
        let mut z = 0;
        while z <= 1 {
            let mut y = 0;
            while y <= degree - z {
                all[next] = Order { x: degree - z - y, y, z };
                next += 1;
                y += 1;
            }
            z += 1;
        }
        degree += 1;
    }
    all
}

/// Degree of a coefficient's derivative: 1 for the field, 2 for the gradient.
pub(crate) const fn degree(coefficient: usize) -> usize {
    let order = ORDERS[coefficient];
    (order.x + order.y + order.z) as usize
}

/// `x^n / n!` for all `n` that occur.
type Powers = [f64; DEGREE + 1];

fn powers(x: f64) -> Powers {
    let mut powers = [1.0; DEGREE + 1];
    for n in 1..=DEGREE {
        powers[n] = powers[n - 1] * x / n as f64;
    }
    powers
}

/// The basis functions at a place.
struct Basis {
    x: Powers,
    y: Powers,
    z: Powers,
}

impl Basis {
    fn at(r: DVec3) -> Self {
        Self { x: powers(r.x), y: powers(r.y), z: powers(r.z) }
    }

    /// `h_abc`; zero for a negative index.
    fn value(&self, a: i32, b: i32, c: i32) -> f64 {
        if a < 0 || b < 0 || c < 0 {
            return 0.0;
        }
        let (mut sum, mut sign) = (0.0, 1.0);
        for k in 0..=i32::midpoint(a, b) {
            let mut choose = 1.0;
            for j in 0..=k {
                let (p, q) = (a - 2 * j, b - 2 * (k - j));
                if p >= 0 && q >= 0 {
                    let xy = self.x[p as usize] * self.y[q as usize];
                    sum += sign * choose * xy * self.z[(c + 2 * k) as usize];
                }
                choose *= f64::from(k - j) / f64::from(j + 1);
            }
            sign = -sign;
        }
        sum
    }

    /// `∂x^a ∂y^b ∂z^c` of the basis function of another coefficient.
    fn derivative(&self, of: Order, by: Order) -> f64 {
        let (a, b) = (of.x - by.x, of.y - by.y);
        match (of.z, by.z) {
            (c, 0) => self.value(a, b, c),
            (1, _) => self.value(a, b, 0),
            _ => -self.value(a - 2, b, 1) - self.value(a, b - 2, 1),
        }
    }
}

/// The gradient matrix `∂B/∂r` out of five numbers, µT/m: xx, xy, yy, xz, yz.
pub(crate) fn gradient(g: &[f64]) -> DMat3 {
    let [xx, xy, yy, xz, yz] = [g[0], g[1], g[2], g[3], g[4]];
    DMat3::from_cols(DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, -xx - yy))
}

/// `∂B(r)/∂c`: one row of weights for each component of the field.
pub(crate) fn basis(r: DVec3) -> [Coefficients; 3] {
    let basis = Basis::at(r);
    core::array::from_fn(|axis| ORDERS.map(|of| basis.derivative(of, ORDERS[axis])))
}

/// The matrix that moves the coefficients' point by a way: `c ← F(d) c`, exactly.
pub(crate) fn translation(d: DVec3) -> [Coefficients; COEFFICIENTS] {
    let basis = Basis::at(d);
    ORDERS.map(|by| ORDERS.map(|of| basis.derivative(of, by)))
}

/// Coefficients that differ by a way: all but those of the highest degree.
pub(crate) const MOVING: usize = (DEGREE - 1) * (DEGREE + 1);

/// `∂(F(d) c)/∂d` at `d = 0`: each coefficient changes by one of the next degree.
pub(crate) fn slope(c: &Coefficients) -> [[f64; 3]; MOVING] {
    core::array::from_fn(|k| {
        let Order { x, y, z } = ORDERS[k];
        let along_z =
            if z == 0 { at(c, x, y, 1) } else { -at(c, x + 2, y, 0) - at(c, x, y + 2, 0) };
        [at(c, x + 1, y, z), at(c, x, y + 1, z), along_z]
    })
}

/// The coefficient `(a, b, c)`.
fn at(coefficients: &Coefficients, a: i32, b: i32, c: i32) -> f64 {
    let degree = a + b + c;
    let first = (degree - 1) * (degree + 1);
    coefficients[(first + if c == 0 { b } else { degree + 1 + b }) as usize]
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

    fn field(c: &Coefficients, r: DVec3) -> DVec3 {
        DVec3::from_slice(&product(&basis(r), c))
    }

    #[test]
    fn neither_sources_nor_currents() {
        let mut random = Normal::seeded(1);
        for _ in 0..50 {
            let (c, r) = (random_coefficients(&mut random), random.vector(1.0));
            let step = 1e-4;
            let by = |d: DVec3| (field(&c, r + d * step) - field(&c, r - d * step)) / (2.0 * step);
            let (x, y, z) = (by(DVec3::X), by(DVec3::Y), by(DVec3::Z));
            assert!((x.x + y.y + z.z).abs() < 1e-6);
            let curl = DVec3::new(y.z - z.y, z.x - x.z, x.y - y.x);
            assert!(curl.length() < 1e-6);
        }
    }

    #[test]
    fn the_first_numbers_are_field_and_gradient() {
        let c = random_coefficients(&mut Normal::seeded(4));
        assert!((field(&c, DVec3::ZERO) - DVec3::new(c[0], c[1], c[2])).length() < 1e-12);
        for (axis, unit) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
            let by = (field(&c, unit * 1e-5) - field(&c, unit * -1e-5)) / 2e-5;
            assert!((by - gradient(&c[GRADIENT..GRADIENT + GRADIENTS]).col(axis)).length() < 1e-8);
        }
    }

    #[test]
    fn moving_the_point_leaves_the_field() {
        let mut random = Normal::seeded(2);
        for _ in 0..50 {
            let (c, r, d) =
                (random_coefficients(&mut random), random.vector(1.0), random.vector(1.0));
            let moved = product(&translation(d), &c).try_into().unwrap();
            assert!((field(&moved, r) - field(&c, r + d)).length() < 1e-10);
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

    #[test]
    fn a_dipole_from_its_closed_form_fits_ever_better_with_the_degree() {
        // Given a dipole two metres away, when its field is expanded by differences of the closed form,
        // then a quarter of a metre from the point the polynomial is exact to a hundredth.
        let (place, moment) = (DVec3::new(1.2, -1.5, 0.6), DVec3::new(200.0, -100.0, 300.0));
        let dipole = |r: DVec3| {
            let d = r - place;
            let (distance, n) = (d.length(), d.normalize());
            (n * (3.0 * moment.dot(n)) - moment) * (0.1 / distance.powi(3))
        };
        let mut c = [0.0; COEFFICIENTS];
        // Least squares by Kaczmarz' iteration over places around the point.
        let mut random = Normal::seeded(9);
        for _ in 0..60_000 {
            let r = random.vector(0.12);
            for (row, seen) in basis(r).iter().zip(dipole(r).to_array()) {
                let norm: f64 = row.iter().map(|w| w * w).sum();
                let miss = seen - row.iter().zip(&c).map(|(w, c)| w * c).sum::<f64>();
                for (c, w) in c.iter_mut().zip(row) {
                    *c += w * miss / norm;
                }
            }
        }
        for r in [DVec3::X * 0.2, DVec3::Y * -0.2, DVec3::Z * 0.2] {
            let off = (field(&c, r) - dipole(r)).length() / dipole(r).length();
            assert!(off < 0.01, "{off} at {r}");
        }
    }
}
