//! Wake-up events, raised off the lane: notifying listeners costs 13 to 43 µs.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::{self, JoinHandle};

use lodestone_schema::ServiceKind;
use lodestone_schema::transport::{Domain, open_event_for_writing};

use super::port::PublisherError;

/// A thread that sleeps until it is poked and then notifies every listener once, however many
/// pokes came meanwhile.
pub(super) struct Waker {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    poked: AtomicBool,
    stop: AtomicBool,
    errors: AtomicU64,
}

impl Waker {
    /// Starts the thread and waits until its service is open.
    pub(super) fn start(
        domain: &Domain,
        camera: &str,
        max_listeners: usize,
    ) -> Result<Self, PublisherError> {
        let shared = Arc::new(Shared::default());
        let (ready, opened) = sync_channel(1);
        let thread = {
            let (shared, domain, camera) = (Arc::clone(&shared), domain.clone(), camera.to_owned());
            thread::Builder::new()
                .name(format!("wake-{camera}"))
                .spawn(move || serve(&shared, &domain, &camera, max_listeners, &ready))
                .map_err(PublisherError::WakeThread)?
        };
        let waker = Self { shared, thread: Some(thread) };
        match opened.recv() {
            Ok(result) => result.map(|()| waker),
            Err(_) => {
                Err(PublisherError::WakeThread(std::io::Error::other("it ended while starting")))
            }
        }
    }

    /// Asks for a notification; never blocks.
    pub(super) fn poke(&self) {
        self.shared.poked.store(true, Ordering::Release);
        if let Some(thread) = &self.thread {
            thread.thread().unpark();
        }
    }

    /// Notifications that failed.
    pub(super) fn errors(&self) -> u64 {
        self.shared.errors.load(Ordering::Relaxed)
    }
}

impl Drop for Waker {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // It has nothing to say that its error counter has not said.
            let _ = thread.join();
        }
    }
}

type Ready = SyncSender<Result<(), PublisherError>>;

fn serve(shared: &Shared, domain: &Domain, camera: &str, max_listeners: usize, ready: &Ready) {
    let opened = domain.open_node(&format!("lodestoned-wake-{camera}")).map_err(Into::into);
    let opened = opened.and_then(|node| {
        let service = open_event_for_writing(&node, ServiceKind::Wake, camera, max_listeners)?;
        let notifier = service.notifier_builder().create().map_err(|e| PublisherError::Port {
            service: ServiceKind::Wake.of(camera).to_string(),
            what: e.to_string(),
        })?;
        Ok((notifier, service, node))
    });
    let notifier = match opened {
        Ok(notifier) => notifier,
        Err(e) => return drop(ready.send(Err(e))),
    };
    // The lane may have given up already; then `stop` is set.
    let _ = ready.send(Ok(()));
    while !shared.stop.load(Ordering::Acquire) {
        if shared.poked.swap(false, Ordering::Acquire) {
            if notifier.0.notify().is_err() {
                shared.errors.fetch_add(1, Ordering::Relaxed);
            }
        } else {
            thread::park();
        }
    }
}
