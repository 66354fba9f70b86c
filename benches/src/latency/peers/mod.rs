//! The peers: transports that carry the same number of bytes at the same rate, and nothing else.

mod datagram;
mod iceoryx;
mod lock;
#[cfg(feature = "zenoh")]
mod zenoh;

use std::error::Error;
use std::path::PathBuf;
use std::thread::sleep;
use std::time::{Duration, Instant};

use clap::ValueEnum;
use lodestone_client::latency::{Counted, Gap, Sighting, Stamps};
use lodestone_client::monotonic_now_ns;
use lodestone_schema::transport::Domain;
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec};

use super::cpu_time;
use super::payload::{Payload, payload, published_ns, sequence};
use super::role::{BREATH, Watch};
use super::told::Told;

/// 400 messages a second.
const STEP_NS: i64 = 2_500_000;
const SECOND_NS: i64 = 1_000_000_000;
/// What keeps a polling consumer from looking for longer is a gap.
pub const GAP_THRESHOLD_NS: i64 = 50_000;
/// Longest wait for the other side's service.
const PATIENCE: Duration = Duration::from_secs(5);

/// A transport.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Peer {
    /// iceoryx2 publish-subscribe: what Lodestone stands on.
    Iceoryx2,
    /// A sequence lock in shared memory: what the hardware allows.
    Seqlock,
    /// A Unix datagram socket.
    Datagram,
    /// zenoh over TCP on this host.
    #[cfg(feature = "zenoh")]
    ZenohTcp,
    /// zenoh over shared memory.
    #[cfg(feature = "zenoh")]
    ZenohShm,
}

impl Peer {
    /// What a person calls it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Iceoryx2 => "plain iceoryx2",
            Self::Seqlock => "seqlock in shared memory",
            Self::Datagram => "Unix datagram",
            #[cfg(feature = "zenoh")]
            Self::ZenohTcp => "zenoh over TCP",
            #[cfg(feature = "zenoh")]
            Self::ZenohShm => "zenoh over shared memory",
        }
    }

    fn sender(self, place: &Place, wakes: bool) -> Result<Box<dyn Sender>, Box<dyn Error>> {
        Ok(match self {
            Self::Iceoryx2 => Box::new(iceoryx::Publisher::open(place, wakes)?),
            Self::Seqlock => Box::new(lock::Writer::open(place, wakes)?),
            Self::Datagram => Box::new(datagram::Sender::open(place)?),
            #[cfg(feature = "zenoh")]
            Self::ZenohTcp => Box::new(zenoh::Publisher::open(place, false)?),
            #[cfg(feature = "zenoh")]
            Self::ZenohShm => Box::new(zenoh::Publisher::open(place, true)?),
        })
    }

    fn receiver(self, place: &Place, blocks: bool) -> Result<Box<dyn Receiver>, Box<dyn Error>> {
        Ok(match self {
            Self::Iceoryx2 => Box::new(iceoryx::Subscriber::open(place, blocks)?),
            Self::Seqlock => Box::new(lock::Reader::open(place)?),
            Self::Datagram => Box::new(datagram::Receiver::open(place)?),
            #[cfg(feature = "zenoh")]
            Self::ZenohTcp => Box::new(zenoh::Subscriber::open(place, false)?),
            #[cfg(feature = "zenoh")]
            Self::ZenohShm => Box::new(zenoh::Subscriber::open(place, true)?),
        })
    }
}

/// Where both ends of a peer meet.
#[derive(Clone, Debug)]
pub struct Place {
    /// The domain of the transports that have one.
    pub domain: Domain,
}

impl Place {
    /// A file of the peer's own in shared memory.
    fn file(&self, name: &str) -> PathBuf {
        PathBuf::from(format!("/dev/shm/{}{name}", self.domain.prefix))
    }

    /// A file beside the domain's.
    fn socket(&self, name: &str) -> PathBuf {
        PathBuf::from(&self.domain.root).join(name)
    }
}

/// The publishing end.
trait Sender {
    /// Hands one message to the transport.
    fn send(&mut self, payload: &Payload) -> Result<(), Box<dyn Error>>;
}

/// The consuming end.
trait Receiver {
    /// Takes what waits; gives the newest and how many there were. Never waits.
    fn take(&mut self) -> Result<Option<(Payload, u64)>, Box<dyn Error>>;

