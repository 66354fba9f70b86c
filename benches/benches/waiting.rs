//! What waiting for a pose costs, and how late it is: sleeping until it is due, beside being woken by
//! iceoryx2's event, beside polling.
//!
//! `cargo bench -p lodestone-benches --bench waiting [-- --rounds 5 --seconds 4]`
//!
//! Two publishers of 400 poses a second: `lodestoned` with wake-ups switched on, which raises them off
//! the lane, and a plain loop that notifies in line, so that its event is as early as an event can be. The
//! consumers are processes of their own, one after the other in each round; the processor time is what the
//! kernel charged the process for.
//!
//! On a machine with other work, all under real-time priority (a polling consumer then would be stopped
//! for 50 ms of every second):
//! `chrt -f 50 cargo bench -p lodestone-benches --bench waiting -- --no-poll`

use std::error::Error;
use std::fs;
use std::hint::spin_loop;
use std::path::PathBuf;
use std::process::{Child, Command as Process, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use clap::{Parser, Subcommand, ValueEnum};
use lodestone_benches::domain::OwnDomain;
use lodestone_benches::ledger::{median, quantile};
use lodestone_benches::message::empty_pose;
use lodestone_client::{Client, PoseStream, monotonic_now_ns};
use lodestone_config::model::SharedMemory;
use lodestone_daemon::cli::{Cli, Command, RunArgs};
use lodestone_daemon::commands::execute;
use lodestone_daemon::publisher::LanePublisher;
use lodestone_schema::ServiceKind;
use lodestone_schema::transport::{Domain, Events, open_event_for_reading, open_event_for_writing};
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec, clock_gettime};

const CAMERA: &str = "bench";
const STEP_NS: i64 = 2_500_000;
const SECOND_NS: i64 = 1_000_000_000;
/// Alignment, and a consumer that joins and learns the rhythm.
const SETTLE: Duration = Duration::from_millis(1500);
const PATIENCE: Duration = Duration::from_secs(5);

/// Measures how late a waiting consumer sees a pose and what it costs.
#[derive(Parser)]
struct Args {
    /// Rounds; each runs every publisher with every consumer once.
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    /// Seconds each consumer is measured in a round.
    #[arg(long, default_value_t = 4.0)]
    seconds: f64,
    /// Leave the polling consumer out.
    #[arg(long)]
    no_poll: bool,
    /// Given by `cargo bench`; without it (as in `cargo test`) nothing is measured.
    #[arg(long, hide = true)]
    bench: bool,
    /// Parts that the bench starts itself for.
    #[command(subcommand)]
    role: Option<Role>,
}

