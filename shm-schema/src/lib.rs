//! What Lodestone lays in shared memory, and nothing else.
//!
//! Every message is a plain `repr(C)` struct of numbers whose size and offsets are asserted at
//! compile time. A change of layout or meaning raises [`SCHEMA_VERSION`], which stands in three
//! places: the type name that iceoryx2 compares, the service name, and the service attribute
//! [`VERSION_ATTRIBUTE`]. A consumer built for another version is refused by name; it never reads
//! another layout.
//!
//! Conventions, for every message:
//!
//! * `*_time_ns` is `CLOCK_MONOTONIC` of the publishing computer in nanoseconds, unless the name
//!   says otherwise; [`Pose::unix_offset_ns`] turns it into UNIX time.
//! * Quaternions are Hamilton, body to world, stored `x y z w`.
//! * World `W` is east, north, up; body `B` is forward, left, up (both right-handed).
//! * Covariances are the upper triangle of a symmetric 3x3 matrix: `xx xy xz yy yz zz`.
//! * What is unknown is `NaN` and lacks its [`Validity`] flag; nothing unknown is published as zero.
//!
//! The feature `transport` (off by default, needs `std`) adds how both ends open the services.
#![cfg_attr(not(feature = "transport"), no_std)]
#![forbid(unsafe_op_in_unsafe_fn)]

mod aiding;
mod cloud;
mod flags;
mod health;
mod layout;
mod name;
mod pose;
mod relative;
mod request;
mod sample;
mod service;
mod transform;
#[cfg(feature = "transport")]
pub mod transport;
mod world;

pub use aiding::{Aiding, AidingKind, AidingOrigin};
pub use cloud::{CloudFields, CloudFrame, CloudHeader, CloudPoint};
pub use flags::{
    AidFlags, DistanceSource, HeadingSource, PositionSource, RealTimeFlags, SampleFlags, Status,
    Validity,
};
pub use health::{AlignmentWait, AnchorRefusal, Health, LaneState};
pub use name::{NAME_BYTES, name_of, to_name};
pub use pose::Pose;
pub use relative::Relative;
pub use request::{Request, RequestKind};
pub use sample::CalibratedSample;
pub use service::{
    DEFAULT_PREFIX, DEFAULT_ROOT, MAX_CAMERA_NAME_LEN, ServiceKind, WORLD_NAME, camera_of,
    is_camera_name, version_of,
};
pub use transform::{StaticTransform, TransformKind};
pub use world::{NorthKind, World, WorldState};

/// Version of every message in this crate.
pub const SCHEMA_VERSION: u32 = 2;

/// Key of the service attribute whose value is [`SCHEMA_VERSION`] in decimal.
pub const VERSION_ATTRIBUTE: &str = "lodestone.schema_version";

/// [`SCHEMA_VERSION`] as the text of the service attribute.
pub const VERSION_ATTRIBUTE_VALUE: &str = "2";

const _: () = assert!(
    matches!(u32::from_str_radix(VERSION_ATTRIBUTE_VALUE, 10), Ok(SCHEMA_VERSION)),
    "the attribute's text is not the schema version"
);
