//! What can go wrong, one enum per operation.

use std::sync::Arc;

use lodestone_schema::Validity;
use lodestone_schema::transport::{DomainError, OpenError};

/// Why a message found in shared memory is not used.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MessageError {
    /// A code that this version does not know.
    #[error(
        "field {field} holds code {code}, which schema version {ours} does not define",
        ours = lodestone_schema::SCHEMA_VERSION
    )]
    UnknownCode {
        /// The field.
        field: &'static str,
        /// The byte found.
        code: u8,
    },
    /// A number that is flagged as usable is not finite, or beyond any physical meaning.
    #[error(
        "field {field} holds {value}; allowed where it is flagged valid: finite, within ±{limit:e}"
    )]
    OutOfRange {
        /// The field.
        field: &'static str,
        /// The number found.
        value: f64,
        /// Largest magnitude allowed.
        limit: f64,
    },
    /// The orientation is not a rotation.
    #[error("field orientation has norm {norm}; allowed: 1 within 1e-6")]
    NotUnit {
        /// The norm found.
        norm: f64,
    },
    /// A name that is not text.
    #[error("field {field} holds no name; allowed: UTF-8 filled up with zero bytes")]
    BadName {
        /// The field.
        field: &'static str,
    },
    /// A variance is below zero.
    #[error("field {field} has the variance {value}; allowed: 0 or more")]
    NegativeVariance {
        /// The field.
        field: &'static str,
        /// The entry found.
        value: f64,
    },
    /// A time before the clock's origin.
    #[error("field {field} holds {value_ns} ns; allowed: 0 or more")]
    NegativeTime {
        /// The field.
        field: &'static str,
        /// The time found, ns.
        value_ns: i64,
    },
}

/// A text that cannot name a camera.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{0:?} cannot name a camera; allowed: 1 to 32 of a-z, 0-9, '_' and '-', a letter or digit first"
)]
pub struct CameraNameError(pub String);

/// Why a stream has no connection.
#[derive(Debug, thiserror::Error)]
pub enum ConnectError {
    /// The domain's root directory does not exist, so no daemon ever ran there.
    #[error(
        "no daemon in domain prefix {prefix:?}, root {root:?}: start lodestoned, or name the domain it uses"
    )]
    NoDaemon {
        /// The domain's prefix.
        prefix: String,
        /// The domain's root directory.
        root: String,
    },
    /// The domain is closed to this user.
    #[error(
        "the domain in {root:?} belongs to another user (uid {owner}): run as that user, or share the directory with a group"
    )]
    OtherUser {
        /// The domain's root directory.
        root: String,
        /// Who owns it.
        owner: u32,
    },
    /// The domain cannot be entered.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// The service cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The service takes no further consumer.
    #[error(
        "camera {camera:?} already has as many consumers as the daemon allows: stop one, or raise the daemon's limit"
    )]
    TooManyConsumers {
        /// The camera.
        camera: String,
    },
    /// The transport refused.
    #[error("cannot receive from camera {camera:?}: {what}")]
    Transport {
        /// The camera.
        camera: String,
        /// What iceoryx2 says.
        what: String,
    },
}

/// Why a stream has nothing to give.
#[derive(Clone, Debug, thiserror::Error)]
pub enum StreamError {
    /// There is no connection, and there never was a message; the stream goes on trying.
    #[error("not connected: {0}")]
    NotConnected(Arc<ConnectError>),
    /// The service is open, but nothing has come yet.
    #[error("camera {camera:?} has published nothing yet")]
    NothingYet {
        /// The camera.
        camera: String,
    },
    /// Nothing new came within the time allowed.
    #[error("nothing new from camera {camera:?} within {waited_ms} ms")]
    TimedOut {
        /// The camera.
        camera: String,
        /// How long was waited, ms.
        waited_ms: u128,
    },
}

