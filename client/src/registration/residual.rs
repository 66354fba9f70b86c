//! How far a point is from a plane, and how that changes as its cloud moves.

use glam::DVec3;
use nalgebra::Vector6;

use super::correction::Correction;
use super::plane::Plane;
use super::prior::stack;

/// Distance of a moved source point to the plane it belongs to, `n · (p' − q)`, m (Chen and Medioni
/// 1991, "Object modeling by registration of multiple range images", eq. 6).
pub(super) fn distance_m(correction: &Correction, point: DVec3, plane: &Plane) -> f64 {
    plane.normal.dot(correction.apply(point) - plane.point)
}

/// Change of [`distance_m`] with a step: `(a × n, n)`, `a` from the body to the point (Low 2004,
/// "Linear least-squares optimization for point-to-plane ICP surface registration", eq. 8; exact here,
/// because the step turns what is already turned).
pub(super) fn jacobian(correction: &Correction, point: DVec3, plane: &Plane) -> Vector6<f64> {
    stack(correction.arm(point).cross(plane.normal), plane.normal)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn vectors(limit: f64) -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-limit..limit).prop_map(DVec3::from_array)
    }

    proptest! {
        #[test]
        fn jacobian_is_the_central_difference(
            turn in vectors(1.8), shift in vectors(1.0), pivot in vectors(10.0),
            point in vectors(10.0), on in vectors(10.0), normal in vectors(1.0),
        ) {
            prop_assume!(normal.length() > 1e-3);
            let plane = Plane::ideal(on, normal.normalize());
            let at = Correction::none(pivot).plus(&stack(turn, shift));
            let jacobian = jacobian(&at, point, &plane);
            for axis in 0..6 {
                let step = Vector6::ith(axis, 1e-6);
                let after = distance_m(&at.plus(&step), point, &plane);
                let before = distance_m(&at.plus(&-step), point, &plane);
                let slope = (after - before) / 2e-6;
                prop_assert!((slope - jacobian[axis]).abs() < 1e-6, "{axis}: {slope} {jacobian}");
            }
        }
    }
}
