//! Rotations as quaternions: the exact exponential and logarithm.
//!
//! Source: Solà, arXiv:1711.02508, eqs. 101 and 103 to 105.

use glam::{DMat3, DQuat, DVec3};

/// Below this angle, rad, the logarithm's series is exact to the last bit.
const SMALL_ANGLE: f64 = 1e-4;
/// Below this square of half an angle, rad², sine and cosine are their series to the last bit: that of
/// a step at 400 Hz and 20 rad/s.
const SMALL_SQUARE: f64 = 6.25e-4;

/// The unit quaternion that turns by a rotation vector, rad.
pub fn exp(rotation_vector: DVec3) -> DQuat {
    let half = rotation_vector * 0.5;
    let (sine_by_angle, cosine) = sine_and_cosine(half.length_squared());
    let xyz = half * sine_by_angle;
    DQuat::from_xyzw(xyz.x, xyz.y, xyz.z, cosine)
}

/// `sin a / a` and `cos a` of an angle given by its square, rad².
fn sine_and_cosine(square: f64) -> (f64, f64) {
    if square < SMALL_SQUARE {
        let sine = 1.0
            - square * (1.0 / 6.0) * (1.0 - square * (1.0 / 20.0) * (1.0 - square * (1.0 / 42.0)));
        let cosine =
            1.0 - 0.5 * square * (1.0 - square * (1.0 / 12.0) * (1.0 - square * (1.0 / 30.0)));
        return (sine, cosine);
    }
    let angle = libm::sqrt(square);
    (libm::sin(angle) / angle, libm::cos(angle))
}

/// The rotation vector, rad, of length at most π, that a unit quaternion turns by.
pub fn log(quaternion: DQuat) -> DVec3 {
    // q and -q turn alike; the one with w >= 0 turns the short way.
    let q = if quaternion.w < 0.0 { -quaternion } else { quaternion };
    let xyz = DVec3::new(q.x, q.y, q.z);
    let sine = libm::sqrt(xyz.length_squared());
    if sine < SMALL_ANGLE {
        return xyz * (2.0 / q.w) * (1.0 - sine * sine / (3.0 * q.w * q.w));
    }
    xyz * (2.0 * libm::atan2(sine, q.w) / sine)
}

/// The matrix that forms a cross product: `skew(a) b = a × b`.
pub fn skew(v: DVec3) -> DMat3 {
    DMat3::from_cols_array(&[0.0, v.z, -v.y, -v.z, 0.0, v.x, v.y, -v.x, 0.0])
}

/// Brings a quaternion that drifted by rounding back to unit length, without a square root.
///
/// First Newton step for 1/√n at n = 1: exact to 1e-16 while |n − 1| < 1e-8.
pub fn renormalise(q: DQuat) -> DQuat {
    q * (1.5 - 0.5 * q.length_squared())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_vector(limit: f64) -> impl Strategy<Value = DVec3> {
        (-limit..limit, -limit..limit, -limit..limit).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    proptest! {
        #[test]
        fn log_undoes_exp(v in any_vector(1.8)) {
            prop_assert!((log(exp(v)) - v).length() < 1e-12);
        }

        #[test]
        fn tiny_rotations_keep_every_digit(v in any_vector(1e-5)) {
            prop_assert!((log(exp(v)) - v).length() < 1e-20);
        }

        #[test]
        fn exp_is_of_unit_length(v in any_vector(50.0)) {
            prop_assert!((exp(v).length() - 1.0).abs() < 1e-14);
        }

        #[test]
        fn skew_is_the_cross_product(a in any_vector(9.0), b in any_vector(9.0)) {
            prop_assert!((skew(a) * b - a.cross(b)).length() < 1e-12);
        }
    }

    #[test]
    fn half_a_turn_survives() {
        let v = DVec3::new(0.0, core::f64::consts::PI, 0.0);
        assert!((log(exp(v)).length() - core::f64::consts::PI).abs() < 1e-12);
    }

    #[test]
    fn the_norm_holds_over_ten_million_steps() {
        let turn = exp(DVec3::new(1.1e-3, -0.7e-3, 2.3e-3));
        let mut q = DQuat::IDENTITY;
        for _ in 0..10_000_000 {
            q = renormalise(q * turn);
        }
        assert!((q.length() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_constant_rate_turn_is_exact() {
        // 0.9 rad/s about a skew axis for 100 s in 400 Hz steps.
        let rate = DVec3::new(0.3, -0.6, 0.6);
        let mut q = DQuat::IDENTITY;
        for _ in 0..40_000 {
            q = renormalise(q * exp(rate * 0.0025));
        }
        let error = log(q.conjugate() * exp(rate * 100.0));
        assert!(error.length() < 1e-9, "{error}");
    }
}
