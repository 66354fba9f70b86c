//! The clouds of one camera, as they come.

use std::thread::sleep;
use std::time::Instant;

use core::time::Duration;

use iceoryx2::port::ReceiveError;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::ipc;
use iceoryx2::sample::Sample;
use lodestone_schema::transport::{Clouds, open_clouds_for_reading};
use lodestone_schema::{CloudHeader, CloudPoint, ServiceKind};

use super::header::CloudInfo;
use super::received::Cloud;
use crate::client::Client;
use crate::connection::{Connection, ReceivingPort, ServiceOf};
use crate::error::{ConnectError, StreamError};
use crate::subscription::not_subscribed;
use crate::track::{Arrival, Counts, Tracker};

/// A slow source gives a cloud in some seconds.
const SILENCE: Duration = Duration::from_secs(5);
/// A cloud is some tens of milliseconds apart from the next; a look costs less than a microsecond.
const BETWEEN_LOOKS: Duration = Duration::from_millis(1);

/// The clouds of one camera, oldest first, without a copy.
///
/// May be made before the source runs; connects by itself, and again after a restart of the source. Up to
/// four clouds wait in shared memory; whoever is slower loses the oldest and finds them in
/// [`Counts::lost`]. Stays on the thread that made it.
///
/// ```no_run
/// use std::time::Duration;
/// # let client = lodestone_client::Client::connect()?;
/// let mut clouds = client.clouds("front")?;
/// let cloud = clouds.wait(Duration::from_secs(1))?;
/// let with_depth = cloud.iter().filter(|point| point.position_m[2].is_finite()).count();
/// println!("{with_depth} of {} points at {} ns", cloud.len(), cloud.info().time_ns());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct CloudStream {
    connection: Connection<Port>,
    tracker: Tracker,
}

struct Port {
    subscriber: Subscriber<ipc::Service, [CloudPoint], CloudHeader>,
    /// The service stays in existence while this is held.
    _service: Clouds,
}

impl ReceivingPort for Port {
    fn open(client: &Client, service: &ServiceOf) -> Result<Self, ConnectError> {
        let opened = open_clouds_for_reading(&*client.node()?, &service.camera)?;
        let created = opened.subscriber_builder().create();
        let subscriber = created.map_err(|error| not_subscribed(&service.camera, error))?;
        Ok(Self { subscriber, _service: opened })
    }

    fn has_waiting(&self) -> bool {
        self.subscriber.has_samples().unwrap_or(false)
    }
}

impl CloudStream {
    pub(crate) fn new(client: Client, camera: String) -> Self {
        let service = ServiceOf { kind: ServiceKind::Cloud, camera, silence: SILENCE };
        Self { connection: Connection::new(client, service), tracker: Tracker::default() }
    }

    /// The camera.
    pub fn camera(&self) -> &str {
        self.connection.camera()
    }

    /// What this stream has seen.
    pub const fn counts(&self) -> Counts {
        self.tracker.counts
    }

    /// Why there is no connection; `None` while there is one, or before the first call.
    pub fn connection_error(&self) -> Option<std::sync::Arc<ConnectError>> {
        self.connection.error()
    }

    /// The next cloud that waits, `None` if none does; clouds whose header is not sound are counted, logged
    /// and passed over.
    ///
    /// Gives none either while two clouds are still held by the caller.
    #[allow(clippy::should_implement_trait, reason = "None now may be followed by a cloud later")]
    pub fn next(&mut self) -> Option<Cloud> {
        loop {
            let sample = self.receive()?;
            let header = *sample.user_header();
            let publisher = sample.header().publisher_id().value();
            let arrival = self.tracker.observe(publisher, header.sequence, header.time_ns);
            if arrival == Arrival::Again {
                continue;
            }
            match CloudInfo::check(&header, sample.payload().len()) {
                Ok(info) => return Some(Cloud::new(sample, info)),
                Err(error) => {
                    self.tracker.counts.invalid += 1;
                    tracing::warn!(camera = self.camera(), %error, "cloud refused");
                }
            }
        }
    }

    /// Waits for the next cloud.
    ///
    /// # Errors
    /// [`StreamError::TimedOut`], or [`StreamError::NotConnected`] if there is no connection when the time
    /// is over.
    pub fn wait(&mut self, timeout: Duration) -> Result<Cloud, StreamError> {
        let begin = Instant::now();
        loop {
            if let Some(cloud) = self.next() {
                return Ok(cloud);
            }
            let Some(left) = timeout.checked_sub(begin.elapsed()).filter(|d| !d.is_zero()) else {
                return Err(self.timed_out(timeout));
            };
            sleep(BETWEEN_LOOKS.min(left));
        }
    }

    fn receive(&mut self) -> Option<Sample<ipc::Service, [CloudPoint], CloudHeader>> {
        let tracker = &mut self.tracker;
        let received = self.connection.port(|| tracker.connected())?.subscriber.receive();
        match received {
            Ok(found) => {
                found.as_ref().inspect(|_| self.connection.heard());
                found
            }
            Err(ReceiveError::ExceedsMaxBorrows) => {
                tracing::warn!(camera = self.camera(), "two clouds are held: drop one first");
                None
            }
            Err(error) => {
                self.connection.failed(error.to_string());
                None
            }
        }
    }

    fn timed_out(&self, timeout: Duration) -> StreamError {
        match self.connection.error() {
            Some(error) => StreamError::NotConnected(error),
            None => StreamError::TimedOut {
                camera: self.camera().into(),
                waited_ms: timeout.as_millis(),
            },
        }
    }
}
