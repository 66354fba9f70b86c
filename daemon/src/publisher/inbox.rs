//! What other processes measure, received by the lane.

use iceoryx2::node::Node;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::ipc;
use lodestone_config::model::SharedMemory;
use lodestone_schema::transport::{Domain, PublishSubscribe, open_for_writing};
use lodestone_schema::{Aiding, ServiceKind};

use super::port::PublisherError;
use super::qos::qos_of;

/// Receives aiding messages of one lane; made on the lane's own thread, where it stays.
///
/// Receiving makes no system call and allocates nothing, except while a publisher joins or leaves.
pub struct AidingInbox {
    subscriber: Subscriber<ipc::Service, Aiding, ()>,
    /// Keeps the service in existence for publishers to find.
    _service: PublishSubscribe<Aiding>,
    _node: Node<ipc::Service>,
}

impl AidingInbox {
    /// Opens the service, so that publishers find it.
    ///
    /// # Errors
    /// [`PublisherError`].
    pub fn open(
        domain: &Domain,
        settings: &SharedMemory,
        camera: &str,
    ) -> Result<Self, PublisherError> {
        let node = domain.open_node(&format!("lodestoned-{camera}-aiding"))?;
        let kind = ServiceKind::Aiding;
        let service: PublishSubscribe<Aiding> =
            open_for_writing(&node, kind, camera, qos_of(kind, settings))?;
        let subscriber = service
            .subscriber_builder()
            .create()
            .map_err(|error| PublisherError::Inbox { what: error.to_string() })?;
        Ok(Self { subscriber, _service: service, _node: node })
    }

    /// The next message that waits; one that cannot be received is as good as none.
    pub fn next_message(&mut self) -> Option<Aiding> {
        let sample = self.subscriber.receive().ok().flatten()?;
        Some(*sample)
    }
}