    /// Sleeps until a message may be there, or the time is over.
    fn sleep(&mut self, timeout: Duration) -> Result<(), Box<dyn Error>>;
}

/// Publishes a message every 2.5 ms; the stamp is taken just before it is handed over.
///
/// # Errors
/// Whatever the transport says.
pub fn publish(peer: Peer, watch: &Watch, wakes: bool) -> Result<(), Box<dyn Error>> {
    let mut sender = peer.sender(&watch.place(), wakes)?;
    let (begin, mut due_ns) = (Instant::now(), monotonic_now_ns());
    let end = Duration::from_secs_f64(watch.settle_s + watch.measure_s);
    for sequence in 1.. {
        due_ns += STEP_NS;
        let due = Timespec { tv_sec: due_ns / SECOND_NS, tv_nsec: due_ns % SECOND_NS };
        clock_nanosleep_absolute(ClockId::Monotonic, &due)?;
        if begin.elapsed() > end {
            break;
        }
        sender.send(&payload(sequence, monotonic_now_ns()))?;
    }
    Ok(())
}

/// Takes a peer's messages, by polling without pause or by sleeping until they come.
///
/// # Errors
/// Whatever the transport says.
pub fn subscribe(peer: Peer, watch: &Watch, blocks: bool) -> Result<(), Box<dyn Error>> {
    let mut receiver = patiently(|| peer.receiver(&watch.place(), blocks))?;
    let begin_ns = monotonic_now_ns() + (watch.settle_s * 1e9) as i64;
    let end_ns = begin_ns + (watch.measure_s * 1e9) as i64;
    let mut consumer = Consumer { told: Told::of(1), begin_ns, last: None, last_empty_ns: None };
    let (mut cpu_ns, mut settled) = (0, false);
    let mut now_ns = monotonic_now_ns();
    while now_ns < end_ns {
        if blocks {
            receiver.sleep(Duration::from_millis(50))?;
        } else {
            consumer.note_gap(now_ns);
        }
        let taken = receiver.take()?;
        consumer.last_empty_ns = taken.is_none().then_some(now_ns);
        if let Some((newest, count)) = taken {
            consumer.see(&newest, count, monotonic_now_ns());
            if !blocks {
                sleep(BREATH);
            }
        }
        now_ns = monotonic_now_ns();
        if !settled && now_ns >= begin_ns {
            (cpu_ns, settled) = (cpu_time::of_process(std::process::id()), true);
        }
    }
    consumer.told.cpu_ns = cpu_time::of_process(std::process::id()) - cpu_ns;
    consumer.told.measured_ns = (now_ns - begin_ns).cast_unsigned();
    consumer.told.tell()
}

/// What a peer's consumer keeps.
struct Consumer {
    told: Told,
    begin_ns: i64,
    last: Option<u64>,
    last_empty_ns: Option<i64>,
}

impl Consumer {
    fn see(&mut self, newest: &Payload, count: u64, seen_ns: i64) {
        let (published_ns, sequence) = (published_ns(newest), sequence(newest));
        let missed =
            self.last.replace(sequence).map_or(0, |last| (sequence - last).saturating_sub(count));
        if published_ns < self.begin_ns {
            self.told.leave_out(0, &Counted { warm_up: count, ..Counted::default() });
            return;
        }
        self.told.leave_out(0, &Counted { lost: missed, ..Counted::default() });
        let stamps = Stamps {
            arrival_ns: published_ns,
            ring_ns: published_ns,
            step_start_ns: published_ns,
            step_end_ns: published_ns,
            published_ns,
            seen_ns,
        };
        self.told.see(0, &Sighting { stamps, in_one_look: count });
    }

    fn note_gap(&mut self, now_ns: i64) {
        let gap = self.last_empty_ns.map(|begin_ns| Gap { begin_ns, end_ns: now_ns });
        if let Some(gap) = gap.filter(|g| g.span_ns() > GAP_THRESHOLD_NS && now_ns > self.begin_ns)
        {
            self.told.note_gap(gap);
        }
    }
}

/// Tries until the other side is there.
fn patiently<T>(
    mut attempt: impl FnMut() -> Result<T, Box<dyn Error>>,
) -> Result<T, Box<dyn Error>> {
    let begin = Instant::now();
    loop {
        match attempt() {
            Err(_) if begin.elapsed() < PATIENCE => sleep(Duration::from_millis(10)),
            done => return done,
        }
    }
}
