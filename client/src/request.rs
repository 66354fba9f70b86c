//! What a consumer may ask the daemon for.

use std::thread::sleep;
use std::time::{Duration, Instant};

use lodestone_schema::transport::open_for_reading;
use lodestone_schema::{Request, RequestKind, ServiceKind, WORLD_NAME, WorldState};

use crate::client::Client;
use crate::error::{ConnectError, StreamError};
use crate::time::monotonic_now_ns;
use crate::world::WorldInfo;

const BETWEEN_LOOKS: Duration = Duration::from_millis(20);

/// Why there is no new world.
#[derive(Debug, thiserror::Error)]
pub enum RequestError {
    /// There is nobody to ask.
    #[error(transparent)]
    Connect(#[from] ConnectError),
    /// The present world is not known, so a new one could not be told from it.
    #[error(transparent)]
    World(#[from] StreamError),
    /// The request could not be sent.
    #[error("the request cannot be sent: {0}")]
    Send(String),
    /// The daemon did not do it.
    #[error("the daemon has not defined the world anew within {waited_ms} ms: is it alive?")]
    TimedOut {
        /// How long was waited, ms.
        waited_ms: u128,
    },
}

impl Client {
    /// Has the daemon define the world anew, and waits until it has; gives the new world, which may still
    /// wait for a camera that is aligned.
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn reinitialise_world(&self, patience: Duration) -> Result<WorldInfo, RequestError> {
        let end = Instant::now() + patience;
        let mut stream = self.world();
        let before = until(end, || stream.latest())?;
        let node = self.node()?;
        let service = open_for_reading::<Request>(&node, ServiceKind::Request, WORLD_NAME)
            .map_err(ConnectError::from)?;
        let failed = |e: &dyn core::fmt::Display| RequestError::Send(e.to_string());
        let publisher = service.publisher_builder().create().map_err(|e| failed(&e))?;
        let request = Request {
            time_ns: monotonic_now_ns(),
            process_id: std::process::id(),
            kind: RequestKind::ReinitialiseWorld.code(),
            reserved: [0; 3],
        };
        publisher.send_copy(request).map_err(|e| failed(&e))?;
        // The port must live until the daemon has read the request.
        let is_new = |world: &WorldInfo| world.epoch() > before.epoch();
        let found = until(end, || stream.latest().ok().filter(is_new).ok_or(()));
        let waits = |world: &WorldInfo| {
            world.state() == WorldState::Waiting && world.message().time_ns > request.time_ns
        };
        found
            .or_else(|()| stream.latest().ok().filter(waits).ok_or(()))
            .map_err(|()| RequestError::TimedOut { waited_ms: patience.as_millis() })
    }
}

/// Looks again and again until there is something or the time is over.
fn until<T, E>(end: Instant, mut look: impl FnMut() -> Result<T, E>) -> Result<T, E> {
    loop {
        match look() {
            Err(_) if Instant::now() < end => sleep(BETWEEN_LOOKS),
            done => return done,
        }
    }
}
