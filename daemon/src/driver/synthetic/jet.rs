//! Forward differentiation in time, to the second derivative.
//!
//! A [`Jet`] carries a quantity with its first and second derivative by time. Trajectories are
//! written once as functions of jets; velocity and acceleration then follow by the chain rule,
//! exact to rounding, with no second formula that could disagree with the first.

use std::ops::{Add, Mul, Neg, Sub};

/// A quantity `x(t)` with `dx/dt` and `d²x/dt²`, in its unit, per s and per s².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Jet {
    /// `x`.
    pub(crate) value: f64,
    /// `dx/dt`.
    pub(crate) first: f64,
    /// `d²x/dt²`.
    pub(crate) second: f64,
}

impl Jet {
    /// A quantity with its derivatives.
    pub(crate) const fn new(value: f64, first: f64, second: f64) -> Self {
        Self { value, first, second }
    }

    /// A quantity that does not change.
    pub(crate) const fn constant(value: f64) -> Self {
        Self::new(value, 0.0, 0.0)
    }

    /// `f(x)`, given `f`, `f'` and `f''` at `x.value` (Faà di Bruno to the second order).
    pub(crate) fn chain(self, f: f64, df: f64, ddf: f64) -> Self {
        Self::new(f, df * self.first, ddf * self.first * self.first + df * self.second)
    }

    /// Sine and cosine, of rad.
    pub(crate) fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.value.sin_cos();
        (self.chain(s, c, -s), self.chain(c, -s, -c))
    }

    /// Sine, of rad.
    pub(crate) fn sin(self) -> Self {
        self.sin_cos().0
    }

    /// The angle of the vector (`x`, `self`), rad in ±π; not defined at the zero vector.
    pub(crate) fn atan2(self, x: Self) -> Self {
        let y = self;
        let square = x.value * x.value + y.value * y.value;
        let first = (x.value * y.first - y.value * x.first) / square;
        let turning = (x.value * y.second - y.value * x.second) / square;
        let growing = (x.value * x.first + y.value * y.first) / square;
        Self::new(y.value.atan2(x.value), first, turning - 2.0 * first * growing)
    }

    /// Square root; only where the value is above zero.
    pub(crate) fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root, -0.25 / (root * self.value))
    }

    /// Arc tangent, rad.
    pub(crate) fn atan(self) -> Self {
        self.atan2(Self::constant(1.0))
    }

    /// The quintic blend 10x³ − 15x⁴ + 6x⁵ from 0 at x ≤ 0 to 1 at x ≥ 1; its first and second
    /// derivatives are zero at both ends, so pieces joined by it are C².
    pub(crate) fn blend(self) -> Self {
        let blend = Blend::at(self.value);
        self.chain(blend.value, blend.first, blend.second)
    }

    /// A quantity given by its value and by its derivative `slope` with respect to `by`: how a
    /// numerical integral enters a chain of exact derivatives.
    pub(crate) fn integral(value: f64, slope: Self, by: Self) -> Self {
        let second = slope.first * by.first + slope.value * by.second;
        Self::new(value, slope.value * by.first, second)
    }
}

/// The quintic blend with its integral and its derivatives by x.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blend {
    /// ∫ from 0 to x; ½ at x = 1.
    pub(crate) integral: f64,
    /// 10x³ − 15x⁴ + 6x⁵.
    pub(crate) value: f64,
    /// 30x²(1 − x)².
    pub(crate) first: f64,
    /// 60x(1 − x)(1 − 2x).
    pub(crate) second: f64,
    /// 60(1 − 6x + 6x²) inside, zero outside; the first derivative that jumps.
    pub(crate) third: f64,
}

impl Blend {
    /// The blend at x; constant outside of 0 to 1.
    pub(crate) fn at(x: f64) -> Self {
        if x <= 0.0 {
            return Self { integral: 0.0, value: 0.0, first: 0.0, second: 0.0, third: 0.0 };
        }
        if x >= 1.0 {
            return Self { integral: x - 0.5, value: 1.0, first: 0.0, second: 0.0, third: 0.0 };
        }
        let left = 1.0 - x;
        Self {
            integral: x * x * x * x * (2.5 + x * (x - 3.0)),
            value: x * x * x * (10.0 + x * (6.0 * x - 15.0)),
            first: 30.0 * x * x * left * left,
            second: 60.0 * x * left * (left - x),
            third: 60.0 * (1.0 - 6.0 * x * left),
        }
    }
}

