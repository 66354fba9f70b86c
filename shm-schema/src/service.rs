//! Names of the services, with the schema version inside.

use core::fmt;

use crate::SCHEMA_VERSION;

/// Prefix of every file in shared memory when nothing else is configured.
pub const DEFAULT_PREFIX: &str = "lodestone_";

/// Directory of the services when nothing else is configured.
///
/// Not under `/tmp`: cleaners delete the files of services that nobody opened for a while.
pub const DEFAULT_ROOT: &str = "/dev/shm/lodestone/";

/// Longest camera name, bytes.
pub const MAX_CAMERA_NAME_LEN: usize = 32;

/// Stands for a camera in the names of the services that a daemon has once; no camera can be named so.
pub const WORLD_NAME: &str = "@world";

/// The services a lane has, and those a daemon has once, under [`WORLD_NAME`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ServiceKind {
    /// [`crate::Pose`], one per grid step.
    Pose,
    /// [`crate::CalibratedSample`], one per sensor sample.
    Sample,
    /// [`crate::Health`], about once a second.
    Health,
    /// [`crate::Aiding`], from others to the lane.
    Aiding,
    /// Events: a pose was published.
    Wake,
    /// [`crate::Pose`] holding the truth of a synthetic world; for demonstrations and tests.
    Truth,
    /// [`crate::CloudHeader`] with a slice of [`crate::CloudPoint`], from a depth source to whoever
    /// reads; the daemon has no part in it.
    Cloud,
    /// [`crate::World`], about once a second; once for a daemon.
    World,
    /// [`crate::Relative`], for each pair of cameras; once for a daemon.
    Relative,
    /// [`crate::StaticTransform`], each edge of the tree of frames; once for a daemon.
    Transforms,
    /// [`crate::Request`], from others to the daemon; once for a daemon.
    Request,
}

impl ServiceKind {
    /// Every kind that a lane has.
    pub const OF_LANE: [Self; 6] =
        [Self::Pose, Self::Sample, Self::Health, Self::Aiding, Self::Wake, Self::Truth];

    /// Every kind that a daemon has once.
    pub const OF_DAEMON: [Self; 4] = [Self::World, Self::Relative, Self::Transforms, Self::Request];

    const fn word(self) -> &'static str {
        match self {
            Self::Pose => "pose",
            Self::Sample => "sample",
            Self::Health => "health",
            Self::Aiding => "aiding",
            Self::Wake => "wake",
            Self::Truth => "truth",
            Self::Cloud => "cloud",
            Self::World => "world",
            Self::Relative => "relative",
            Self::Transforms => "transforms",
            Self::Request => "request",
        }
    }

    /// The service's name for one camera, to be formatted: `lodestone/v2/<camera>/pose`.
    ///
    /// ```
    /// use lodestone_schema::ServiceKind;
    /// extern crate std;
    /// assert_eq!(std::format!("{}", ServiceKind::Pose.of("front")), "lodestone/v2/front/pose");
    /// ```
    pub const fn of(self, camera: &str) -> impl fmt::Display + '_ {
        Name { kind: self, camera }
    }
}

struct Name<'a> {
    kind: ServiceKind,
    camera: &'a str,
}

impl fmt::Display for Name<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "lodestone/v{SCHEMA_VERSION}/{}/{}", self.camera, self.kind.word())
    }
}

/// The schema version in a service name, whichever it is; `None` if the name is not Lodestone's.
///
/// ```
/// use lodestone_schema::version_of;
/// assert_eq!(version_of("lodestone/v7/front/pose"), Some(7));
/// assert_eq!(version_of("other/v7/front/pose"), None);
/// ```
pub fn version_of(service_name: &str) -> Option<u32> {
    let rest = service_name.strip_prefix("lodestone/v")?;
    rest.split('/').next()?.parse().ok()
}

/// The camera in a service name of the given kind and of any version.
///
/// ```
/// use lodestone_schema::{ServiceKind, camera_of};
/// assert_eq!(camera_of("lodestone/v2/front/pose", ServiceKind::Pose), Some("front"));
/// assert_eq!(camera_of("lodestone/v2/front/health", ServiceKind::Pose), None);
/// ```
pub fn camera_of(service_name: &str, kind: ServiceKind) -> Option<&str> {
    version_of(service_name)?;
    let mut parts = service_name.split('/').skip(2);
    let camera = parts.next()?;
    (parts.next() == Some(kind.word()) && parts.next().is_none()).then_some(camera)
}

/// Whether a text can name a camera: 1 to [`MAX_CAMERA_NAME_LEN`] of `a-z 0-9 _ -`, a letter or
/// digit first.
pub fn is_camera_name(text: &str) -> bool {
    let allowed = |b: u8| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_' || b == b'-';
    let first_good = text.bytes().next().is_some_and(|b| b.is_ascii_alphanumeric());
    first_good && text.len() <= MAX_CAMERA_NAME_LEN && text.bytes().all(allowed)
}
