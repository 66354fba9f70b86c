//! Frames of reference as types.
//!
//! A [`Rotation<To, From>`] turns coordinates in `From` into coordinates in `To`. Two rotations
//! compose only where the frames meet:
//!
//! ```compile_fail
//! use lodestone_fusion::{Body, Rotation, World, Optical};
//! let world_from_body: Rotation<World, Body> = Rotation::IDENTITY;
//! let world_from_optical: Rotation<World, Optical> = Rotation::IDENTITY;
//! let _ = world_from_body * world_from_optical; // Body does not meet World
//! ```

use core::fmt::Debug;
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
    /// `S`: the axes in which the sensor reports, before the axis map.
    Sensor,
    /// `C`: left optical frame, x right, y down, z forward.
    Optical,
    /// `V`: the vehicle, x forward, y left, z up, to which cameras are mounted.
    Vehicle,
}

/// A rotation that turns coordinates in `From` into coordinates in `To`; unit quaternion.
pub struct Rotation<To, From> {
    quaternion: DQuat,
    frames: PhantomData<(To, From)>,
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
    fn fmt(&self, out: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        Debug::fmt(&self.quaternion, out)
    }
}

impl<To: Frame, From: Frame> Rotation<To, From> {
    /// The rotation between two frames that coincide.
    pub const IDENTITY: Self = Self { quaternion: DQuat::IDENTITY, frames: PhantomData };

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

    /// Takes yaw (about z), pitch (about y) and roll (about x), rad, applied in that order (ZYX).
    pub fn from_yaw_pitch_roll(yaw_rad: f64, pitch_rad: f64, roll_rad: f64) -> Self {
        Self::from_unit(DQuat::from_euler(glam::EulerRot::ZYX, yaw_rad, pitch_rad, roll_rad))
    }

    /// Yaw (about z), pitch (about y) and roll (about x), rad; pitch is in ±π/2.
    ///
    /// At a pitch of ±90° only yaw ∓ roll is determined; see [`Rotation::is_gimbal_locked`].
    pub fn to_yaw_pitch_roll(self) -> (f64, f64, f64) {
        self.quaternion.to_euler(glam::EulerRot::ZYX)
    }

    /// Whether pitch is within one degree of ±90°, where yaw and roll are not separate.
    pub fn is_gimbal_locked(self) -> bool {
        const COS_ONE_DEGREE: f64 = 0.999_847_695_156_391_2;
        (self.quaternion * DVec3::X).z.abs() > COS_ONE_DEGREE
    }

    /// The unit quaternion.
    pub const fn quaternion(self) -> DQuat {
        self.quaternion
    }

    /// The rotation matrix.
    pub fn matrix(self) -> DMat3 {
        DMat3::from_quat(self.quaternion)
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
