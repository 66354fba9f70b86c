//! The messages of one service, each with how it follows the one before.

use std::sync::Arc;

use core::fmt;
use iceoryx2::port::subscriber::{Subscriber, SubscriberCreateError};
use iceoryx2::prelude::{ZeroCopySend, ipc};
use lodestone_schema::ServiceKind;
use lodestone_schema::transport::{PublishSubscribe, open_for_reading};

use crate::client::Client;
use crate::connection::{Connection, ReceivingPort, ServiceOf};
use crate::error::{ConnectError, MessageError};
use crate::message::Message;
use crate::track::{Arrival, Tracker};

/// Receives one kind of message of one camera.
pub(crate) struct Subscription<M: Message> {
    connection: Connection<Port<M::Raw>>,
    tracker: Tracker,
}

struct Port<R: fmt::Debug + ZeroCopySend + 'static> {
    subscriber: Subscriber<ipc::Service, R, ()>,
    /// The service stays in existence while this is held.
    _service: PublishSubscribe<R>,
}

impl<R: fmt::Debug + ZeroCopySend + 'static> ReceivingPort for Port<R> {
    fn open(client: &Client, service: &ServiceOf) -> Result<Self, ConnectError> {
        let opened = open_for_reading::<R>(&*client.node()?, service.kind, &service.camera)?;
        let created = opened.subscriber_builder().create();
        let subscriber = created.map_err(|error| not_subscribed(&service.camera, error))?;
        Ok(Self { subscriber, _service: opened })
    }

    fn has_waiting(&self) -> bool {
        self.subscriber.has_samples().unwrap_or(false)
    }
}

/// Why an open service takes no subscriber.
pub(crate) fn not_subscribed(camera: &str, error: SubscriberCreateError) -> ConnectError {
    let camera = camera.to_owned();
    match error {
        SubscriberCreateError::ExceedsMaxSupportedSubscribers => {
            ConnectError::TooManyConsumers { camera }
        }
        other => ConnectError::Transport { camera, what: other.to_string() },
    }
}

/// A message and how it follows the one before.
pub(crate) struct Received<M> {
    pub(crate) message: Result<M, MessageError>,
    pub(crate) restart: bool,
}

impl<M: Message> Subscription<M> {
    pub(crate) fn new(client: Client, camera: String) -> Self {
        Self::of_kind(client, camera, M::KIND)
    }

    /// The same message from another service that carries it.
    pub(crate) fn of_kind(client: Client, camera: String, kind: ServiceKind) -> Self {
        let service = ServiceOf { kind, camera, silence: M::SILENCE };
        Self { connection: Connection::new(client, service), tracker: Tracker::default() }
    }

    pub(crate) fn camera(&self) -> &str {
        self.connection.camera()
    }

    pub(crate) const fn tracker(&self) -> &Tracker {
        &self.tracker
    }

    /// Why there is no connection; `None` while there is one, or before the first attempt.
    pub(crate) fn error(&self) -> Option<Arc<ConnectError>> {
        self.connection.error()
    }

    /// The next message that waits, connecting first if need be; `None` if none waits.
    #[inline]
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
                tracing::warn!(camera = self.camera(), %error, "message refused");
            }
            return Some(Received { message, restart: arrival == Arrival::Restart });
        }
    }

    #[inline]
    fn receive(&mut self) -> Option<(M::Raw, u128)> {
        let tracker = &mut self.tracker;
        match self.connection.port(|| tracker.connected())?.subscriber.receive() {
            Ok(Some(sample)) => {
                let found = (*sample.payload(), sample.header().publisher_id().value());
                self.connection.heard();
                Some(found)
            }
            Ok(None) => None,
            Err(error) => {
                self.connection.failed(error.to_string());
                None
            }
        }
    }
}

impl<M: Message> fmt::Debug for Subscription<M> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Subscription")
            .field("connection", &self.connection)
            .field("tracker", &self.tracker)
            .finish()
    }
}
