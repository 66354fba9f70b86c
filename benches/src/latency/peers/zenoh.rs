//! zenoh, peer to peer over TCP on this host, with payloads in its shared memory or in the stream.

use std::error::Error;
use std::fs;
use std::net::TcpListener;
use std::time::Duration;

use zenoh::handlers::FifoChannelHandler;
use zenoh::pubsub::{Publisher as Port, Subscriber as Queue};
use zenoh::sample::Sample;
use zenoh::shm::{GarbageCollect, PosixShmProviderBackend, ShmProvider, ShmProviderBuilder};
use zenoh::{Config, Session, Wait};

use super::super::payload::{Payload, from_bytes, to_bytes};
use super::{Place, Receiver, Sender};

const KEY: &str = "bench/peer";
/// Where the publisher leaves the port that it listens on.
const PORT_FILE: &str = "zenoh-port";
/// Room for some hundred messages.
const SHARED_BYTES: usize = 1 << 18;

pub(super) struct Publisher {
    port: Port<'static>,
    provider: Option<ShmProvider<PosixShmProviderBackend>>,
    // Closed after its port.
    _session: Session,
}

impl Publisher {
    pub(super) fn open(place: &Place, shared: bool) -> Result<Self, Box<dyn Error>> {
        // One that is free now: nobody else on this host takes any between.
        let number = TcpListener::bind("127.0.0.1:0")?.local_addr()?.port();
        let session = session("listen", number, shared)?;
        let port = session.declare_publisher(KEY).wait().map_err(text)?;
        let provider = shared.then(|| ShmProviderBuilder::default_backend(SHARED_BYTES).wait());
        let provider = provider.transpose().map_err(|e| e.to_string())?;
        fs::write(place.socket(PORT_FILE), number.to_string())?;
        Ok(Self { port, provider, _session: session })
    }
}

impl Sender for Publisher {
    fn send(&mut self, payload: &Payload) -> Result<(), Box<dyn Error>> {
        let bytes = to_bytes(payload);
        let Some(provider) = &self.provider else {
            return self.port.put(&bytes[..]).wait().map_err(text);
        };
        let loan = provider.alloc(bytes.len()).with_policy::<GarbageCollect>().wait();
        let mut loan = loan.map_err(|e| format!("{e:?}"))?;
        loan.as_mut().copy_from_slice(&bytes);
        self.port.put(loan).wait().map_err(text)
    }
}

pub(super) struct Subscriber {
    queue: Queue<FifoChannelHandler<Sample>>,
    /// What a sleep ended with.
    waiting: Option<Sample>,
    _session: Session,
}

impl Subscriber {
    pub(super) fn open(place: &Place, shared: bool) -> Result<Self, Box<dyn Error>> {
        let number = fs::read_to_string(place.socket(PORT_FILE))?.parse()?;
        let session = session("connect", number, shared)?;
        let queue = session.declare_subscriber(KEY).wait().map_err(text)?;
        Ok(Self { queue, waiting: None, _session: session })
    }
}

impl Receiver for Subscriber {
    fn take(&mut self) -> Result<Option<(Payload, u64)>, Box<dyn Error>> {
        let (mut newest, mut count) = (self.waiting.take(), 0);
        count += u64::from(newest.is_some());
        while let Some(sample) = self.queue.try_recv().map_err(text)? {
            (newest, count) = (Some(sample), count + 1);
        }
        let Some(sample) = newest else { return Ok(None) };
        let payload =
            from_bytes(&sample.payload().to_bytes()).ok_or("a message of another size")?;
        Ok(Some((payload, count)))
    }

    fn sleep(&mut self, timeout: Duration) -> Result<(), Box<dyn Error>> {
        self.waiting = self.queue.recv_timeout(timeout).map_err(text)?;
        Ok(())
    }
}

/// A session that knows its one peer and looks for no other.
fn session(end: &str, port: u16, shared: bool) -> Result<Session, Box<dyn Error>> {
    let mut config = Config::default();
    let endpoint = format!("[\"tcp/127.0.0.1:{port}\"]");
    // Only the publisher listens.
    let nothing = "[]".to_owned();
    let listen = if end == "listen" { &endpoint } else { &nothing };
    let connect = if end == "connect" { &endpoint } else { &nothing };
    for (key, value) in [
        ("listen/endpoints", listen.as_str()),
        ("connect/endpoints", connect),
        ("scouting/multicast/enabled", "false"),
        ("transport/shared_memory/enabled", if shared { "true" } else { "false" }),
    ] {
        config.insert_json5(key, value).map_err(text)?;
    }
    zenoh::open(config).wait().map_err(text)
}

fn text(error: impl std::fmt::Display) -> Box<dyn Error> {
    error.to_string().into()
}
