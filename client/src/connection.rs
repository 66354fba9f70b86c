//! A port that finds its service, and finds it again.

use std::sync::Arc;

use core::fmt;
use core::time::Duration;

use crate::client::Client;
use crate::error::ConnectError;
use crate::time::coarse_now_ns;

/// A missing service is looked for this often: a look reads a directory.
const BETWEEN_ATTEMPTS_NS: i64 = 100_000_000;

/// The receiving end of a service, whatever it carries.
pub(crate) trait ReceivingPort: Sized {
    /// Opens the service and subscribes.
    fn open(client: &Client, service: &ServiceOf) -> Result<Self, ConnectError>;

    /// Whether something waits.
    fn has_waiting(&self) -> bool;
}

/// Which service of which camera, and how long its silence is nothing strange.
#[derive(Clone, Debug)]
pub(crate) struct ServiceOf {
    pub(crate) kind: lodestone_schema::ServiceKind,
    pub(crate) camera: String,
    /// After this long without a message the service is opened anew, in case it was replaced.
    pub(crate) silence: Duration,
}

/// Keeps a port open: tries again where there is no service, and opens it anew after a long silence.
pub(crate) struct Connection<P> {
    client: Client,
    service: ServiceOf,
    link: Link<P>,
    silence_ns: i64,
    /// When a message last came or the service was last opened, by [`coarse_now_ns`].
    last_sign_ns: i64,
}

enum Link<P> {
    /// Never tried.
    New,
    /// Tried in vain; again at this time.
    Down { error: Arc<ConnectError>, next_attempt_ns: i64 },
    /// Open.
    Up(P),
}

impl<P: ReceivingPort> Connection<P> {
    pub(crate) fn new(client: Client, service: ServiceOf) -> Self {
        let silence_ns = i64::try_from(service.silence.as_nanos()).unwrap_or(i64::MAX);
        Self { client, service, link: Link::New, silence_ns, last_sign_ns: 0 }
    }

    pub(crate) fn camera(&self) -> &str {
        &self.service.camera
    }

    pub(crate) const fn is_up(&self) -> bool {
        matches!(self.link, Link::Up(_))
    }

    /// Why there is no connection; `None` while there is one, or before the first attempt.
    pub(crate) fn error(&self) -> Option<Arc<ConnectError>> {
        match &self.link {
            Link::Down { error, .. } => Some(Arc::clone(error)),
            Link::New | Link::Up(_) => None,
        }
    }

    /// The open port, opened now if that is due; `on_open` is told when it was.
    pub(crate) fn port(&mut self, on_open: impl FnOnce()) -> Option<&P> {
        if self.is_due() && self.connect() {
            on_open();
        }
        match &self.link {
            Link::Up(port) => Some(port),
            Link::New | Link::Down { .. } => None,
        }
    }

    /// Something came.
    pub(crate) fn heard(&mut self) {
        self.last_sign_ns = coarse_now_ns();
    }

    /// The transport failed; it is tried again later.
    pub(crate) fn failed(&mut self, what: String) {
        self.down(ConnectError::Transport { camera: self.service.camera.clone(), what });
    }

    /// Whether the service was not tried lately, or has been silent for long: whoever cleans up after
    /// a killed publisher may have replaced it by another of the same name.
    fn is_due(&self) -> bool {
        match &self.link {
            Link::New => true,
            Link::Down { next_attempt_ns, .. } => coarse_now_ns() >= *next_attempt_ns,
            Link::Up(port) => {
                let silent_ns = coarse_now_ns().saturating_sub(self.last_sign_ns);
                silent_ns > self.silence_ns && !port.has_waiting()
            }
        }
    }

    fn connect(&mut self) -> bool {
        // Given up first: if nobody else holds the old service, it goes, and a publisher with other
        // settings can make its own.
        self.link = Link::New;
        self.heard();
        match P::open(&self.client, &self.service) {
            Ok(port) => self.link = Link::Up(port),
            Err(error) => self.down(error),
        }
        self.is_up()
    }

    fn down(&mut self, error: ConnectError) {
        let next_attempt_ns = coarse_now_ns().saturating_add(BETWEEN_ATTEMPTS_NS);
        self.link = Link::Down { error: Arc::new(error), next_attempt_ns };
    }
}

impl<P: ReceivingPort> fmt::Debug for Connection<P> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Connection")
            .field("service", &self.service)
            .field("connected", &self.is_up())
            .finish_non_exhaustive()
    }
}