impl Add for Jet {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::new(self.value + other.value, self.first + other.first, self.second + other.second)
    }
}

impl Add<f64> for Jet {
    type Output = Self;

    fn add(self, constant: f64) -> Self {
        Self::new(self.value + constant, self.first, self.second)
    }
}

impl Sub for Jet {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Neg for Jet {
    type Output = Self;

    fn neg(self) -> Self {
        self * -1.0
    }
}

impl Mul for Jet {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self::new(
            self.value * other.value,
            self.first * other.value + self.value * other.first,
            self.second * other.value + 2.0 * self.first * other.first + self.value * other.second,
        )
    }
}

impl Mul<f64> for Jet {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self::new(self.value * factor, self.first * factor, self.second * factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Step of the central differences: truncation h²/6 and rounding ε/h² both stay below 1e-5.
    const STEP: f64 = 1e-4;

    fn agrees(f: impl Fn(Jet) -> Jet, t: f64) -> Result<(), TestCaseError> {
        let at = |t: f64| f(Jet::new(t, 1.0, 0.0));
        let (before, here, after) = (at(t - STEP), at(t), at(t + STEP));
        let first = (after.value - before.value) / (2.0 * STEP);
        let second = (after.first - before.first) / (2.0 * STEP);
        let bound = |x: f64| 1e-5 * (1.0 + x.abs());
        prop_assert!((here.first - first).abs() < bound(first), "{here:?} against {first}");
        prop_assert!((here.second - second).abs() < bound(second), "{here:?} against {second}");
        Ok(())
    }

    /// A quantity with all three entries in use, between 0.2 and 2.2.
    fn inner(t: Jet) -> Jet {
        (t * 1.3 + 0.4).sin() + 1.2
    }

    proptest! {
        #[test]
        fn products_and_sums_agree_with_central_differences(t in -3.0..3.0f64) {
            agrees(|t| inner(t) * t - t * t * 0.5 + 3.0, t)?;
        }

        #[test]
        fn trigonometry_agrees_with_central_differences(t in -3.0..3.0f64) {
            agrees(|t| (inner(t) * 2.0).sin(), t)?;
            agrees(|t| (inner(t) * t).sin_cos().1, t)?;
            agrees(|t| inner(t).atan2(inner(t * 0.7 + 0.3)), t)?;
            agrees(|t| (inner(t) * 1.7).atan(), t)?;
            agrees(|t| inner(t).sqrt(), t)?;
        }

        #[test]
        fn the_blend_agrees_with_central_differences(t in 0.01..0.99f64) {
            agrees(Jet::blend, t)?;
            agrees(|t| (inner(t) * 0.4).blend(), t)?;
        }

        #[test]
        fn integral_and_third_derivative_of_the_blend_agree(x in 0.01..0.99f64) {
            let (before, here, after) = (Blend::at(x - STEP), Blend::at(x), Blend::at(x + STEP));
            let value = (after.integral - before.integral) / (2.0 * STEP);
            let third = (after.second - before.second) / (2.0 * STEP);
            prop_assert!((here.value - value).abs() < 1e-6);
            prop_assert!((here.third - third).abs() < 1e-4);
        }

        #[test]
        fn an_integral_has_its_slope(t in -3.0..3.0f64) {
            // ∫ cos(s) ds = sin(s), with s itself a function of time.
            let s = inner(Jet::new(t, 1.0, 0.0));
            let integral = Jet::integral(s.value.sin(), s.sin_cos().1, s);
            let direct = s.sin();
            prop_assert!((integral.first - direct.first).abs() < 1e-12);
            prop_assert!((integral.second - direct.second).abs() < 1e-12);
        }
    }

    #[test]
    fn the_blend_is_smooth_at_its_ends() {
        for (x, value) in [(0.0, 0.0), (1.0, 1.0)] {
            for side in [x - 1e-9, x + 1e-9] {
                let blend = Jet::new(side, 1.0, 0.0).blend();
                assert!((blend.value - value).abs() < 1e-12);
                assert!(blend.first.abs() < 1e-12 && blend.second.abs() < 1e-6);
            }
        }
        assert!((Blend::at(1.0).integral - 0.5).abs() < f64::EPSILON);
        assert!((Blend::at(1.0 - 1e-9).integral - Blend::at(1.0 + 1e-9).integral).abs() < 1e-8);
    }
}
