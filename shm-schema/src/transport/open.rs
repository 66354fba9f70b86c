//! Opening a service for writing (the daemon) and for reading (a consumer).

use core::fmt::Debug;
use core::time::Duration;

use std::thread::sleep;

use iceoryx2::node::Node;
use iceoryx2::prelude::{
    AttributeVerifier, CallbackProgression, Service, ServiceName, ZeroCopySend, ipc,
};
use iceoryx2::service::attribute::AttributeKey;
use iceoryx2::service::builder::event::{EventOpenError, EventOpenOrCreateError};
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeOpenError, PublishSubscribeOpenOrCreateError,
};
use iceoryx2::service::port_factory::{event, publish_subscribe};

use crate::service::{ServiceKind, camera_of, version_of};
use crate::{SCHEMA_VERSION, VERSION_ATTRIBUTE, VERSION_ATTRIBUTE_VALUE};

/// An opened publish-subscribe service of one message type.
pub type PublishSubscribe<T> = publish_subscribe::PortFactory<ipc::Service, T, ()>;

/// An opened event service.
pub type Events = event::PortFactory<ipc::Service>;

/// A service that another process is making or removing at this moment is tried this often.
const TRIES: u32 = 20;
const PAUSE_BETWEEN_TRIES: Duration = Duration::from_millis(10);

/// Qualities of a publish-subscribe service, fixed by whoever creates it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Qos {
    /// Messages that a consumer who joins late still gets.
    pub history: usize,
    /// Most consumers at a time.
    pub max_subscribers: usize,
    /// Most publishers at a time.
    pub max_publishers: usize,
    /// Messages one consumer may hold at a time.
    pub max_borrowed: usize,
}

/// Why a service could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// Nobody publishes it.
    #[error(
        "there is no service {name:?}: is the daemon running, with this camera, in this domain?"
    )]
    NotThere {
        /// The service's name.
        name: String,
    },
    /// It exists in another schema version only.
    #[error(
        "{camera:?} is published in schema version {found}, this program speaks version {ours}: use daemon and client of one release",
        ours = SCHEMA_VERSION
    )]
    OtherVersion {
        /// The camera.
        camera: String,
        /// The version found.
        found: u32,
    },
    /// It bears this version's name, but its type or version attribute differ.
    #[error(
        "service {name:?} claims schema version {ours} but its messages are laid out differently: use daemon and client of one release",
        ours = SCHEMA_VERSION
    )]
    OtherLayout {
        /// The service's name.
        name: String,
    },
    /// It exists with other qualities, kept alive by consumers of an earlier daemon.
    #[error(
        "service {name:?} exists with other settings ({what}), held by consumers of an earlier run: stop them, or keep the settings"
    )]
    OtherSettings {
        /// The service's name.
        name: String,
        /// What differs.
        what: String,
    },
    /// The files are another user's.
    #[error(
        "service {name:?} belongs to another user: run as that user, or share the domain with a group"
    )]
    NotAllowed {
        /// The service's name.
        name: String,
    },
    /// Anything else.
    #[error("cannot open service {name:?}: {what}")]
    Failed {
        /// The service's name.
        name: String,
        /// What iceoryx2 says.
        what: String,
    },
}

/// Whether a camera's service of some kind can be read by this program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Availability {
    /// The camera.
    pub camera: String,
    /// The schema version it is published in.
    pub version: u32,
}

/// Lists the cameras that have a service of this kind, whichever the schema version.
pub fn cameras(node: &Node<ipc::Service>, kind: ServiceKind) -> Vec<Availability> {
    let mut found = Vec::new();
    let listed = ipc::Service::list(node.config(), |details| {
        let name = details.static_details.name().as_str();
        if let (Some(camera), Some(version)) = (camera_of(name, kind), version_of(name)) {
            found.push(Availability { camera: camera.into(), version });
        }
        CallbackProgression::Continue
    });
    // A failed listing means there is no domain yet: nobody publishes.
    let _ = listed;
    found.sort_by(|a, b| a.camera.cmp(&b.camera).then(a.version.cmp(&b.version)));
    found
}

/// Opens or creates a service in order to publish.
///
/// # Errors
/// [`OpenError`]; a service that is just being made or removed is waited for, at most 0.2 s.
pub fn open_for_writing<T: Debug + ZeroCopySend + 'static>(
    node: &Node<ipc::Service>,
    kind: ServiceKind,
    camera: &str,
    qos: Qos,
) -> Result<PublishSubscribe<T>, OpenError> {
    let name = service_name(kind, camera)?;
    let open = || {
        node.service_builder(&name)
            .publish_subscribe::<T>()
            .enable_safe_overflow(true)
            .history_size(qos.history)
            .subscriber_max_buffer_size(qos.history.max(2))
            .subscriber_max_borrowed_samples(qos.max_borrowed)
            .max_subscribers(qos.max_subscribers)
            .max_publishers(qos.max_publishers)
            .max_nodes(qos.max_subscribers + qos.max_publishers + 2)
            .open_or_create_with_attributes(&our_version())
    };
    open_or_create(node, kind, camera, open)
}

