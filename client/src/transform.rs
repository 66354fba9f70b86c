//! Rigid transforms between frames, of points and of clouds.

use core::fmt::{self, Debug};
use core::ops::Mul;

use glam::{DQuat, DVec3};

use crate::frame::{Body, Frame, Optical, Rotation};

/// A rigid transform that turns coordinates in `From` into coordinates in `To`.
///
/// ```
/// use glam::{DQuat, DVec3};
/// use lodestone_client::{Body, Rotation, Transform, World, body_from_optical_axes};
///
/// let level = Rotation::<World, Body>::IDENTITY;
/// let world_from_body = Transform::new(level, DVec3::new(10.0, 20.0, 1.5));
/// let world_from_optical = world_from_body * body_from_optical_axes();
/// // Two metres ahead of a camera that looks east, 0.5 m to its right.
/// let seen = world_from_optical.apply(DVec3::new(0.5, 0.0, 2.0));
/// assert_eq!(seen, DVec3::new(12.0, 19.5, 1.5));
/// assert_eq!(world_from_optical.inverse().apply(seen), DVec3::new(0.5, 0.0, 2.0));
/// ```
///
/// ```compile_fail
/// use lodestone_client::{Body, Transform, World, body_from_optical_axes};
/// let world_from_body = Transform::<World, Body>::IDENTITY;
/// let _ = body_from_optical_axes() * world_from_body; // Optical does not meet World
/// ```
pub struct Transform<To, From> {
    rotation: Rotation<To, From>,
    origin: DVec3,
}

/// Source and destination of a cloud transform differ in length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the cloud has {points} points, the buffer has room for {room}: make them equally long")]
pub struct LengthMismatch {
    /// Points given.
    pub points: usize,
    /// Points the buffer takes.
    pub room: usize,
}

/// Turns optical coordinates into body coordinates for a camera whose optical centre is its IMU.
///
/// A pure permutation of axes, exact in floating point: forward is the optical z, left is the
/// opposite of the optical x, up is the opposite of the optical y. A camera whose extrinsics are
/// known takes its own [`Transform<Body, Optical>`] instead.
pub const fn body_from_optical_axes() -> Transform<Body, Optical> {
    let permutation = Rotation::from_unit(DQuat::from_xyzw(-0.5, 0.5, -0.5, 0.5));
    Transform { rotation: permutation, origin: DVec3::ZERO }
}

impl<To, From> Clone for Transform<To, From> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<To, From> Copy for Transform<To, From> {}

impl<To, From> PartialEq for Transform<To, From> {
    fn eq(&self, other: &Self) -> bool {
        self.rotation == other.rotation && self.origin == other.origin
    }
}

impl<To, From> Debug for Transform<To, From> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Transform")
            .field("rotation", &self.rotation)
            .field("origin", &self.origin)
            .finish()
    }
}

impl<To: Frame, From: Frame> Transform<To, From> {
    /// The transform between two frames that coincide.
    pub const IDENTITY: Self = Self { rotation: Rotation::IDENTITY, origin: DVec3::ZERO };

    /// Takes the rotation and where the origin of `From` lies in `To`, m.
    pub const fn new(rotation: Rotation<To, From>, origin: DVec3) -> Self {
        Self { rotation, origin }
    }

    /// The rotation.
    pub const fn rotation(self) -> Rotation<To, From> {
        self.rotation
    }

    /// Where the origin of `From` lies in `To`, m.
    pub const fn origin(self) -> DVec3 {
        self.origin
    }

    /// The opposite transform.
    #[must_use]
    pub fn inverse(self) -> Transform<From, To> {
        let rotation = self.rotation.inverse();
        Transform { rotation, origin: -rotation.apply(self.origin) }
    }

    /// Coordinates in `To` of a point given in `From`, m.
    pub fn apply(self, point: DVec3) -> DVec3 {
        self.rotation.apply(point) + self.origin
    }

