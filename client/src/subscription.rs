//! A subscriber that finds its service, and finds it again.

use std::sync::Arc;

use core::fmt;
use iceoryx2::port::subscriber::{Subscriber, SubscriberCreateError};
use iceoryx2::prelude::ipc;
use lodestone_schema::transport::{PublishSubscribe, open_for_reading};

use crate::client::Client;
use crate::error::{ConnectError, MessageError};
use crate::message::Message;
use crate::time::{age_of, monotonic_now_ns};
use crate::track::{Arrival, Tracker};

/// A missing service is looked for this often: a look reads a directory.
const BETWEEN_ATTEMPTS_NS: i64 = 100_000_000;

/// Receives one kind of message of one camera.
pub(crate) struct Subscription<M: Message> {
    client: Client,
    camera: String,
    link: Link<M::Raw>,
    /// When a message last came or the service was last opened.
    last_sign_ns: i64,
    tracker: Tracker,
}

enum Link<R: fmt::Debug + iceoryx2::prelude::ZeroCopySend + 'static> {
    /// Never tried.
    New,
    /// Tried in vain; again at this time.
    Down { error: Arc<ConnectError>, next_attempt_ns: i64 },
    /// Open. The service stays in existence while this is held.
    Up { subscriber: Subscriber<ipc::Service, R, ()>, _service: PublishSubscribe<R> },
}

/// A message and how it follows the one before.
pub(crate) struct Received<M> {
    pub(crate) message: Result<M, MessageError>,
    pub(crate) restart: bool,
}

impl<M: Message> Subscription<M> {
    pub(crate) fn new(client: Client, camera: String) -> Self {
        Self { client, camera, link: Link::New, last_sign_ns: 0, tracker: Tracker::default() }
    }

    pub(crate) fn camera(&self) -> &str {
        &self.camera
    }

    pub(crate) const fn tracker(&self) -> &Tracker {
        &self.tracker
    }

    /// Why there is no connection; `None` while there is one, or before the first attempt.
    pub(crate) fn error(&self) -> Option<Arc<ConnectError>> {
        match &self.link {
            Link::Down { error, .. } => Some(Arc::clone(error)),
            Link::New | Link::Up { .. } => None,
        }
    }

    /// The next message that waits, connecting first if need be; `None` if none waits.
    pub(crate) fn next(&mut self) -> Option<Received<M>> {
        loop {
            let (raw, publisher) = self.receive()?;
            let arrival = self.tracker.observe(publisher, M::sequence(&raw), M::time_ns(&raw));
            if arrival == Arrival::Again {
                continue;
            }
            let message = M::try_from(raw);
            if let Err(error) = &message {
                self.tracker.counts.invalid += 1;
                tracing::warn!(camera = self.camera, %error, "message refused");
            }
            return Some(Received { message, restart: arrival == Arrival::Restart });
        }
    }

    fn receive(&mut self) -> Option<(M::Raw, u128)> {
        self.connect_if_due();
        let Link::Up { subscriber, .. } = &self.link else {
            return None;
        };
        match subscriber.receive() {
            Ok(Some(sample)) => {
                let found = (*sample.payload(), sample.header().publisher_id().value());
                self.last_sign_ns = monotonic_now_ns();
                Some(found)
            }
            Ok(None) => None,
            Err(error) => {
                let (camera, what) = (self.camera.clone(), error.to_string());
                self.down(ConnectError::Transport { camera, what });
                None
            }
        }
    }

    /// Opens the service if that was not tried lately, and anew after a long silence: whoever
    /// cleans up after a killed daemon may have replaced it by another of the same name.
    fn connect_if_due(&mut self) {
        let now_ns = monotonic_now_ns();
        let due = match &self.link {
            Link::New => true,
            Link::Down { next_attempt_ns, .. } => now_ns >= *next_attempt_ns,
            Link::Up { subscriber, .. } => {
                age_of(self.last_sign_ns) > M::SILENCE && !subscriber.has_samples().unwrap_or(false)
            }
        };
        if due {
            self.connect();
        }
    }

    fn connect(&mut self) {
        // Given up first: if nobody else holds the old service, it goes, and a daemon with other
        // settings can make its own.
        self.link = Link::New;
        self.last_sign_ns = monotonic_now_ns();
        match self.open() {
            Ok(link) => {
                self.link = link;
                self.tracker.connected();
            }
            Err(error) => self.down(error),
        }
    }

    fn open(&self) -> Result<Link<M::Raw>, ConnectError> {
        let node = self.client.node()?;
        let service = open_for_reading::<M::Raw>(&node, M::KIND, &self.camera)?;
        let created = service.subscriber_builder().create();
        let subscriber = created.map_err(|error| {
            let camera = self.camera.clone();
            match error {
                SubscriberCreateError::ExceedsMaxSupportedSubscribers => {
                    ConnectError::TooManyConsumers { camera }
                }
                other => ConnectError::Transport { camera, what: other.to_string() },
            }
        })?;
        Ok(Link::Up { subscriber, _service: service })
    }

    fn down(&mut self, error: ConnectError) {
        let next_attempt_ns = monotonic_now_ns().saturating_add(BETWEEN_ATTEMPTS_NS);
        self.link = Link::Down { error: Arc::new(error), next_attempt_ns };
    }
}

impl<M: Message> fmt::Debug for Subscription<M> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Subscription")
            .field("camera", &self.camera)
            .field("connected", &matches!(self.link, Link::Up { .. }))
            .field("tracker", &self.tracker)
            .finish_non_exhaustive()
    }
}
