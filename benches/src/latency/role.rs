//! What each process of the harness does. A process can enter one domain only, so the harness
//! starts itself again for every part.

use std::error::Error;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Subcommand;
use lodestone_client::{Client, PoseStream, monotonic_now_ns};
use lodestone_daemon::cli::{Cli, Command, RunArgs};
use lodestone_daemon::commands::execute;
use lodestone_schema::transport::Domain;
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

use super::peer;
use super::stages::Stages;

/// Name of the harness's camera.
pub const CAMERA: &str = "bench";

/// One process's part.
#[derive(Debug, Subcommand)]
pub enum Role {
    /// `lodestoned run` for some seconds.
    Daemon {
        /// Its configuration.
        config: PathBuf,
        /// Seconds until it stops.
        seconds: f64,
    },
    /// Takes poses as soon as they are there, without ever sleeping.
    Poll(Watch),
    /// Takes poses by `PoseStream::wait`.
    Wait(Watch),
    /// Publishes poses by plain iceoryx2 at 400 Hz.
    PeerPublisher(Watch),
    /// Takes the peer's poses without ever sleeping.
    PeerSubscriber(Watch),
}

/// Where to look and for how long.
#[derive(Debug, clap::Args)]
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

    /// Takes poses by `next` for as long as is asked and writes the stages of those that count to
    /// the standard output. `next` gives a pose with the time at which it was seen.
    ///
    /// # Errors
    /// What `next` says.
    pub fn report(
        &self,
        mut next: impl FnMut() -> Result<Option<Stages>, Box<dyn Error>>,
    ) -> Result<(), Box<dyn Error>> {
        let begin = Instant::now();
        let settled = Duration::from_secs_f64(self.settle_s);
        let end = settled + Duration::from_secs_f64(self.measure_s);
        let mut seen = Vec::with_capacity((self.measure_s * 1000.0) as usize);
        while begin.elapsed() < end {
            if let Some(stages) = next()?
                && begin.elapsed() > settled
            {
                seen.push(stages);
            }
        }
        let lines: Vec<String> = seen.iter().map(ToString::to_string).collect();
        println!("{}", lines.join("\n"));
        Ok(())
    }
}

/// Plays a part to its end.
///
/// # Errors
/// Whatever went wrong, for a person.
pub fn play(role: &Role) -> Result<(), Box<dyn Error>> {
    let publishes = matches!(role, Role::Daemon { .. } | Role::PeerPublisher(_));
    keep_apart(publishes)?;
    match role {
        Role::Daemon { config, seconds } => daemon(config.clone(), *seconds),
        Role::Poll(watch) => poll(watch),
        Role::Wait(watch) => wait(watch),
        Role::PeerPublisher(watch) => peer::publish(watch),
        Role::PeerSubscriber(watch) => peer::subscribe(watch),
    }
}

/// The consumer has the last processor for itself, publishers all others: otherwise a publisher that
/// wakes up would push the polling consumer aside, and the scheduler would be measured.
fn keep_apart(publishes: bool) -> Result<(), Box<dyn Error>> {
    let allowed = sched_getaffinity(None)?;
    let mut processors: Vec<usize> =
        (0..CpuSet::MAX_CPU).filter(|cpu| allowed.is_set(*cpu)).collect();
    if processors.len() < 2 {
        return Ok(());
    }
    let last = processors.split_off(processors.len() - 1);
    let mut own = CpuSet::new();
    for cpu in if publishes { processors } else { last } {
        own.set(cpu);
    }
    Ok(sched_setaffinity(None, &own)?)
}

fn daemon(config: PathBuf, seconds: f64) -> Result<(), Box<dyn Error>> {
    let run = RunArgs { duration: Some(Duration::from_secs_f64(seconds)) };
    let log = Some("warn".to_owned());
    let command = Some(Command::Run(run));
    Ok(execute(&Cli { config: Some(config), log, with_parent: None, command })?)
}

fn poses(watch: &Watch) -> Result<PoseStream, Box<dyn Error>> {
    let client = Client::builder().prefix(&watch.prefix).root(&watch.root).connect()?;
    Ok(client.poses(CAMERA)?)
}

fn poll(watch: &Watch) -> Result<(), Box<dyn Error>> {
    let mut poses = poses(watch)?;
    watch.report(|| {
        // Of several at once only the newest was seen in time.
        let newest =
            poses.all().into_iter().last().map(|p| Stages::of(p.message(), monotonic_now_ns()));
        if newest.is_none() {
            std::hint::spin_loop();
        }
        Ok(newest)
    })
}

fn wait(watch: &Watch) -> Result<(), Box<dyn Error>> {
    let mut poses = poses(watch)?;
    watch.report(|| {
        // Before the daemon is up there is nothing to wait for.
        let newest = poses.wait(Duration::from_millis(100)).ok();
        Ok(newest.map(|p| Stages::of(p.message(), monotonic_now_ns())))
    })
}
