//! The services that a daemon has once: the world, relative poses, the tree of frames, and requests.

use iceoryx2::node::Node;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::ipc;
use lodestone_config::model::SharedMemory;
use lodestone_schema::transport::{PublishSubscribe, open_for_writing};
use lodestone_schema::{
    Relative, Request, RequestKind, ServiceKind, StaticTransform, WORLD_NAME, World,
};

use super::port::{Port, PublisherError};
use super::qos::qos_of;
use crate::world::{blank_relative, blank_transform, blank_world};

/// Publishes what belongs to no single camera.
pub struct WorldPublisher {
    world: Port<World>,
    relative: Port<Relative>,
    transforms: Port<StaticTransform>,
}

impl WorldPublisher {
    /// Opens the services on a node of the calling thread.
    ///
    /// # Errors
    /// [`PublisherError`].
    pub fn open(
        node: &Node<ipc::Service>,
        settings: &SharedMemory,
    ) -> Result<Self, PublisherError> {
        Ok(Self {
            world: Port::open(node, ServiceKind::World, WORLD_NAME, settings, blank_world())?,
            relative: Port::open(
                node,
                ServiceKind::Relative,
                WORLD_NAME,
                settings,
                blank_relative(),
            )?,
            transforms: Port::open(
                node,
                ServiceKind::Transforms,
                WORLD_NAME,
                settings,
                blank_transform(),
            )?,
        })
    }

    /// Publishes the world; a failure is counted.
    pub fn world(&mut self, world: &World) {
        self.world.send(world, |_| {});
    }

    /// Publishes the relative pose of a pair; a failure is counted.
    pub fn relative(&mut self, relative: &Relative) {
        self.relative.send(relative, |_| {});
    }

    /// Publishes an edge of the tree; a failure is counted.
    pub fn transform(&mut self, transform: &StaticTransform) {
        self.transforms.send(transform, |_| {});
    }

    /// Messages that could not be loaned or sent.
    pub const fn errors(&self) -> u64 {
        self.world.errors() + self.relative.errors() + self.transforms.errors()
    }
}

/// Receives what consumers ask for.
#[derive(Debug)]
pub struct Requests {
    subscriber: Subscriber<ipc::Service, Request, ()>,
    // The service's file lives as long as somebody has it open.
    _service: PublishSubscribe<Request>,
}

impl Requests {
    /// Opens the service on a node of the calling thread.
    ///
    /// # Errors
    /// [`PublisherError`].
    pub fn open(
        node: &Node<ipc::Service>,
        settings: &SharedMemory,
    ) -> Result<Self, PublisherError> {
        let qos = qos_of(ServiceKind::Request, settings);
        let service = open_for_writing::<Request>(node, ServiceKind::Request, WORLD_NAME, qos)?;
        let subscriber = service.subscriber_builder().create().map_err(|e| {
            let service = ServiceKind::Request.of(WORLD_NAME).to_string();
            PublisherError::Port { service, what: e.to_string() }
        })?;
        Ok(Self { subscriber, _service: service })
    }

    /// The next request that waits; what makes no sense is logged and passed over.
    pub fn next(&self) -> Option<RequestKind> {
        loop {
            let request = match self.subscriber.receive() {
                Ok(Some(sample)) => *sample.payload(),
                Ok(None) => return None,
                Err(error) => {
                    tracing::warn!("requests cannot be received: {error}");
                    return None;
                }
            };
            let Request { process_id, kind, .. } = request;
            if let Some(kind) = RequestKind::from_code(kind) {
                tracing::info!(process_id, "asked for: {kind:?}");
                return Some(kind);
            }
            tracing::warn!(process_id, kind, "an unknown request is passed over");
        }
    }
}
