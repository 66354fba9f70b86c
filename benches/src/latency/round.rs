//! One subject, once.

use std::error::Error;
use std::fs;
use std::thread::sleep;
use std::time::{Duration, Instant};

use clap::ValueEnum;
use lodestone_client::latency::{CameraLatency, GAP_THRESHOLD, Gap, Sentinel, lane_threads};
use tempfile::NamedTempFile;

use super::configuration::Setup;
use super::cores::Side;
use super::cpu_time;
use super::part::{Conditions, Part};
use super::peers::Peer;
use super::report::REAL_TIME;
use super::subject::{Kind, Subject};
use super::told::Told;
use crate::domain::OwnDomain;

/// Seconds until a consumer has joined, learnt the rhythm, and the filter is aligned.
const JOIN_S: f64 = 0.7;
/// Seconds until a daemon that nobody looks at has nothing of its start left.
const START_S: f64 = 2.0;
/// Seconds after which a daemon ends that nobody stopped.
const LONGEST_S: f64 = 60.0;

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
    (measure_s, real_time): (f64, bool),
) -> Result<Vec<Outcome>, Box<dyn Error>> {
    let sentinel = if subject.kind().has_ways() { sentinel()? } else { None };
    let conditions = Conditions { settle_s: JOIN_S, measure_s, real_time };
    let told = match subject.kind() {
        Kind::Lane(setup, role) => lane(setup, role, conditions)?,
        Kind::Peer { peer, blocks } => of_peer(peer, blocks, conditions)?,
        Kind::Beside => return Ok(Vec::new()),
        Kind::Alone(role) => {
            let own = OwnDomain::new("alone")?;
            Part::watch(&[role], &own, conditions)?.finish()?
        }
        Kind::ProcessorTime(setup) => processor_time(setup, conditions)?,
        Kind::Served(setup) => served(setup, conditions)?,
    };
    let gaps = sentinel.map(|sentinel| sentinel.take()).unwrap_or_default();
    let outcomes = outcomes(subject, &told, &gaps);
    let blind = |outcome: &Outcome| {
        outcome.latency.as_ref().is_some_and(|latency| latency.counted.measured == 0)
    };
    if outcomes.iter().any(blind) {
        return Err("its consumer saw nothing".into());
    }
    Ok(outcomes)
}

/// On the publisher's processor, if that is one and not the consumer's.
fn sentinel() -> Result<Option<Sentinel>, Box<dyn Error>> {
    let cpu = Side::Publisher.processor()?;
    Ok(cpu.map(|cpu| Sentinel::start(cpu, GAP_THRESHOLD)).transpose()?)
}

/// The subject's, and that of what ran beside it.
fn outcomes(subject: Subject, told: &Told, gaps: &[Gap]) -> Vec<Outcome> {
    let mut figures = told.figures.clone();
    if told.measured_ns > 0 {
        figures.push(("consumer's processor %".into(), percent(told.cpu_ns, told.measured_ns)));
    }
    let mut latencies = told.latencies(gaps).into_iter();
    let beside =
        |latency| Outcome { subject: Subject::Floor, latency: Some(latency), figures: Vec::new() };
    let own = Outcome { subject, latency: latencies.next(), figures };
    std::iter::once(own).chain(latencies.map(beside)).collect()
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
    fn start(setup: Setup, conditions: Conditions, anywhere: bool) -> Result<Self, Box<dyn Error>> {
        let own = OwnDomain::new("lane")?;
        let file = tempfile::Builder::new().suffix(".toml").tempfile()?;
        let text = setup.configuration(own.domain(), conditions.real_time);
        fs::write(file.path(), text)?;
        let path = file.path().to_string_lossy().into_owned();
        let seconds = (LONGEST_S + conditions.measure_s).to_string();
        let mut arguments = vec!["daemon", &path, &seconds];
        arguments.extend(anywhere.then_some("--anywhere"));
        Ok(Self { part: Part::start(&arguments)?, own, _file: file })
    }
}

fn lane(setup: Setup, role: &str, conditions: Conditions) -> Result<Told, Box<dyn Error>> {
    let mut daemon = Daemon::start(setup, conditions, false)?;
    let in_turns = role == "poll-in-turns";
    let floor = in_turns.then(|| Part::watch(&["floor"], &daemon.own, conditions.longer()));
    let consumer = Part::watch(&[role], &daemon.own, conditions)?;
    let mut told = consumer.finish()?;
    if let Some(floor) = floor {
        floor?.expect_success()?;
    }
    let lanes = lane_threads(daemon.part.pid());
    let real_time = !lanes.is_empty() && lanes.iter().all(|lane| lane.real_time);
    told.figures.push((REAL_TIME.into(), f64::from(u8::from(real_time))));
    daemon.part.stop()?;
    Ok(told)
}

fn of_peer(peer: Peer, blocks: bool, conditions: Conditions) -> Result<Told, Box<dyn Error>> {
    let own = OwnDomain::new("peer")?;
    let value = peer.to_possible_value().ok_or("a peer without a name")?;
    let long = conditions.longer();
    let role = |name: &'static str, flag: &'static str| -> Vec<&str> {
        [name, value.get_name()].into_iter().chain(blocks.then_some(flag)).collect()
    };
    let mut publisher = Part::watch(&role("publish", "--wakes"), &own, long)?;
    let told = Part::watch(&role("subscribe", "--blocks"), &own, conditions)?.finish()?;
    publisher.expect_success()?;
    Ok(told)
}

/// What the daemon uses, by its threads, while nobody looks on.
fn processor_time(setup: Setup, conditions: Conditions) -> Result<Told, Box<dyn Error>> {
    let mut daemon = Daemon::start(setup, conditions, false)?;
    sleep(Duration::from_secs_f64(START_S + conditions.settle_s));
    let begin = Instant::now();
    let before = cpu_time::by_thread(daemon.part.pid());
    sleep(Duration::from_secs_f64(conditions.measure_s));
    let after = cpu_time::by_thread(daemon.part.pid());
    let elapsed_ns = begin.elapsed().as_nanos() as u64;
    daemon.part.stop()?;
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

fn served(setup: Setup, conditions: Conditions) -> Result<Told, Box<dyn Error>> {
    let mut daemon = Daemon::start(setup, conditions, true)?;
    let cameras = setup.cameras.to_string();
    let told = Part::watch(&["served", &cameras], &daemon.own, conditions)?.finish()?;
    daemon.part.stop()?;
    Ok(told)
}