/// Why a measurement was not handed to the daemon.
#[derive(Debug, thiserror::Error)]
pub enum AidingError {
    /// A number is not finite.
    #[error("{what} is not finite")]
    NotFinite {
        /// What it is.
        what: &'static str,
    },
    /// A standard deviation or variance is not above zero.
    #[error("{what} is not above zero")]
    NotPositive {
        /// What it is.
        what: &'static str,
    },
    /// The camera's lane publishes nothing, so it cannot be told for whom the measurement is.
    #[error(transparent)]
    Stream(#[from] StreamError),
    /// The aiding service cannot be opened.
    #[error(transparent)]
    Connect(#[from] ConnectError),
    /// The anchor's pose at that time is not known, so nothing can be given in the world by it.
    #[error("the anchor: {0}")]
    AnchorPose(#[from] LookupError),
    /// The anchor's pose at that time is not within the daemon's bounds.
    #[error("the anchor: {0}")]
    AnchorNotValid(#[from] NotValid),
    /// A relative pose needs [`crate::AidingPublisher::anchored_to`].
    #[error("a relative pose is one against another camera: say which with anchored_to")]
    NoAnchor,
    /// The lane does not listen, or no longer; try again.
    #[error("nobody listens to aiding measurements: is the daemon running?")]
    NobodyListens,
    /// The transport refused.
    #[error("cannot hand over a measurement: {what}")]
    Transport {
        /// What iceoryx2 says.
        what: String,
    },
}

/// Fields of a pose that were asked for and are not known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not valid: {}", names(*.0))]
pub struct NotValid(pub Validity);

/// Why there is no pose for a time.
#[derive(Clone, Debug, thiserror::Error)]
pub enum LookupError {
    /// There is no pose at all, for want of a connection.
    #[error("not connected: {0}")]
    NotConnected(Arc<ConnectError>),
    /// The service is open, but no pose has come yet.
    #[error("no pose has come yet")]
    Empty,
    /// The time is before everything kept.
    #[error("{asked_ns} ns is {:.1} ms before the oldest pose kept, of {oldest_ns} ns: keep a longer history, or ask sooner after the image", ms(*.oldest_ns, *.asked_ns))]
    TooOld {
        /// Time of the oldest pose of this history, `CLOCK_MONOTONIC`, ns.
        oldest_ns: i64,
        /// The time asked for, `CLOCK_MONOTONIC`, ns.
        asked_ns: i64,
    },
    /// The time is further ahead than may be predicted.
    #[error("{asked_ns} ns is {:.1} ms after the newest pose, of {newest_ns} ns; prediction is allowed for {:.1} ms", ms(*.asked_ns, *.newest_ns), ms(*.cap_ns, 0))]
    TooNew {
        /// Time of the newest pose, `CLOCK_MONOTONIC`, ns.
        newest_ns: i64,
        /// The time asked for, `CLOCK_MONOTONIC`, ns.
        asked_ns: i64,
        /// Longest prediction allowed, ns.
        cap_ns: i64,
    },
    /// Poses around the time are too far apart to say what was between them.
    #[error("{asked_ns} ns lies in a gap of {:.1} ms between poses; interpolation is allowed across {:.1} ms", ms(*.after_ns, *.before_ns), ms(*.limit_ns, 0))]
    Gap {
        /// Time of the last pose before, `CLOCK_MONOTONIC`, ns.
        before_ns: i64,
        /// Time of the first pose after, `CLOCK_MONOTONIC`, ns.
        after_ns: i64,
        /// The time asked for, `CLOCK_MONOTONIC`, ns.
        asked_ns: i64,
        /// Longest gap allowed, ns.
        limit_ns: i64,
    },
    /// There is a pose, but not with what was asked for.
    #[error(transparent)]
    NotValid(#[from] NotValid),
}

fn ms(later_ns: i64, earlier_ns: i64) -> f64 {
    later_ns.saturating_sub(earlier_ns) as f64 * 1e-6
}

/// The flags in words.
fn names(flags: Validity) -> String {
    const NAMES: [(Validity, &str); 7] = [
        (Validity::TILT, "tilt"),
        (Validity::HEADING, "heading"),
        (Validity::VELOCITY, "velocity"),
        (Validity::POSITION, "position"),
        (Validity::ANGULAR_RATE, "angular rate"),
        (Validity::SPECIFIC_FORCE, "specific force"),
        (Validity::TIME, "time (the sensor clock is not mapped yet)"),
    ];
    let named = NAMES.iter().filter(|(flag, _)| flags.contains(*flag));
    named.map(|(_, name)| *name).collect::<Vec<_>>().join(", ")
}