#[derive(Subcommand)]
enum Role {
    /// `lodestoned run`, until it is killed.
    Lane { config: PathBuf },
    /// Publishes and notifies in line, until it is killed.
    Inline { prefix: String, root: String },
    /// Takes poses for some seconds and tells what it saw.
    Consume { prefix: String, root: String, how: How, seconds: f64 },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum How {
    /// `PoseStream::wait`.
    Wait,
    /// A listener of the event service.
    Event,
    /// Without ever sleeping.
    Poll,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    Lane,
    Inline,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = Args::parse();
    if let Some(role) = args.role.take() {
        return play(role);
    }
    if !args.bench {
        println!("skipped: latencies are measured by cargo bench");
        return Ok(());
    }
    let mut seen = Vec::new();
    for round in 1..=args.rounds {
        eprintln!("round {round} of {}", args.rounds);
        for source in [Source::Lane, Source::Inline] {
            seen.extend(measure(source, &args)?);
        }
    }
    print(&seen);
    Ok(())
}

fn play(role: Role) -> Result<(), Box<dyn Error>> {
    match role {
        Role::Lane { config } => lane(config),
        Role::Inline { prefix, root } => inline(&Domain { prefix, root }),
        Role::Consume { prefix, root, how, seconds } => {
            consume(&Domain { prefix, root }, how, seconds)
        }
    }
}

// ---- publishers --------------------------------------------------------------------------------

fn lane(config: PathBuf) -> Result<(), Box<dyn Error>> {
    let (log, run) = (Some("warn".to_owned()), RunArgs::default());
    Ok(execute(&Cli { config: Some(config), log, command: Some(Command::Run(run)) })?)
}

fn inline(domain: &Domain) -> Result<(), Box<dyn Error>> {
    let mut publisher = LanePublisher::open(domain, &SharedMemory::default(), CAMERA)?;
    let node = domain.open_node("bench-notifier")?;
    let events = open_event_for_writing(&node, ServiceKind::Wake, CAMERA, 4)?;
    let notifier = events.notifier_builder().create()?;
    let (mut pose, mut due_ns) = (empty_pose(), monotonic_now_ns());
    loop {
        due_ns += STEP_NS;
        let due = Timespec { tv_sec: due_ns / SECOND_NS, tv_nsec: due_ns % SECOND_NS };
        clock_nanosleep_absolute(ClockId::Monotonic, &due)?;
        pose.time_ns = due_ns;
        publisher.publish_pose(&pose);
        notifier.notify()?;
        pose.sequence += 1;
    }
}

/// One camera that stands, with wake-ups.
fn configuration(domain: &Domain) -> String {
    format!(
        "[shared_memory]\nprefix = {:?}\nroot = {:?}\nwake_events = true\n\
         [estimator]\nalignment_rest_s = 0.2\n\
         [[camera]]\nname = {CAMERA:?}\ndriver = \"synthetic\"\n\
         [camera.synthetic]\ntrajectory = \"standing\"\nseed = 1\n",
        domain.prefix, domain.root
    )
}

// ---- consumers ---------------------------------------------------------------------------------

fn consume(domain: &Domain, how: How, seconds: f64) -> Result<(), Box<dyn Error>> {
    let client = Client::builder().prefix(&domain.prefix).root(&domain.root).connect()?;
    let mut poses = client.poses(CAMERA)?;
    poses.wait(PATIENCE)?;
    match how {
        How::Wait => watch(seconds, || wait(&mut poses)),
        How::Poll => watch(seconds, || poll(&mut poses)),
        How::Event => {
            let node = domain.open_node("bench-listener")?;
            let events: Events = open_event_for_reading(&node, ServiceKind::Wake, CAMERA)?;
            let listener = events.listener_builder().create()?;
            watch(seconds, || {
                listener.timed_wait(|_| {}, PATIENCE)?;
                poll(&mut poses)
            })
        }
    }
}

/// When the newest pose was published, if it is new.
type Published = Result<Option<i64>, Box<dyn Error>>;

fn wait(poses: &mut PoseStream) -> Published {
    Ok(Some(poses.wait(PATIENCE)?.message().published_time_ns))
}

fn poll(poses: &mut PoseStream) -> Published {
    let newest = poses.all().into_iter().last().map(|pose| pose.message().published_time_ns);
    if newest.is_none() {
        spin_loop();
    }
    Ok(newest)
}

/// Prints latencies, ns, after a line with the processor time per second.
fn watch(seconds: f64, mut next: impl FnMut() -> Published) -> Result<(), Box<dyn Error>> {
    let settled = Instant::now();
    while settled.elapsed() < SETTLE {
        next()?;
    }
    let mut latencies = Vec::with_capacity((seconds * 1000.0) as usize);
    let (begin, cpu_s) = (Instant::now(), process_time_s());
    while begin.elapsed().as_secs_f64() < seconds {
        if let Some(published_ns) = next()? {
            latencies.push(monotonic_now_ns() - published_ns);
        }
    }
    println!("{}", (process_time_s() - cpu_s) / begin.elapsed().as_secs_f64());
    latencies.iter().for_each(|latency_ns| println!("{latency_ns}"));
    Ok(())
}

fn process_time_s() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

// ---- the bench ---------------------------------------------------------------------------------

/// What one consumer saw in one round.
struct Seen {
    source: Source,
    how: How,
    /// Of a processor.
    load: f64,
    latencies_us: Vec<f64>,
}

/// A process of this program; killed when dropped.
struct Part(Child);

impl Part {
    fn start(arguments: &[&str]) -> Result<Self, Box<dyn Error>> {
        let mut command = Process::new(std::env::current_exe()?);
        Ok(Self(command.args(arguments).stdin(Stdio::null()).spawn()?))
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn measure(source: Source, args: &Args) -> Result<Vec<Seen>, Box<dyn Error>> {
    let own = OwnDomain::new("waiting")?;
    let domain = own.domain();
    let file = tempfile::Builder::new().suffix(".toml").tempfile()?;
    fs::write(file.path(), configuration(domain))?;
    let _publisher = match source {
        Source::Lane => Part::start(&["lane", &file.path().to_string_lossy()])?,
        Source::Inline => Part::start(&["inline", &domain.prefix, &domain.root])?,
    };
    // A consumer does not begin a domain.
    sleep(Duration::from_millis(500));
    let consumers = [How::Wait, How::Event, How::Poll].into_iter();
    let wanted = consumers.filter(|how| *how != How::Poll || !args.no_poll);
    wanted.map(|how| run(source, how, domain, args.seconds)).collect()
}

fn run(source: Source, how: How, domain: &Domain, seconds: f64) -> Result<Seen, Box<dyn Error>> {
    let name = how.to_possible_value().ok_or("a consumer without a name")?;
    let output = Process::new(std::env::current_exe()?)
        .args(["consume", &domain.prefix, &domain.root, name.get_name(), &seconds.to_string()])
        .stderr(Stdio::inherit())
        .output()?;
    if !output.status.success() {
        return Err(format!("consumer {name:?}: {}", output.status).into());
    }
    let text = String::from_utf8(output.stdout)?;
    let mut lines = text.lines();
    let load = lines.next().ok_or("a consumer that says nothing")?.parse()?;
    let latencies: Result<Vec<f64>, _> = lines.map(str::parse::<f64>).collect();
    let latencies_us = latencies?.iter().map(|ns| ns * 1e-3).collect();
    Ok(Seen { source, how, load, latencies_us })
}

fn print(seen: &[Seen]) {
    println!("medians over rounds [least, most]; latency: published -> seen");
    println!("publisher  consumer   poses  p50/us            p99/us             processor %");
    for source in [Source::Lane, Source::Inline] {
        for how in [How::Wait, How::Event, How::Poll] {
            let of: Vec<&Seen> =
                seen.iter().filter(|s| (s.source, s.how) == (source, how)).collect();
            if of.is_empty() {
                continue;
            }
            let poses: usize = of.iter().map(|s| s.latencies_us.len()).sum();
            let p = |part: f64| spread(of.iter().map(|s| quantile(&s.latencies_us, part)));
            let load = spread(of.iter().map(|s| 100.0 * s.load));
            let (source, how) = (format!("{source:?}"), format!("{how:?}"));
            println!("{source:<10} {how:<8} {poses:>7}  {:<17} {:<18} {load}", p(0.5), p(0.99));
        }
        let p50 = |how| {
            let of = seen.iter().filter(|s| (s.source, s.how) == (source, how));
            median(&of.map(|s| median(&s.latencies_us)).collect::<Vec<_>>())
        };
        println!("{source:?}: wait / event, p50: {:.2}", p50(How::Wait) / p50(How::Event));
    }
}

fn spread(values: impl Iterator<Item = f64>) -> String {
    let values: Vec<f64> = values.collect();
    let (least, most) = (quantile(&values, 0.0), quantile(&values, 1.0));
    format!("{:.1} [{least:.1}, {most:.1}]", median(&values))
}
