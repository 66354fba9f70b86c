//! Rounds: each runs the lane on one thread, on two, and the peer, one after the other.

use std::error::Error;
use std::fs;
use std::process::{Child, Command, Stdio};

use super::role::CAMERA;
use super::stages::Stages;
use crate::domain::OwnDomain;

/// Seconds before anything counts: start, alignment, a consumer that joins.
const SETTLE_S: f64 = 1.0;
/// Seconds for a consumer to join and learn the rhythm.
const JOIN_S: f64 = 0.3;

/// Who is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// A polling consumer of a lane; `lane.threads` as given.
    Poll(&'static str),
    /// A consumer of a lane that waits; `lane.threads` as given.
    Wait(&'static str),
    /// A polling subscriber of plain iceoryx2.
    Peer,
}

/// What one consumer saw in one round.
#[derive(Clone, Debug)]
pub struct Seen {
    /// Who.
    pub subject: Subject,
    /// The stages of each pose.
    pub stages: Vec<Stages>,
}

/// Runs one round.
///
/// # Errors
/// A process that could not be started or failed.
pub fn round(measure_s: f64) -> Result<Vec<Seen>, Box<dyn Error>> {
    let mut seen = Vec::new();
    for threads in ["one", "two"] {
        seen.extend(lane(threads, measure_s)?);
    }
    seen.push(peer(measure_s)?);
    Ok(seen)
}

fn lane(threads: &'static str, measure_s: f64) -> Result<[Seen; 2], Box<dyn Error>> {
    let own = OwnDomain::new("lane")?;
    let file = tempfile::Builder::new().suffix(".toml").tempfile()?;
    fs::write(file.path(), configuration(&own, threads))?;
    let path = file.path().to_string_lossy();
    // The second consumer finds a lane that has settled, so it settles sooner.
    let seconds = SETTLE_S + JOIN_S + 2.0 * measure_s + 0.3;
    let mut daemon = Part::start(["daemon", &*path, &seconds.to_string()])?;
    let poll = Part::watch("poll", &own, SETTLE_S, measure_s)?.finish()?;
    let wait = Part::watch("wait", &own, JOIN_S, measure_s)?.finish()?;
    let seen = [
        Seen { subject: Subject::Poll(threads), stages: poll },
        Seen { subject: Subject::Wait(threads), stages: wait },
    ];
    daemon.expect_success()?;
    Ok(seen)
}

fn peer(measure_s: f64) -> Result<Seen, Box<dyn Error>> {
    let own = OwnDomain::new("peer")?;
    let mut publisher = Part::watch("peer-publisher", &own, JOIN_S, measure_s + 0.3)?;
    let stages = Part::watch("peer-subscriber", &own, JOIN_S, measure_s)?.finish()?;
    publisher.expect_success()?;
    Ok(Seen { subject: Subject::Peer, stages })
}

/// One camera, carried by hand after a rest in which it aligns.
fn configuration(own: &OwnDomain, threads: &str) -> String {
    let domain = own.domain();
    format!(
        "[shared_memory]\nprefix = {:?}\nroot = {:?}\n\
         [lane]\nthreads = {threads:?}\n\
         [estimator]\nalignment_rest_s = 0.2\n\
         [[camera]]\nname = {CAMERA:?}\ndriver = \"synthetic\"\n\
         [camera.synthetic]\ntrajectory = \"walk\"\nrest_s = 0.5\nseed = 1\n",
        domain.prefix, domain.root
    )
}

/// This program in a part of its own; killed if it is dropped before its end.
struct Part(Child);

impl Part {
    fn start<const N: usize>(arguments: [&str; N]) -> Result<Self, Box<dyn Error>> {
        let mut command = Command::new(std::env::current_exe()?);
        command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped());
        Ok(Self(command.spawn()?))
    }

    fn watch(
        role: &str,
        own: &OwnDomain,
        settle_s: f64,
        measure_s: f64,
    ) -> Result<Self, Box<dyn Error>> {
        let (settle, measure) = (settle_s.to_string(), measure_s.to_string());
        let domain = own.domain();
        Self::start([role, &domain.prefix, &domain.root, &settle, &measure])
    }

    /// What it wrote, once it has ended.
    fn finish(mut self) -> Result<Vec<Stages>, Box<dyn Error>> {
        let mut text = String::new();
        if let Some(output) = &mut self.0.stdout {
            std::io::Read::read_to_string(output, &mut text)?;
        }
        self.expect_success()?;
        let lines = text.lines().filter(|line| !line.is_empty());
        Ok(lines.map(str::parse).collect::<Result<Vec<Stages>, _>>()?)
    }

    fn expect_success(&mut self) -> Result<(), Box<dyn Error>> {
        let status = self.0.wait()?;
        if status.success() { Ok(()) } else { Err(format!("a part failed: {status}").into()) }
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        // One that has ended already is left in peace.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