    /// Turns a cloud's points from `From` into `To` where they lie, m.
    ///
    /// The arithmetic is f64. A point without depth (`NaN`) stays `NaN`.
    ///
    /// ```
    /// use lodestone_client::body_from_optical_axes;
    /// let mut cloud = [[1.0, 2.0, 3.0], [f32::NAN; 3]];
    /// body_from_optical_axes().apply_to_cloud(&mut cloud);
    /// assert_eq!(cloud[0], [3.0, -1.0, -2.0]);
    /// assert!(cloud[1][0].is_nan());
    /// ```
    pub fn apply_to_cloud(self, cloud: &mut [[f32; 3]]) {
        let turn = self.for_points();
        for point in cloud {
            *point = turn(*point);
        }
    }

    /// Writes a cloud's points, turned from `From` into `To`, to a buffer of the same length, m.
    ///
    /// # Errors
    /// [`LengthMismatch`]; then nothing is written.
    pub fn apply_to_cloud_into(
        self,
        cloud: &[[f32; 3]],
        out: &mut [[f32; 3]],
    ) -> Result<(), LengthMismatch> {
        if cloud.len() != out.len() {
            return Err(LengthMismatch { points: cloud.len(), room: out.len() });
        }
        let turn = self.for_points();
        for (to, from) in out.iter_mut().zip(cloud) {
            *to = turn(*from);
        }
        Ok(())
    }

    /// The transform of one point, with the matrix worked out once.
    fn for_points(self) -> impl Fn([f32; 3]) -> [f32; 3] {
        let (matrix, origin) = (self.rotation.matrix(), self.origin);
        move |[x, y, z]| {
            let point = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
            let turned = matrix * point + origin;
            [turned.x as f32, turned.y as f32, turned.z as f32]
        }
    }
}

impl<To: Frame, Mid: Frame, From: Frame> Mul<Transform<Mid, From>> for Transform<To, Mid> {
    type Output = Transform<To, From>;

    fn mul(self, inner: Transform<Mid, From>) -> Self::Output {
        Transform {
            rotation: self.rotation * inner.rotation,
            origin: self.rotation.apply(inner.origin) + self.origin,
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::frame::World;

    fn transforms() -> impl Strategy<Value = Transform<World, Body>> {
        let quaternion = prop::array::uniform4(-1.0..1.0_f64)
            .prop_filter_map("zero", |q| Rotation::from_quaternion(DQuat::from_array(q)));
        let origin = prop::array::uniform3(-1e3..1e3_f64).prop_map(DVec3::from_array);
        (quaternion, origin).prop_map(|(rotation, origin)| Transform::new(rotation, origin))
    }

    fn points() -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-100.0..100.0_f64).prop_map(DVec3::from_array)
    }

    proptest! {
        #[test]
        fn inverse_undoes(transform in transforms(), point in points()) {
            let back = transform.inverse().apply(transform.apply(point));
            prop_assert!(back.abs_diff_eq(point, 1e-9), "{back} {point}");
        }

        #[test]
        fn product_applies_the_right_factor_first(transform in transforms(), point in points()) {
            let step_by_step = transform.apply(body_from_optical_axes().apply(point));
            let at_once = (transform * body_from_optical_axes()).apply(point);
            prop_assert!(at_once.abs_diff_eq(step_by_step, 1e-9));
        }

        #[test]
        fn clouds_agree_with_points(transform in transforms(), point in points()) {
            let given = point.as_vec3().to_array();
            let mut in_place = [given];
            let mut apart = [[0.0; 3]];
            transform.apply_to_cloud(&mut in_place);
            transform.apply_to_cloud_into(&[given], &mut apart).unwrap();
            let expected = transform.apply(point).as_vec3();
            prop_assert_eq!(in_place, apart);
            prop_assert!(glam::Vec3::from_array(apart[0]).abs_diff_eq(expected, 1e-3));
        }
    }

    #[test]
    fn a_short_buffer_is_refused_and_left_alone() {
        let mut out = [[7.0; 3]];
        let refused = body_from_optical_axes().apply_to_cloud_into(&[[0.0; 3]; 2], &mut out);
        assert_eq!(refused, Err(LengthMismatch { points: 2, room: 1 }));
        assert_eq!(out, [[7.0; 3]]);
    }
}
