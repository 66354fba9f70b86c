//! One subject, once.

use std::error::Error;
use std::fs;
use std::thread::sleep;
use std::time::Duration;

use clap::ValueEnum;
use lodestone_client::latency::{CameraLatency, Gap, Sentinel, lane_threads};
use tempfile::NamedTempFile;

use super::configuration::Setup;
use super::cpu_time;
use super::part::{Part, Timing};
use super::peers::Peer;
use super::report::REAL_TIME;
use super::subject::{Kind, Subject};
use super::told::Told;
use crate::domain::OwnDomain;

/// Seconds from the start of a daemon until nothing of the start is left: alignment, prefaulting.
const START_S: f64 = 1.0;
/// Seconds for a consumer to join and learn the rhythm.
const JOIN_S: f64 = 0.5;
/// Seconds by which publishers outlive consumers.
const SPARE_S: f64 = 1.5;

/// What one subject showed in one round.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Who.
    pub subject: Subject,
    /// Of its consumer, where there is one.
    pub latency: Option<CameraLatency>,
    /// Other figures by name.
    pub figures: Vec<(String, f64)>,
}

/// Runs a subject.
///
/// # Errors
/// A part that could not be started, or failed.
pub fn run(
    subject: Subject,
    measure_s: f64,
    sentinel: Option<&Sentinel>,
) -> Result<Outcome, Box<dyn Error>> {
    // What was noted before belongs to others.
    let noted = || sentinel.map(Sentinel::take).unwrap_or_default();
    noted();
    let timing = Timing { settle_s: JOIN_S, measure_s };
    let told = match subject.kind() {
        Kind::Lane(setup, role) => lane(setup, role, timing)?,
        Kind::Peer { peer, blocks } => of_peer(peer, blocks, timing)?,
        Kind::Alone(role) => {
            let own = OwnDomain::new("alone")?;
            Part::watch(&[role], &own, timing)?.finish()?
        }
        Kind::ProcessorTime(setup) => processor_time(setup, timing)?,
        Kind::Served(setup) => served(setup, timing)?,
    };
    Ok(outcome(subject, &told, &noted()))
}

fn outcome(subject: Subject, told: &Told, gaps: &[Gap]) -> Outcome {
    let mut figures = told.figures.clone();
    if told.measured_ns > 0 {
        figures.push(("consumer's processor %".into(), percent(told.cpu_ns, told.measured_ns)));
    }
    Outcome { subject, latency: told.latencies(gaps).into_iter().next(), figures }
}

fn percent(part: u64, whole: u64) -> f64 {
    part as f64 / whole as f64 * 100.0
}

/// A daemon, with the file and the domain that go with it.
struct Daemon {
    part: Part,
    own: OwnDomain,
    _file: NamedTempFile,
}

impl Daemon {
    fn start(setup: Setup, seconds: f64, anywhere: bool) -> Result<Self, Box<dyn Error>> {
        let own = OwnDomain::new("lane")?;
        let file = tempfile::Builder::new().suffix(".toml").tempfile()?;
        fs::write(file.path(), setup.configuration(own.domain()))?;
        let path = file.path().to_string_lossy().into_owned();
        let seconds = seconds.to_string();
        let mut arguments = vec!["daemon", &path, &seconds];
        arguments.extend(anywhere.then_some("--anywhere"));
        Ok(Self { part: Part::start(&arguments)?, own, _file: file })
    }
}

fn lane(setup: Setup, role: &str, timing: Timing) -> Result<Told, Box<dyn Error>> {
    let seconds = START_S + timing.settle_s + timing.measure_s + SPARE_S;
    let mut daemon = Daemon::start(setup, seconds, false)?;
    sleep(Duration::from_secs_f64(START_S));
    let consumer = Part::watch(&[role], &daemon.own, timing)?;
    let real_time = lane_threads(daemon.part.pid()).iter().all(|lane| lane.real_time);
    let mut told = consumer.finish()?;
    told.figures.push((REAL_TIME.into(), f64::from(u8::from(real_time))));
    daemon.part.expect_success()?;
    Ok(told)
}

fn of_peer(peer: Peer, blocks: bool, timing: Timing) -> Result<Told, Box<dyn Error>> {
    let own = OwnDomain::new("peer")?;
    let value = peer.to_possible_value().ok_or("a peer without a name")?;
    let long = Timing { measure_s: timing.measure_s + SPARE_S, ..timing };
    let role = |name: &'static str, flag: &'static str| -> Vec<&str> {
        [name, value.get_name()].into_iter().chain(blocks.then_some(flag)).collect()
    };
    let mut publisher = Part::watch(&role("publish", "--wakes"), &own, long)?;
    let told = Part::watch(&role("subscribe", "--blocks"), &own, timing)?.finish()?;
    publisher.expect_success()?;
    Ok(told)
}

/// What the daemon uses, by its threads, while nobody looks on.
fn processor_time(setup: Setup, timing: Timing) -> Result<Told, Box<dyn Error>> {
    let settled_s = START_S + timing.settle_s;
    let mut daemon = Daemon::start(setup, settled_s + timing.measure_s + SPARE_S, false)?;
    sleep(Duration::from_secs_f64(settled_s));
    let begin = std::time::Instant::now();
    let before = cpu_time::by_thread(daemon.part.pid());
    sleep(Duration::from_secs_f64(timing.measure_s));
    let after = cpu_time::by_thread(daemon.part.pid());
    let elapsed_ns = begin.elapsed().as_nanos() as u64;
    daemon.part.expect_success()?;
    let used = |of: &[(String, u64)], lanes: bool| -> u64 {
        of.iter().filter(|(name, _)| name.starts_with("lane-") == lanes).map(|(_, ns)| ns).sum()
    };
    let lanes = used(&after, true) - used(&before, true);
    let rest = used(&after, false).saturating_sub(used(&before, false));
    let samples = 400.0 * setup.cameras as f64 * elapsed_ns as f64 * 1e-9;
    let mut told = Told::of(0);
    told.figures = vec![
        ("processor %".into(), percent(lanes + rest, elapsed_ns)),
        ("of which lanes %".into(), percent(lanes, elapsed_ns)),
        ("µs a sample".into(), (lanes + rest) as f64 * 1e-3 / samples),
    ];
    Ok(told)
}

fn served(setup: Setup, timing: Timing) -> Result<Told, Box<dyn Error>> {
    // So many cameras take longer to start, and health comes once a second.
    let settle_s = timing.settle_s + 2.0;
    let seconds = START_S + settle_s + timing.measure_s + 2.0 * SPARE_S + 3.0;
    let mut daemon = Daemon::start(setup, seconds, true)?;
    sleep(Duration::from_secs_f64(START_S));
    let cameras = setup.cameras.to_string();
    let timing = Timing { settle_s, ..timing };
    let told = Part::watch(&["served", &cameras], &daemon.own, timing)?.finish()?;
    daemon.part.expect_success()?;
    Ok(told)
}
