//! Frames of reference as types, and rotations between them.
//!
//! ```compile_fail
//! use lodestone_client::{Body, Optical, Rotation, World};
//! let world_from_body: Rotation<World, Body> = Rotation::IDENTITY;
//! let world_from_optical: Rotation<World, Optical> = Rotation::IDENTITY;
//! let _ = world_from_body * world_from_optical; // Body does not meet World
//! ```

use core::fmt::{self, Debug};
use core::marker::PhantomData;
use core::ops::Mul;

use glam::{DMat3, DQuat, DVec3};

/// A frame of reference; a type that is never built.
pub trait Frame: Copy + Debug + PartialEq + 'static {}

macro_rules! frames {
    ($($(#[$doc:meta])* $name:ident),+ $(,)?) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $name {}
        impl Frame for $name {}
    )+};
}

frames! {
    /// `W`: east, north, up; levelled by gravity, north by the magnetic field.
    World,
    /// `B`: the camera's IMU frame, x forward, y left, z up.
    Body,
    /// `C`: the left optical frame, x right, y down, z forward.
    Optical,
}

/// A rotation that turns coordinates in `From` into coordinates in `To`; a unit quaternion.
///
/// Two rotations compose only where the frames meet:
///
/// ```
/// use glam::{DQuat, DVec3};
/// use lodestone_client::{Body, Rotation, World, body_from_optical_axes};
///
/// let quarter_turn = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2);
/// let world_from_body = Rotation::<World, Body>::from_quaternion(quarter_turn).unwrap();
/// let world_from_optical = world_from_body * body_from_optical_axes().rotation();
/// // The camera looks along its z: turned from east to north.
/// assert!(world_from_optical.apply(DVec3::Z).abs_diff_eq(DVec3::Y, 1e-15));
/// ```
///
/// ```compile_fail
/// use lodestone_client::{Body, Optical, Rotation, World};
/// let world_from_body: Rotation<World, Body> = Rotation::IDENTITY;
/// let world_from_optical: Rotation<World, Optical> = Rotation::IDENTITY;
/// let _ = world_from_body * world_from_optical; // Body does not meet World
/// ```
pub struct Rotation<To, From> {
    quaternion: DQuat,
    frames: PhantomData<fn() -> (To, From)>,
}

impl<To, From> Clone for Rotation<To, From> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<To, From> Copy for Rotation<To, From> {}

impl<To, From> PartialEq for Rotation<To, From> {
    fn eq(&self, other: &Self) -> bool {
        self.quaternion == other.quaternion
    }
}

impl<To, From> Debug for Rotation<To, From> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        Debug::fmt(&self.quaternion, out)
    }
}

impl<To: Frame, From: Frame> Rotation<To, From> {
    /// The rotation between two frames whose axes coincide.
    pub const IDENTITY: Self = Self::from_unit(DQuat::IDENTITY);

    /// Takes a Hamilton quaternion whose product `q v q*` turns `From` coordinates into `To`.
    ///
    /// The quaternion is normalised; one that cannot be (zero, not finite) gives `None`.
    pub fn from_quaternion(quaternion: DQuat) -> Option<Self> {
        let norm = quaternion.length();
        let usable = norm.is_finite() && norm > 1e-6;
        usable.then(|| Self::from_unit(quaternion * norm.recip()))
    }

    /// Takes a quaternion that is already of unit length.
    pub(crate) const fn from_unit(quaternion: DQuat) -> Self {
        Self { quaternion, frames: PhantomData }
    }

    /// The unit quaternion.
    pub const fn quaternion(self) -> DQuat {
        self.quaternion
    }

    /// The rotation matrix.
    pub fn matrix(self) -> DMat3 {
        DMat3::from_quat(self.quaternion)
    }

    /// Yaw (about z), pitch (about y) and roll (about x), rad, as applied in that order (ZYX).
    ///
    /// At a pitch of ±90° only yaw ∓ roll is determined; see [`crate::Status::GIMBAL_LOCK`].
    pub fn to_yaw_pitch_roll(self) -> (f64, f64, f64) {
        self.quaternion.to_euler(glam::EulerRot::ZYX)
    }

    /// The opposite rotation.
    #[must_use]
    pub fn inverse(self) -> Rotation<From, To> {
        Rotation::from_unit(self.quaternion.conjugate())
    }

    /// Coordinates in `To` of a vector given in `From`.
    pub fn apply(self, vector: DVec3) -> DVec3 {
        self.quaternion * vector
    }
}

impl<To: Frame, Mid: Frame, From: Frame> Mul<Rotation<Mid, From>> for Rotation<To, Mid> {
    type Output = Rotation<To, From>;

    fn mul(self, inner: Rotation<Mid, From>) -> Self::Output {
        Rotation::from_unit(self.quaternion * inner.quaternion)
    }
}
