//! iceoryx2 alone: publish-subscribe with safe overflow, and an event for those who sleep.

use std::error::Error;
use std::time::Duration;

use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher as Port;
use iceoryx2::port::subscriber::Subscriber as Queue;
use iceoryx2::prelude::{ServiceName, ipc};

use super::super::payload::Payload;
use super::{Place, Receiver, Sender};

/// Messages that a consumer may be behind.
const BUFFER: usize = 512;

pub(super) struct Publisher {
    port: Port<ipc::Service, Payload, ()>,
    notifier: Option<Notifier<ipc::Service>>,
}

impl Publisher {
    pub(super) fn open(place: &Place, wakes: bool) -> Result<Self, Box<dyn Error>> {
        let node = place.domain.open_node("bench-peer")?;
        let notifier = wakes.then(|| -> Result<_, Box<dyn Error>> {
            let event = node.service_builder(&wake_name()?).event().open_or_create()?;
            Ok(event.notifier_builder().create()?)
        });
        let notifier = notifier.transpose()?;
        // Last: once this service is there, the other is too.
        let service = node
            .service_builder(&name()?)
            .publish_subscribe::<Payload>()
            .enable_safe_overflow(true)
            .subscriber_max_buffer_size(BUFFER)
            .create()?;
        Ok(Self { port: service.publisher_builder().create()?, notifier })
    }
}

impl Sender for Publisher {
    fn send(&mut self, payload: &Payload) -> Result<(), Box<dyn Error>> {
        self.port.send_copy(*payload)?;
        if let Some(notifier) = &self.notifier {
            notifier.notify()?;
        }
        Ok(())
    }
}

pub(super) struct Subscriber {
    queue: Queue<ipc::Service, Payload, ()>,
    listener: Option<Listener<ipc::Service>>,
}

impl Subscriber {
    pub(super) fn open(place: &Place, blocks: bool) -> Result<Self, Box<dyn Error>> {
        let node = place.domain.open_node("bench-peer")?;
        let service = node.service_builder(&name()?).publish_subscribe::<Payload>().open()?;
        let listener = blocks.then(|| -> Result<_, Box<dyn Error>> {
            let event = node.service_builder(&wake_name()?).event().open()?;
            Ok(event.listener_builder().create()?)
        });
        Ok(Self { queue: service.subscriber_builder().create()?, listener: listener.transpose()? })
    }
}

impl Receiver for Subscriber {
    fn take(&mut self) -> Result<Option<(Payload, u64)>, Box<dyn Error>> {
        let mut newest = None;
        let mut count = 0;
        while let Some(sample) = self.queue.receive()? {
            (newest, count) = (Some(*sample), count + 1);
        }
        Ok(newest.map(|payload| (payload, count)))
    }

    fn sleep(&mut self, timeout: Duration) -> Result<(), Box<dyn Error>> {
        if let Some(listener) = &self.listener {
            listener.timed_wait(|_| {}, timeout)?;
        }
        Ok(())
    }
}

fn name() -> Result<ServiceName, Box<dyn Error>> {
    Ok(ServiceName::new("bench/peer")?)
}

fn wake_name() -> Result<ServiceName, Box<dyn Error>> {
    Ok(ServiceName::new("bench/peer/wake")?)
}
