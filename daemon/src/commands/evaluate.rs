//! `lodestoned evaluate`: how good is it, by the paper's own tables.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::cli::{EvaluateCommand, StaticArgs};
use crate::evaluation::place::{Place, ScenarioError, places};
use crate::evaluation::recording::RecordingError;
use crate::evaluation::rest;
use crate::evaluation::static_places::{self, StaticError};
use crate::report::static_report::{StaticReport, text_table};
use crate::service::signals::StopFlag;

/// Why an evaluation failed.
#[derive(Debug, thiserror::Error)]
pub enum EvaluateError {
    /// `--config` was given, which this command does not read.
    #[error("evaluate reads no --config; allowed: --scenario FILE, once or more")]
    Config,
    /// A scenario cannot be used.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A place cannot be evaluated.
    #[error(transparent)]
    Static(#[from] StaticError),
    /// The place at rest cannot be recorded.
    #[error(transparent)]
    Rest(#[from] RecordingError),
    /// The numbers cannot be written as JSON.
    #[error("cannot write the numbers as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A file or directory cannot be written.
    #[error("{}: cannot be written: {source}", path.display())]
    Write {
        /// The file or directory.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Signals cannot be handled.
    #[error("cannot handle signals: {0}")]
    Signals(io::Error),
}

impl EvaluateError {
    /// 2 where the command line or a scenario is to blame, else 1.
    pub const fn exit_code(&self) -> u8 {
        match self {
            Self::Config
            | Self::Scenario(_)
            | Self::Rest(RecordingError::World { .. })
            | Self::Static(
                StaticError::Field { .. }
                | StaticError::NoReadings { .. }
                | StaticError::Recording(RecordingError::World { .. }),
            ) => 2,
            _ => 1,
        }
    }
}

/// Does the evaluation that was asked for.
///
/// # Errors
/// [`EvaluateError`]; nothing is written then, except where writing itself failed.
pub fn evaluate(config: Option<&Path>, command: &EvaluateCommand) -> Result<(), EvaluateError> {
    if config.is_some() {
        return Err(EvaluateError::Config);
    }
    let stop = StopFlag::new();
    stop.raise_on_signals().map_err(EvaluateError::Signals)?;
    match command {
        EvaluateCommand::Static(args) => evaluate_static(args, &stop),
    }
}

fn evaluate_static(args: &StaticArgs, stop: &StopFlag) -> Result<(), EvaluateError> {
    let places = places(&args.scenario)?;
    make_directory(&args.out)?;
    let report = measure(&places, args, stop)?;
    let json = serde_json::to_string_pretty(&report)? + "\n";
    let html = args.out.join("report.html");
    write(&html, &report.html())?;
    write(&args.out.join("report.json"), &json)?;
    progress(&format!("{} is for looking at, report.json beside it for machines", html.display()));
    say(&if args.json { json } else { text_table(&report.places) });
    Ok(())
}

fn measure(
    places: &[Place],
    args: &StaticArgs,
    stop: &StopFlag,
) -> Result<StaticReport, EvaluateError> {
    let mut results = Vec::new();
    for (index, place) in places.iter().enumerate() {
        progress(&format!("{} of {}: {}", index + 1, places.len(), place.name));
        results.push(static_places::evaluate(place, args.seed, stop)?);
    }
    // `places` gives at least one, because every configuration has a camera.
    let standing = &places[0];
    let rest_s = args.rest.as_secs_f64();
    progress(&format!("{} at rest for {rest_s} s", standing.name));
    let rest = rest::evaluate(standing, args.seed, rest_s, stop)?;
    Ok(StaticReport::new(args.seed, results, rest))
}

fn make_directory(path: &Path) -> Result<(), EvaluateError> {
    fs::create_dir_all(path).map_err(|source| EvaluateError::Write { path: path.into(), source })
}

fn write(path: &Path, text: &str) -> Result<(), EvaluateError> {
    fs::write(path, text).map_err(|source| EvaluateError::Write { path: path.into(), source })
}

/// A line for whoever waits. Standard error may be closed; that changes nothing.
fn progress(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// The result. A reader that went away does not make it worse.
fn say(text: &str) {
    let _ = io::stdout().write_all(text.as_bytes());
}
