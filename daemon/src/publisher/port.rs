//! One service and its publisher, with the next sample always loaned ahead.

use core::fmt::Debug;

use iceoryx2::node::Node;
use iceoryx2::port::publisher::{Publisher, PublisherCreateError};
use iceoryx2::prelude::{ZeroCopySend, ipc};
use iceoryx2::sample_mut::SampleMut;
use lodestone_config::model::SharedMemory;
use lodestone_schema::ServiceKind;
use lodestone_schema::transport::{
    DomainError, OpenError, PublishSubscribe, Qos, open_for_writing,
};

use super::qos::qos_of;
use crate::service::prefault::PrefaultError;

/// Why a publisher could not be made.
#[derive(Debug, thiserror::Error)]
pub enum PublisherError {
    /// The domain could not be entered.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// The service could not be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The port could not be made.
    #[error("cannot publish {service}: {what}")]
    Port {
        /// The service's name.
        service: String,
        /// What iceoryx2 says.
        what: String,
    },
    /// The lane could not listen to other processes.
    #[error("cannot receive aiding measurements: {what}")]
    Inbox {
        /// What iceoryx2 says.
        what: String,
    },
    /// The memory could not be reserved.
    #[error(transparent)]
    Prefault(#[from] PrefaultError),
    /// The thread that raises wake-up events could not be started.
    #[error("cannot start the thread that raises wake-up events: {0}")]
    WakeThread(std::io::Error),
}

/// A publisher of one message type.
pub(super) struct Port<T: Debug + ZeroCopySend + Copy + 'static> {
    // Declared, and so dropped, in this order: the loan before its publisher.
    loan: Option<SampleMut<ipc::Service, T, ()>>,
    publisher: Publisher<ipc::Service, T, ()>,
    // The service's file lives as long as somebody has it open.
    _service: PublishSubscribe<T>,
    blank: T,
    errors: u64,
}

impl<T: Debug + ZeroCopySend + Copy + 'static> Port<T> {
    /// Opens the service and loans the first sample; `blank` is any value of the type.
    pub(super) fn open(
        node: &Node<ipc::Service>,
        kind: ServiceKind,
        camera: &str,
        settings: &SharedMemory,
        blank: T,
    ) -> Result<Self, PublisherError> {
        let qos: Qos = qos_of(kind, settings);
        let service = open_for_writing::<T>(node, kind, camera, qos)?;
        let refused = |e: PublisherCreateError| PublisherError::Port {
            service: kind.of(camera).to_string(),
            what: explain(e),
        };
        // One sample is loaned ahead; a second one never exists.
        let publisher =
            service.publisher_builder().max_loaned_samples(1).create().map_err(refused)?;
        let mut port = Self { loan: None, publisher, _service: service, blank, errors: 0 };
        port.loan_ahead();
        Ok(port)
    }

    /// Copies a message into the loaned sample, lets `stamp` finish it in place, and sends it.
    ///
    /// Whatever fails is counted, and the lane goes on; `true` if the message went out.
    pub(super) fn send(&mut self, message: &T, stamp: impl FnOnce(&mut T)) -> bool {
        if self.loan.is_none() {
            self.loan_ahead();
        }
        let Some(mut sample) = self.loan.take() else { return false };
        let slot = sample.payload_mut();
        *slot = *message;
        stamp(slot);
        let sent = sample.send().is_ok();
        self.errors += u64::from(!sent);
        self.loan_ahead();
        sent
    }

    /// Messages that could not be loaned or sent.
    pub(super) const fn errors(&self) -> u64 {
        self.errors
    }

    fn loan_ahead(&mut self) {
        match self.publisher.loan_uninit() {
            // Writing brings the sample's lines into this core's cache before they matter.
            Ok(sample) => self.loan = Some(sample.write_payload(self.blank)),
            Err(_) => self.errors += 1,
        }
    }
}

fn explain(error: PublisherCreateError) -> String {
    match error {
        PublisherCreateError::ExceedsMaxSupportedPublishers => {
            "two publishers serve it already (is a bridge or another daemon running?)".into()
        }
        PublisherCreateError::UnableToCreateDataSegment => {
            "its memory could not be made (is /dev/shm full, or closed to this user?)".into()
        }
        other => other.to_string(),
    }
}
