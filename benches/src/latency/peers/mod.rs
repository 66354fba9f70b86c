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
use lodestone_client::latency::{Counted, GAP_THRESHOLD, Gap, Sighting, Stamps};
use lodestone_client::monotonic_now_ns;
use lodestone_schema::transport::Domain;

use super::cpu_time;
use super::metronome::Metronome;
use super::payload::{Payload, payload, published_ns, sequence};
use super::role::{BREATH, Watch};
use super::told::Told;

/// What keeps a polling consumer from looking for longer is a gap.
pub const GAP_THRESHOLD_NS: i64 = GAP_THRESHOLD.as_nanos() as i64;
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

    pub(super) fn sender(
        self,
        place: &Place,
        wakes: bool,
    ) -> Result<Box<dyn Sender>, Box<dyn Error>> {
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
pub(super) trait Sender {
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
    let (begin, mut metronome) = (Instant::now(), Metronome::after(monotonic_now_ns()));
    let end = Duration::from_secs_f64(watch.settle_s + watch.measure_s);
    for sequence in 1.. {
        metronome.wait()?;
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
    let mut follower = Follower::joining(peer, &watch.place(), 0, blocks)?;
    let begin_ns = monotonic_now_ns() + (watch.settle_s * 1e9) as i64;
    let end_ns = begin_ns + (watch.measure_s * 1e9) as i64;
    let mut told = Told::of(1);
    let (mut cpu_ns, mut settled) = (0, false);
    let (mut now_ns, mut last_empty_ns) = (monotonic_now_ns(), None);
    while now_ns < end_ns {
        if blocks {
            follower.receiver.sleep(Duration::from_millis(50))?;
        } else if let Some(gap) = gap_since(last_empty_ns, now_ns, begin_ns) {
            told.note_gap(gap);
        }
        let came = follower.look(&mut told, begin_ns)?;
        last_empty_ns = (!came).then_some(now_ns);
        if came && !blocks {
            sleep(BREATH);
        }
        now_ns = monotonic_now_ns();
        if !settled && now_ns >= begin_ns {
            (cpu_ns, settled) = (cpu_time::of_process(std::process::id()), true);
        }
    }
    told.cpu_ns = cpu_time::of_process(std::process::id()) - cpu_ns;
    told.measured_ns = (now_ns - begin_ns).cast_unsigned();
    told.tell()
}

/// A peer's consuming end, and what it saw last.
pub struct Follower {
    receiver: Box<dyn Receiver>,
    /// The number of its stream in what is told.
    stream: usize,
    last: Option<u64>,
}

impl Follower {
    /// Joins once the other side is there, to poll.
    ///
    /// # Errors
    /// Whatever the transport says.
    pub fn join(peer: Peer, place: &Place, stream: usize) -> Result<Self, Box<dyn Error>> {
        Self::joining(peer, place, stream, false)
    }

    fn joining(
        peer: Peer,
        place: &Place,
        stream: usize,
        blocks: bool,
    ) -> Result<Self, Box<dyn Error>> {
        let receiver = patiently(|| peer.receiver(place, blocks))?;
        Ok(Self { receiver, stream, last: None })
    }

    /// Takes what waits and tells the newest, if it was published in the time that counts; whether there was
    /// something.
    ///
    /// # Errors
    /// Whatever the transport says.
    pub fn look(&mut self, told: &mut Told, begin_ns: i64) -> Result<bool, Box<dyn Error>> {
        let Some((newest, count)) = self.receiver.take()? else { return Ok(false) };
        self.see(told, begin_ns, &newest, count);
        Ok(true)
    }

    fn see(&mut self, told: &mut Told, begin_ns: i64, newest: &Payload, count: u64) {
        let seen_ns = monotonic_now_ns();
        let (published_ns, sequence) = (published_ns(newest), sequence(newest));
        let missed =
            self.last.replace(sequence).map_or(0, |last| (sequence - last).saturating_sub(count));
        if published_ns < begin_ns {
            told.leave_out(self.stream, &Counted { warm_up: count, ..Counted::default() });
            return;
        }
        told.leave_out(self.stream, &Counted { lost: missed, ..Counted::default() });
        let stamps = Stamps {
            arrival_ns: published_ns,
            ring_ns: published_ns,
            step_start_ns: published_ns,
            step_end_ns: published_ns,
            published_ns,
            seen_ns,
        };
        told.see(self.stream, &Sighting { stamps, in_one_look: count });
    }
}

/// The gap since the last look that found nothing, if it was one.
fn gap_since(last_empty_ns: Option<i64>, now_ns: i64, begin_ns: i64) -> Option<Gap> {
    let gap = Gap { begin_ns: last_empty_ns?, end_ns: now_ns };
    (gap.span_ns() > GAP_THRESHOLD_NS && now_ns > begin_ns).then_some(gap)
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
