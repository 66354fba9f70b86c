//! What sensors measure, each quantity its own type with its frame.

use core::marker::PhantomData;

use glam::DVec3;

use crate::frame::{Frame, Rotation};

macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name<F> {
            /// The coordinates in frame `F`.
            pub vector: DVec3,
            frame: PhantomData<F>,
        }

        impl<F: Frame> $name<F> {
            /// Takes coordinates in frame `F`.
            pub const fn new(vector: DVec3) -> Self {
                Self { vector, frame: PhantomData }
            }

            /// The same quantity in another frame.
            #[must_use]
            pub fn rotated<To: Frame>(self, rotation: Rotation<To, F>) -> $name<To> {
                $name::new(rotation.apply(self.vector))
            }
        }
    };
}

quantity! {
    /// Angular rate against inertial space, rad/s.
    Gyro
}
quantity! {
    /// Specific force (acceleration minus gravity), m/s²; reads +9.81 upward at rest.
    Accel
}
quantity! {
    /// Magnetic flux density, µT.
    Mag
}
