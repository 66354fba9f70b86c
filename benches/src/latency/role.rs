//! What each process of the harness does. A process can enter one domain only, so the harness starts
//! itself again for every part.

mod consumer;
mod fan_out;
mod floor;
mod served;

use std::error::Error;
use std::path::PathBuf;
use std::time::Duration;

use clap::Subcommand;
use lodestone_client::Client;
use lodestone_daemon::cli::{Cli, Command, RunArgs};
use lodestone_daemon::commands::execute;
use lodestone_schema::transport::Domain;

use super::cores::{Side, become_real_time};
use super::peers::{self, Peer, Place};
use super::step_alone;

pub(super) use consumer::BREATH;
pub(super) use fan_out::figure as fan_out_figure;

/// One process's part.
#[derive(Debug, Subcommand)]
pub enum Role {
    /// `lodestoned run` for some seconds.
    Daemon {
        /// Its configuration.
        config: PathBuf,
        /// Seconds until it stops.
        seconds: f64,
        /// On all processors.
        #[arg(long)]
        anywhere: bool,
    },
    /// Takes the first camera's poses as soon as they are there.
    Poll(Watch),
    /// The same, and in turns with them what [`Role::Floor`] publishes.
    PollInTurns(Watch),
    /// Does a filter step and publishes by plain iceoryx2, midway between the first camera's samples.
    Floor(Watch),
    /// Takes them by `PoseStream::wait`.
    Wait(Watch),
    /// Sleeps until an event says that there is one.
    Event(Watch),
    /// Takes the poses of many cameras now and then, and counts what is lost on the way.
    Served {
        /// How many cameras.
        cameras: usize,
        /// Where and how long.
        #[command(flatten)]
        watch: Watch,
    },
    /// Publishes a peer's messages at 400 Hz.
    Publish {
        /// Which.
        #[arg(value_enum)]
        peer: Peer,
        /// Wakes who sleeps.
        #[arg(long)]
        wakes: bool,
        /// Where and how long.
        #[command(flatten)]
        watch: Watch,
    },
    /// Takes a peer's messages.
    Subscribe {
        /// Which.
        #[arg(value_enum)]
        peer: Peer,
        /// Sleeps until there is one, instead of polling.
        #[arg(long)]
        blocks: bool,
        /// Where and how long.
        #[command(flatten)]
        watch: Watch,
    },
    /// One filter step at 400 Hz.
    Step(Watch),
    /// Publishes poses in a tight loop to nobody and to 16 subscribers.
    FanOut(Watch),
}

/// Where to look and for how long.
#[derive(Clone, Debug, clap::Args)]
pub struct Watch {
    /// The domain's prefix.
    pub prefix: String,
    /// The domain's root.
    pub root: String,
    /// Seconds after the start of which nothing counts.
    pub settle_s: f64,
    /// Seconds that count.
    pub measure_s: f64,
}

impl Watch {
    /// The domain.
    pub fn domain(&self) -> Domain {
        Domain { prefix: self.prefix.clone(), root: self.root.clone() }
    }

    /// Where a peer's ends meet.
    pub fn place(&self) -> Place {
        Place { domain: self.domain() }
    }

    /// A client in the domain.
    ///
    /// # Errors
    /// If there is none to be had.
    pub fn client(&self) -> Result<Client, Box<dyn Error>> {
        Ok(Client::builder().prefix(&self.prefix).root(&self.root).connect()?)
    }
}

/// Plays a part to its end, with real-time priority if it is to have it and may.
///
/// # Errors
/// Whatever went wrong, for a person.
pub fn play(role: &Role, real_time: bool) -> Result<(), Box<dyn Error>> {
    role.side().enter()?;
    let _enrolled = (real_time && role.has_a_rhythm()).then(become_real_time);
    match role {
        Role::Daemon { config, seconds, .. } => daemon(config.clone(), *seconds),
        Role::Poll(watch) => consumer::poll(watch),
        Role::PollInTurns(watch) => consumer::poll_in_turns(watch),
        Role::Floor(watch) => floor::run(watch),
        Role::Wait(watch) => consumer::wait(watch),
        Role::Event(watch) => consumer::event(watch),
        Role::Served { cameras, watch } => served::run(watch, *cameras),
        Role::Publish { peer, wakes, watch } => peers::publish(*peer, watch, *wakes),
        Role::Subscribe { peer, blocks, watch } => peers::subscribe(*peer, watch, *blocks),
        Role::Step(watch) => step_alone::run(watch),
        Role::FanOut(watch) => fan_out::run(watch),
    }
}

impl Role {
    const fn side(&self) -> Side {
        match self {
            Self::Daemon { anywhere: true, .. } | Self::Served { .. } => Side::Both,
            Self::Daemon { .. }
            | Self::Publish { .. }
            | Self::Floor(_)
            | Self::Step(_)
            | Self::FanOut(_) => Side::Publisher,
            Self::Poll(_)
            | Self::PollInTurns(_)
            | Self::Wait(_)
            | Self::Event(_)
            | Self::Subscribe { .. } => Side::Consumer,
        }
    }

    /// Whether it sleeps between messages. What never does would be throttled with real-time priority, and
    /// the daemon gives its own threads what they need.
    const fn has_a_rhythm(&self) -> bool {
        !matches!(self, Self::Daemon { .. } | Self::FanOut(_) | Self::Served { .. })
    }
}

fn daemon(config: PathBuf, seconds: f64) -> Result<(), Box<dyn Error>> {
    let run = RunArgs { duration: Some(Duration::from_secs_f64(seconds)) };
    let log = Some("warn".to_owned());
    let command = Some(Command::Run(run));
    Ok(execute(&Cli { config: Some(config), log, with_parent: None, command })?)
}
