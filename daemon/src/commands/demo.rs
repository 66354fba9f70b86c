//! `lodestoned demo`: do the clouds of two cameras lie on each other?

use std::fs;
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::ChildStdout;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use lodestone_client::{PREFIX_VARIABLE, ROOT_VARIABLE};
use lodestone_config::ConfigErrors;
use lodestone_config::model::Config;

use crate::cli::{DemoArgs, DemoConsumerArgs};
use crate::demo::calibration::{CalibrationError, Expected, calibrate_all};
use crate::demo::children::{ChildError, Children};
use crate::demo::cloud_file::ReadError;
use crate::demo::consumer::{ConsumerError, REPORT, Times, consume};
use crate::demo::event::Event;
use crate::demo::memory::OwnMemory;
use crate::demo::outcome::{Outcome, clouds};
use crate::demo::progress::Progress;
use crate::demo::result::{Seen, Variant};
use crate::demo::setup::{CAMERAS, drawn};
use crate::demo::{sheet, table};
use crate::evaluation::recording::RecordingError;
use crate::picture::write_png;
use crate::service::signals::StopFlag;

/// Filters have settled by then: their heading moves by less than a tenth of its σ after it.
const SETTLE: Duration = Duration::from_secs(3);
/// Between two looks at processes and signals.
const LOOK: Duration = Duration::from_millis(50);

const CONFIG: &str = "demo.toml";
const PICTURE: &str = "clouds.png";
const NUMBERS: &str = "demo.json";

