//! Status words: bits and small codes that messages carry as plain integers.

use bitflags::bitflags;

bitflags! {
    /// What the lane says about a pose.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct Status: u32 {
        /// The initial alignment is done; orientation means something.
        const INITIALISED = 1 << 0;
        /// The camera stands still (zero-velocity and zero-rate updates are applied).
        const STATIONARY = 1 << 1;
        /// The magnetic field does not fit the reference; the magnetometer is not trusted.
        const MAGNETIC_DISTURBANCE = 1 << 2;
        /// No sample for longer than the configured time; the pose is the last one known, and nothing in it
        /// is valid. With validity it is a body's, which goes on without this camera's sensor.
        const SENSOR_STALE = 1 << 3;
        /// This step was bridged over lost samples.
        const BRIDGED = 1 << 4;
        /// A sensor was at the end of its range during this step.
        const SATURATED = 1 << 5;
        /// A gap longer than can be bridged was crossed; sigmas are inflated.
        const DEGRADED = 1 << 6;
        /// A calibration bound to this camera is applied.
        const CALIBRATED = 1 << 7;
        /// Pitch is within 1 degree of +-90 degrees: yaw and roll are not separate.
        const GIMBAL_LOCK = 1 << 8;
        /// Strength or dip of the field are not those of the World Magnetic Model at the configured place.
        const FIELD_UNLIKE_EARTH = 1 << 9;
        /// The pose follows from the motion of a rigid body that carries several cameras.
        const ON_BODY = 1 << 10;
        /// This camera alone sees a magnetic disturbance, its companions on the body do not.
        const DISTURBANCE_LOCAL = 1 << 11;
        /// At least one member of the rigid body is voted out or silent.
        const MEMBER_OUT = 1 << 12;
        /// The position was corrected here by more than its sigma allowed, after long refusals.
        const POSITION_JUMPED = 1 << 13;
    }
}

bitflags! {
    /// Which fields of a pose hold usable values, by the configured bounds on their sigma.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct Validity: u32 {
        /// Roll and pitch.
        const TILT = 1 << 0;
        /// Heading against the world's north.
        const HEADING = 1 << 1;
        /// Velocity in the world.
        const VELOCITY = 1 << 2;
        /// Position in the world.
        const POSITION = 1 << 3;
        /// Angular rate, bias removed.
        const ANGULAR_RATE = 1 << 4;
        /// Specific force, bias removed.
        const SPECIFIC_FORCE = 1 << 5;
        /// The sensor clock is mapped to `CLOCK_MONOTONIC`.
        const TIME = 1 << 6;
    }
}

bitflags! {
    /// Kinds of aids that correct a pose, for those used and those refused by their gate.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct AidFlags: u8 {
        /// Standstill: zero velocity, zero rate.
        const STANDSTILL = 1 << 0;
        /// A speed or velocity from the aiding service.
        const SPEED = 1 << 1;
        /// A vehicle moves neither sideways nor up.
        const NON_HOLONOMIC = 1 << 2;
        /// A position from the aiding service.
        const POSITION_FIX = 1 << 3;
        /// A position and orientation from the aiding service.
        const POSE_FIX = 1 << 4;
        /// The velocity that a rig's magnetometers see in the field's gradient.
        const GRADIENT = 1 << 5;
    }
}

bitflags! {
    /// What the configuration asks of the system for a lane, and the system did not grant.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct RealTimeFlags: u8 {
        /// A thread of the lane has no real-time priority.
        const SCHEDULING = 1 << 0;
        /// Memory is not locked: a page that is needed may have to come from a disk.
        const MEMORY_LOCK = 1 << 1;
        /// A thread of the lane is not on the processor that it should stay on.
        const AFFINITY = 1 << 2;
        /// Sleeps of a thread of the lane may end later than they should.
        const TIMER_SLACK = 1 << 3;
    }
}

bitflags! {
    /// Which fields of a calibrated sample hold a new value.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct SampleFlags: u32 {
        /// A magnetometer reading came with this sample.
        const MAGNETOMETER = 1 << 0;
        /// The temperature is known.
        const TEMPERATURE = 1 << 1;
        /// A calibration bound to this camera is applied.
        const CALIBRATED = 1 << 2;
        /// At least one axis was at the end of its range.
        const SATURATED = 1 << 3;
    }
}

/// Declares a `u8` code with a fallible conversion from the wire.
macro_rules! code {
    ($(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $variant:ident = $value:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u8)]
        pub enum $name { $($(#[$vdoc])* $variant = $value),+ }

        impl $name {
            /// The meaning of a byte found in a message; `None` for a byte this version does not know.
            pub const fn from_code(code: u8) -> Option<Self> {
                match code {
                    $($value => Some(Self::$variant),)+
                    _ => None,
                }
            }

            /// The byte that stands for this value in a message.
            pub const fn code(self) -> u8 {
                self as u8
            }
        }
    };
}
pub(crate) use code;

code! {
    /// Where the heading of a pose comes from.
    HeadingSource {
        /// There is no heading.
        None = 0,
        /// The magnetometer corrects the heading now.
        Magnetometer = 1,
        /// The gyroscope carries a heading that the magnetometer gave earlier.
        GyroscopeHeld = 2,
        /// Only the initial alignment used the magnetometer.
        InitialOnly = 3,
        /// A pose from the aiding service gave it; no magnetometer ever did.
        AidingPose = 4,
    }
}

code! {
    /// Where the position of a pose comes from: the strongest aid that holds it now.
    PositionSource {
        /// There is no position.
        None = 0,
        /// The camera stands where it was (zero-velocity updates).
        Standstill = 1,
        /// Acceleration integrated twice, unaided: sigma grows.
        Inertial = 2,
        /// A speed or velocity from the aiding service.
        AidingSpeed = 3,
        /// A vehicle's constraint (neither sideways nor up) without a speed.
        NonHolonomic = 4,
        /// A position from the aiding service.
        AidingPosition = 5,
        /// A position and orientation from the aiding service.
        AidingPose = 6,
        /// The velocity from the magnetic field's gradient over a rig.
        MagneticGradient = 7,
    }
}

code! {
    /// Where the distance between two cameras comes from.
    DistanceSource {
        /// It is not known.
        Unknown = 0,
        /// Both are mounted on one body, and their places on it are configured.
        Surveyed = 1,
        /// Where each stood when it was first aligned is configured or kept; from there on, its motion.
        CommonStart = 2,
        /// Fixes by cloud registration from the aiding service.
        CloudRegistration = 3,
        /// The magnetic field's gradient over a rig holds the velocity of at least one of them.
        MagneticGradient = 4,
        /// Fixes of position or pose from the aiding service.
        PositionFix = 5,
    }
}
