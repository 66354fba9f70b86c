//! What is measured.

use clap::ValueEnum;

use super::configuration::Setup;
use super::peers::Peer;

/// One thing that is measured in each round.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Subject {
    /// A polling consumer of a lane on one thread, the default.
    Lane,
    /// The same in turns with what it stands on, which runs between the lane's samples.
    InTurns,
    /// What it stands on: a filter step and plain iceoryx2, and nothing else.
    Floor,
    /// A lane on two threads, of which one wakes the other.
    LaneTwo,
    /// The same with a lane on two threads, of which one looks when a sample is due.
    LaneTimed,
    /// The same beside a second camera.
    SecondCamera,
    /// A consumer that sleeps until shortly before the next pose is due (`PoseStream::wait`).
    Wait,
    /// A consumer that an iceoryx2 event wakes.
    Event,
    /// One filter step.
    Step,
    /// Plain iceoryx2, polled.
    Iceoryx2,
    /// Plain iceoryx2 with an event.
    Iceoryx2Blocking,
    /// A sequence lock in shared memory, polled.
    Seqlock,
    /// A sequence lock with a futex.
    SeqlockBlocking,
    /// A Unix datagram socket, polled.
    Datagram,
    /// A Unix datagram socket that is slept on.
    DatagramBlocking,
    /// zenoh over TCP, polled.
    #[cfg(feature = "zenoh")]
    ZenohTcp,
    /// zenoh over TCP, slept on.
    #[cfg(feature = "zenoh")]
    ZenohTcpBlocking,
    /// zenoh over shared memory, polled.
    #[cfg(feature = "zenoh")]
    ZenohShm,
    /// zenoh over shared memory, slept on.
    #[cfg(feature = "zenoh")]
    ZenohShmBlocking,
    /// Publishing to 0, 1, 4 and 16 subscribers.
    FanOut,
    /// The processor time of 8 cameras.
    EightCameras,
    /// 64 cameras on all processors: is anything lost?
    SixtyFourCameras,
}

/// How a subject is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The daemon and one consumer, by its role.
    Lane(Setup, &'static str),
    /// A peer's two ends; the consumer sleeps or polls.
    Peer {
        /// Which.
        peer: Peer,
        /// The consumer sleeps.
        blocks: bool,
    },
    /// What ran beside another subject and was measured with it.
    Beside,
    /// A part on its own, by its role.
    Alone(&'static str),
    /// The daemon without consumers.
    ProcessorTime(Setup),
    /// The daemon and a consumer that counts.
    Served(Setup),
}

impl Kind {
    /// Whether samples' ways are timed; a sentinel would share the processor time of the others.
    pub fn has_ways(self) -> bool {
        matches!(self, Self::Lane(..) | Self::Peer { .. } | Self::Beside | Self::Alone("step"))
    }
}

impl Subject {
    /// How it is measured.
    pub const fn kind(self) -> Kind {
        let one = Setup::ONE;
        match self {
            Self::Lane => Kind::Lane(one, "poll"),
            Self::InTurns => Kind::Lane(one, "poll-in-turns"),
            Self::Floor => Kind::Beside,
            Self::LaneTwo => Kind::Lane(Setup { threads: "two", ..one }, "poll"),
            Self::LaneTimed => Kind::Lane(Setup { threads: "timed", ..one }, "poll"),
            Self::SecondCamera => Kind::Lane(Setup { cameras: 2, ..one }, "poll"),
            Self::Wait => Kind::Lane(one, "wait"),
            Self::Event => Kind::Lane(Setup { wake_events: true, ..one }, "event"),
            Self::Step => Kind::Alone("step"),
            Self::FanOut => Kind::Alone("fan-out"),
            Self::EightCameras => Kind::ProcessorTime(Setup { cameras: 8, ..one }),
            Self::SixtyFourCameras => Kind::Served(Setup { cameras: 64, ..one }),
            Self::Iceoryx2 => Kind::Peer { peer: Peer::Iceoryx2, blocks: false },
            Self::Iceoryx2Blocking => Kind::Peer { peer: Peer::Iceoryx2, blocks: true },
            Self::Seqlock => Kind::Peer { peer: Peer::Seqlock, blocks: false },
            Self::SeqlockBlocking => Kind::Peer { peer: Peer::Seqlock, blocks: true },
            Self::Datagram => Kind::Peer { peer: Peer::Datagram, blocks: false },
            Self::DatagramBlocking => Kind::Peer { peer: Peer::Datagram, blocks: true },
            #[cfg(feature = "zenoh")]
            Self::ZenohTcp => Kind::Peer { peer: Peer::ZenohTcp, blocks: false },
            #[cfg(feature = "zenoh")]
            Self::ZenohTcpBlocking => Kind::Peer { peer: Peer::ZenohTcp, blocks: true },
            #[cfg(feature = "zenoh")]
            Self::ZenohShm => Kind::Peer { peer: Peer::ZenohShm, blocks: false },
            #[cfg(feature = "zenoh")]
            Self::ZenohShmBlocking => Kind::Peer { peer: Peer::ZenohShm, blocks: true },
        }
    }

    /// What a table calls it.
    pub fn name(self) -> String {
        match self {
            Self::Lane => "Lodestone, lane on one thread".into(),
            Self::InTurns => "Lodestone, in turns with the floor".into(),
            Self::Floor => "the floor: filter step, plain iceoryx2".into(),
            Self::LaneTwo => "Lodestone, two threads, wake-up".into(),
            Self::LaneTimed => "Lodestone, two threads, timed".into(),
            Self::SecondCamera => "Lodestone, beside a second camera".into(),
            Self::Wait => "Lodestone, waiting until due".into(),
            Self::Event => "Lodestone, woken by an event".into(),
            Self::Step => "one filter step".into(),
            Self::FanOut => "publishing".into(),
            Self::EightCameras => "8 cameras".into(),
            Self::SixtyFourCameras => "64 cameras".into(),
            _ => match self.kind() {
                Kind::Peer { peer, blocks: true } => format!("{}, blocking", peer.name()),
                Kind::Peer { peer, .. } => peer.name().into(),
                _ => self.key(),
            },
        }
    }

    /// Its name on the command line.
    pub fn key(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// Whether its consumer polls and so shows the transport alone.
    pub fn polls(self) -> bool {
        matches!(
            self.kind(),
            Kind::Lane(_, "poll" | "poll-in-turns")
                | Kind::Beside
                | Kind::Peer { blocks: false, .. }
        )
    }
}