/// Tries until a service is there, and says why if it is not.
pub(super) fn open_or_create<P>(
    node: &Node<ipc::Service>,
    kind: ServiceKind,
    camera: &str,
    open: impl Fn() -> Result<P, PublishSubscribeOpenOrCreateError>,
) -> Result<P, OpenError> {
    use PublishSubscribeOpenOrCreateError as E;
    let in_flux = |e: &E| match e {
        E::PublishSubscribeOpenError(e) => is_in_flux(*e),
        E::SystemInFlux | E::PublishSubscribeCreateError(_) => true,
    };
    retry(open, in_flux).map_err(|e| match e {
        E::PublishSubscribeOpenError(e) => explain(node, kind, camera, e),
        other => OpenError::Failed { name: kind.of(camera).to_string(), what: other.to_string() },
    })
}

/// Opens an existing service in order to subscribe.
///
/// # Errors
/// [`OpenError`]; a service that is just being made or removed is waited for, at most 0.2 s.
pub fn open_for_reading<T: Debug + ZeroCopySend + 'static>(
    node: &Node<ipc::Service>,
    kind: ServiceKind,
    camera: &str,
) -> Result<PublishSubscribe<T>, OpenError> {
    let name = service_name(kind, camera)?;
    let open = || {
        node.service_builder(&name).publish_subscribe::<T>().open_with_attributes(&our_version())
    };
    retry(open, |e| is_in_flux(*e)).map_err(|e| explain(node, kind, camera, e))
}

/// Opens or creates an event service in order to notify.
///
/// # Errors
/// [`OpenError`], as [`open_for_writing`].
pub fn open_event_for_writing(
    node: &Node<ipc::Service>,
    kind: ServiceKind,
    camera: &str,
    max_listeners: usize,
) -> Result<Events, OpenError> {
    let name = service_name(kind, camera)?;
    let open = || {
        node.service_builder(&name)
            .event()
            .max_listeners(max_listeners)
            .max_nodes(max_listeners + 4)
            .open_or_create_with_attributes(&our_version())
    };
    retry(open, |e| {
        !matches!(e, EventOpenOrCreateError::EventOpenError(EventOpenError::IncompatibleAttributes))
    })
    .map_err(|e| OpenError::Failed { name: name.to_string(), what: e.to_string() })
}

/// Opens an existing event service in order to listen.
///
/// # Errors
/// [`OpenError`], as [`open_for_reading`].
pub fn open_event_for_reading(
    node: &Node<ipc::Service>,
    kind: ServiceKind,
    camera: &str,
) -> Result<Events, OpenError> {
    let name = service_name(kind, camera)?;
    let open = || node.service_builder(&name).event().open_with_attributes(&our_version());
    let in_flux = |e: &EventOpenError| {
        matches!(
            e,
            EventOpenError::ServiceInCorruptedState | EventOpenError::IsMarkedForDestruction
        )
    };
    retry(open, in_flux).map_err(|e| match e {
        EventOpenError::DoesNotExist => OpenError::NotThere { name: name.to_string() },
        other => OpenError::Failed { name: name.to_string(), what: other.to_string() },
    })
}

pub(super) fn retry<T, E>(
    open: impl Fn() -> Result<T, E>,
    in_flux: impl Fn(&E) -> bool,
) -> Result<T, E> {
    for _ in 1..TRIES {
        match open() {
            Err(e) if in_flux(&e) => sleep(PAUSE_BETWEEN_TRIES),
            done => return done,
        }
    }
    open()
}

pub(super) fn is_in_flux(error: PublishSubscribeOpenError) -> bool {
    use PublishSubscribeOpenError as E;
    matches!(error, E::ServiceInCorruptedState | E::IsMarkedForDestruction | E::HangsInCreation)
}

pub(super) fn service_name(kind: ServiceKind, camera: &str) -> Result<ServiceName, OpenError> {
    let name = kind.of(camera).to_string();
    ServiceName::new(&name).map_err(|e| OpenError::Failed { name, what: e.to_string() })
}

pub(super) fn our_version() -> AttributeVerifier {
    let verifier = AttributeVerifier::new();
    let (Ok(key), Ok(value)) =
        (AttributeKey::try_from(VERSION_ATTRIBUTE), VERSION_ATTRIBUTE_VALUE.try_into())
    else {
        unreachable!("both are short literals")
    };
    verifier.clone().require(&key, &value).unwrap_or(verifier)
}

pub(super) fn explain(
    node: &Node<ipc::Service>,
    kind: ServiceKind,
    camera: &str,
    error: PublishSubscribeOpenError,
) -> OpenError {
    use PublishSubscribeOpenError as E;
    let name = kind.of(camera).to_string();
    match error {
        E::DoesNotExist => absent(node, kind, camera, name),
        E::IncompatibleTypes | E::IncompatibleAttributes | E::VersionMismatch => {
            OpenError::OtherLayout { name }
        }
        E::InsufficientPermissions => OpenError::NotAllowed { name },
        E::DoesNotSupportRequestedMinBufferSize
        | E::DoesNotSupportRequestedMinHistorySize
        | E::DoesNotSupportRequestedMinSubscriberBorrowedSamples
        | E::DoesNotSupportRequestedAmountOfSubscribers
        | E::DoesNotSupportRequestedAmountOfNodes => {
            OpenError::OtherSettings { name, what: error.to_string() }
        }
        other => OpenError::Failed { name, what: other.to_string() },
    }
}

/// A service that does not exist: perhaps it does in another version.
fn absent(node: &Node<ipc::Service>, kind: ServiceKind, camera: &str, name: String) -> OpenError {
    let other = cameras(node, kind)
        .into_iter()
        .find(|found| found.camera == camera && found.version != SCHEMA_VERSION);
    match other {
        Some(found) => OpenError::OtherVersion { camera: camera.into(), found: found.version },
        None => OpenError::NotThere { name },
    }
}