/// Why there is no demo.
#[derive(Debug, thiserror::Error)]
pub enum DemoError {
    /// `--config` was given, which this command does not read.
    #[error(
        "demo brings its own configuration; allowed: no --config (DIR/{CONFIG} is what it ran with)"
    )]
    Config,
    /// The drawn configuration breaks a rule: a bug.
    #[error("the demo's configuration: {0}")]
    Invalid(#[from] ConfigErrors),
    /// Signals cannot be handled.
    #[error("cannot handle signals: {0}")]
    Signals(io::Error),
    /// A camera is not calibrated.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// A process did not start, or ended too early.
    #[error(transparent)]
    Child(#[from] ChildError),
    /// The consumer failed.
    #[error(transparent)]
    Consumer(#[from] ConsumerError),
    /// What the consumer wrote cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// SIGINT or SIGTERM.
    #[error("interrupted; every process was ended")]
    Interrupted,
    /// A file or directory cannot be written.
    #[error("{}: cannot be written: {source}", path.display())]
    Write {
        /// The file or directory.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}

impl DemoError {
    /// 2 where the command line is to blame, else 1.
    pub const fn exit_code(&self) -> u8 {
        match self {
            Self::Config => 2,
            _ => 1,
        }
    }
}

/// Runs the demo and leaves its files in the directory.
///
/// # Errors
/// [`DemoError`]; every process it started has ended by then, and its shared memory is free.
pub fn demo(config: Option<&Path>, args: &DemoArgs) -> Result<(), DemoError> {
    if config.is_some() {
        return Err(DemoError::Config);
    }
    let stop = StopFlag::new();
    stop.raise_on_signals().map_err(DemoError::Signals)?;
    let out = args.out.as_path();
    fs::create_dir_all(out).map_err(|source| failed(out, source))?;
    // Freed last, when all processes have ended.
    let memory = OwnMemory::of(std::process::id());
    let mut progress = Progress::choose();
    let (config, expected) = prepare(args, &memory, &stop, &mut progress)?;
    run(args, &memory, &stop, &mut progress)?;
    progress.phase("scoring the clouds and drawing the picture");
    let outcome = conclude(args, &config, expected)?;
    progress.finish();
    say(&if args.json { json(&outcome) } else { summary(out, &outcome) });
    Ok(())
}

/// The configuration that the processes will read, with calibrated cameras.
fn prepare(
    args: &DemoArgs,
    memory: &OwnMemory,
    stop: &StopFlag,
    progress: &mut Progress,
) -> Result<(Config, Vec<Expected>), DemoError> {
    let mut config = drawn(Config::demo(), args.seed);
    memory.apply(&mut config.shared_memory);
    let calibrate = |camera: &str| progress.phase(&format!("calibrating {camera}: turned by hand"));
    let expected =
        calibrate_all(&mut config, (args.seed, &args.out), stop, calibrate).map_err(|error| {
            match error {
                CalibrationError::Recording(RecordingError::Interrupted) => DemoError::Interrupted,
                other => other.into(),
            }
        })?;
    let text = toml::to_string(&config).map_err(io::Error::other);
    let path = args.out.join(CONFIG);
    let text = text.map_err(|source| failed(&path, source))?;
    Config::from_toml(CONFIG, &text)?;
    write(&path, &text)?;
    Ok((config, expected))
}

/// Starts everything, and waits until the consumer has what it wants.
fn run(
    args: &DemoArgs,
    memory: &OwnMemory,
    stop: &StopFlag,
    progress: &mut Progress,
) -> Result<(), DemoError> {
    progress.phase("starting the daemon, two depth sources and the consumer");
    let domain = [(PREFIX_VARIABLE, memory.prefix()), (ROOT_VARIABLE, memory.root())];
    let domain = domain.map(|(name, value)| (name, value.to_owned()));
    let mut children = Children::new(&args.out, domain.into())
        .map_err(|source| ChildError::Start { name: "lodestoned".into(), source })?;
    let config = args.out.join(CONFIG);
    let config = config.to_string_lossy();
    children.start("daemon", &["run", "--config", &config])?;
    for camera in CAMERAS {
        let name = format!("depth-{camera}");
        children.start(&name, &["depth", "--config", &config, "--camera", camera])?;
    }
    let (out, duration) = (args.out.to_string_lossy(), args.duration.as_secs_f64().to_string());
    let settle = SETTLE.as_secs_f64().to_string();
    let consumer = ["demo-consumer", "--out", &out, "--duration", &duration, "--settle", &settle];
    let events = listen(children.start_piped("consumer", &consumer)?);
    while !children.look()? {
        if stop.is_raised() {
            return Err(DemoError::Interrupted);
        }
        match events.recv_timeout(LOOK) {
            Ok(event) => show(progress, &event),
            // Its last words may come before its end.
            Err(RecvTimeoutError::Disconnected) => thread::sleep(LOOK),
            Err(RecvTimeoutError::Timeout) => {}
        }
    }
    Ok(())
}

/// The consumer's lines as they come, until it closes its output.
fn listen(output: Option<ChildStdout>) -> Receiver<Event> {
    let (sender, events) = channel();
    if let Some(output) = output {
        thread::spawn(move || {
            let lines = BufReader::new(output).lines().map_while(Result::ok);
            // Whoever does not listen any more is about to end the consumer.
            let _ =
                lines.filter_map(|line| Event::from_line(&line)).try_for_each(|e| sender.send(e));
        });
    }
    events
}

fn show(progress: &mut Progress, event: &Event) {
    match event {
        Event::Waiting { what } => progress.phase(&format!("waiting for {what}")),
        Event::Settling => progress.phase("poses are there; the filters settle"),
        Event::Merging { share, points } => {
            progress.phase("merging the clouds of both cameras");
            progress.share(*share, &format!("{:.1} million points", *points as f64 / 1e6));
        }
        Event::Writing => progress.phase("writing the clouds"),
    }
}

/// Scores, draws and writes.
fn conclude(
    args: &DemoArgs,
    config: &Config,
    expected: Vec<Expected>,
) -> Result<Outcome, DemoError> {
    let path = args.out.join(REPORT);
    let text = fs::read_to_string(&path)
        .and_then(|text| serde_json::from_str::<Seen>(&text).map_err(io::Error::other));
    let seen = text.map_err(|source| ReadError { path, source })?;
    let clouds = clouds(&args.out, &seen)?;
    let mut outcome = Outcome::of(args.seed, config, &seen, &clouds);
    outcome.calibration = expected;
    if let Some(picture) = sheet::draw(config, &seen, &clouds, &outcome) {
        let path = args.out.join(PICTURE);
        write_png(&path, &picture).map_err(|source| failed(&path, source))?;
    }
    write(&args.out.join(NUMBERS), &json(&outcome))?;
    Ok(outcome)
}

fn json(outcome: &Outcome) -> String {
    // Numbers and text always are JSON.
    serde_json::to_string_pretty(outcome).unwrap_or_default() + "\n"
}

fn summary(out: &Path, outcome: &Outcome) -> String {
    let file = |name: &str| out.join(name).display().to_string();
    format!(
        "{}\n{} to look at, {} to open elsewhere (CloudCompare, MeshLab, Open3D)\n",
        table::text(outcome),
        file(PICTURE),
        file(Variant::Refined.file()),
    )
}

fn failed(path: &Path, source: io::Error) -> DemoError {
    DemoError::Write { path: path.into(), source }
}

fn write(path: &Path, text: &str) -> Result<(), DemoError> {
    fs::write(path, text).map_err(|source| failed(path, source))
}

/// The result. A reader that went away does not make it worse.
fn say(text: &str) {
    let _ = io::stdout().write_all(text.as_bytes());
}

/// The consumer's process.
///
/// # Errors
/// [`DemoError::Consumer`].
pub fn consumer(args: &DemoConsumerArgs) -> Result<(), DemoError> {
    let stop = StopFlag::new();
    stop.raise_on_signals().map_err(DemoError::Signals)?;
    let times = Times { settle: args.settle, merge: args.duration };
    Ok(consume(&args.out, times, &stop)?)
}
