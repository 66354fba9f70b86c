//! `lodestoned evaluate`: how good is it, by the paper's own tables and figures.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use lodestone_config::model::Preset;

use crate::cli::{
    DynamicOptions, EvaluateArgs, EvaluatePart, PresetArg, ReportArgs, StaticOptions,
};
use crate::evaluation::dynamic::recorded::RecordedError;
use crate::evaluation::dynamic::{self, Conditions, DynamicError, DynamicResult};
use crate::evaluation::place::{Place, ScenarioError, places};
use crate::evaluation::recording::RecordingError;
use crate::evaluation::rest;
use crate::evaluation::static_places::{self, StaticError};
use crate::report::evaluation::Report;
use crate::report::static_report::StaticReport;
use crate::service::signals::StopFlag;

/// Why an evaluation failed.
#[derive(Debug, thiserror::Error)]
pub enum EvaluateError {
    /// `--config` was given, which this command does not read.
    #[error("evaluate reads no --config; allowed: evaluate static --scenario FILE, once or more")]
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
    /// The dynamic part failed.
    #[error(transparent)]
    Dynamic(#[from] DynamicError),
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
            | Self::Dynamic(DynamicError::Recorded(RecordedError::NothingToScore(_)))
            | Self::Static(
                StaticError::Field { .. }
                | StaticError::NoReadings { .. }
                | StaticError::Recording(RecordingError::World { .. }),
            ) => 2,
            _ => 1,
        }
    }
}

/// What was asked for.
struct Task<'a> {
    report: &'a ReportArgs,
    statics: Option<&'a StaticOptions>,
    dynamic: Option<&'a DynamicOptions>,
}

impl<'a> Task<'a> {
    const fn of(args: &'a EvaluateArgs) -> Self {
        match &args.part {
            None => Self {
                report: &args.report,
                statics: Some(&args.statics),
                dynamic: Some(&args.dynamic),
            },
            Some(EvaluatePart::Static(part)) => {
                Self { report: &part.report, statics: Some(&part.options), dynamic: None }
            }
            Some(EvaluatePart::Dynamic(part)) => {
                Self { report: &part.report, statics: None, dynamic: Some(&part.options) }
            }
        }
    }
}

/// Does the evaluation that was asked for.
///
/// # Errors
/// [`EvaluateError`]; nothing is written then, except where writing itself failed.
pub fn evaluate(config: Option<&Path>, args: &EvaluateArgs) -> Result<(), EvaluateError> {
    if config.is_some() {
        return Err(EvaluateError::Config);
    }
    let stop = StopFlag::new();
    stop.raise_on_signals().map_err(EvaluateError::Signals)?;
    let task = Task::of(args);
    let places = task.statics.map(|options| places(&options.scenario)).transpose()?;
    make_directory(&task.report.out)?;
    let seed = task.report.seed;
    let statics = task.statics.zip(places);
    let statics = statics.map(|(options, places)| measure_static(&places, seed, options, &stop));
    let dynamic = task.dynamic.map(|options| measure_dynamic(seed, options, &stop));
    let report = Report::new(seed, statics.transpose()?, dynamic.transpose()?);
    finish(&report, task.report)
}

fn finish(report: &Report, args: &ReportArgs) -> Result<(), EvaluateError> {
    let json = serde_json::to_string_pretty(report)? + "\n";
    let html = args.out.join("report.html");
    write(&html, &report.html())?;
    write(&args.out.join("report.json"), &json)?;
    progress(&format!("{} is for looking at, report.json beside it for machines", html.display()));
    say(&if args.json { json } else { report.text() });
    Ok(())
}

fn measure_static(
    places: &[Place],
    seed: u64,
    options: &StaticOptions,
    stop: &StopFlag,
) -> Result<StaticReport, EvaluateError> {
    let mut results = Vec::new();
    for (index, place) in places.iter().enumerate() {
        progress(&format!("{} of {}: {}", index + 1, places.len(), place.name));
        results.push(static_places::evaluate(place, seed, stop)?);
    }
    // `places` gives at least one, because every configuration has a camera.
    let standing = &places[0];
    let rest_s = options.rest.as_secs_f64();
    progress(&format!("{} at rest for {rest_s} s", standing.name));
    let rest = rest::evaluate(standing, seed, rest_s, stop)?;
    Ok(StaticReport::new(results, rest))
}

fn measure_dynamic(
    seed: u64,
    options: &DynamicOptions,
    stop: &StopFlag,
) -> Result<DynamicResult, EvaluateError> {
    let conditions = Conditions {
        seed,
        runs: options.runs,
        recordings: &options.recording,
        preset: preset_of(options.preset),
        stop,
        progress: &progress,
    };
    Ok(dynamic::evaluate(conditions)?)
}

const fn preset_of(asked: PresetArg) -> Preset {
    match asked {
        PresetArg::Carried => Preset::Carried,
        PresetArg::Foot => Preset::Foot,
    }
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
