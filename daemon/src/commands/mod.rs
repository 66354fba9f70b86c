//! What `lodestoned` does when it is asked to.

pub mod calibrate;
pub mod check;
pub mod demo;
pub mod depth;
pub mod evaluate;
pub mod replay;
pub mod run;
pub mod supervision;

use std::path::{Path, PathBuf};

use lodestone_config::{Config, LoadError, Loaded};
use rustix::process::{Signal, getppid, set_parent_process_death_signal};

use crate::cli::{Cli, Command};
use crate::console::Console;
use crate::logging::{self, LoggingError};

/// Why a command failed.
#[derive(Debug, thiserror::Error)]
pub enum CommandError {
    /// The configuration cannot be used.
    #[error(transparent)]
    Configuration(#[from] LoadError),
    /// The log filter cannot be used.
    #[error(transparent)]
    Logging(#[from] LoggingError),
    /// Running failed.
    #[error(transparent)]
    Run(#[from] run::RunError),
    /// Files that the configuration names cannot be used.
    #[error("{0}")]
    Files(String),
    /// There is no calibration.
    #[error(transparent)]
    Calibrate(#[from] calibrate::CalibrateError),
    /// Replaying failed.
    #[error(transparent)]
    Replay(#[from] replay::ReplayCommandError),
    /// The demo failed.
    #[error(transparent)]
    Demo(#[from] demo::DemoError),
    /// Whoever started this process is gone.
    #[error("the process {0} that this one was to end with is not its parent")]
    Orphan(i32),
    /// Evaluating failed.
    #[error(transparent)]
    Evaluate(#[from] evaluate::EvaluateError),
    /// There is no depth source.
    #[error(transparent)]
    Depth(#[from] depth::DepthError),
}

impl CommandError {
    /// 2 for wrong usage or configuration, 1 for anything else.
    pub const fn exit_code(&self) -> u8 {
        match self {
            Self::Configuration(_) | Self::Files(_) | Self::Logging(_) => 2,
            Self::Run(e) => e.exit_code(),
            Self::Calibrate(e) => e.exit_code(),
            Self::Replay(e) => e.exit_code(),
            Self::Demo(e) => e.exit_code(),
            Self::Orphan(_) => 1,
            Self::Evaluate(e) => e.exit_code(),
            Self::Depth(e) => e.exit_code(),
        }
    }
}

/// Does what the command line says.
///
/// # Errors
/// [`CommandError`], with its exit code.
pub fn execute(cli: &Cli) -> Result<(), CommandError> {
    cli.with_parent.map_or(Ok(()), end_with)?;
    match &cli.command {
        None => execute_run(cli, &crate::cli::RunArgs::default()),
        Some(Command::Run(args)) => execute_run(cli, args),
        Some(Command::Check(args)) => {
            logging::init(cli.log.as_deref(), None)?;
            check::check(cli.config.as_deref(), args)
        }
        Some(Command::Replay(args)) => {
            logging::init(cli.log.as_deref(), None)?;
            Ok(replay::replay(&load(cli.config.as_deref())?, args)?)
        }
        Some(Command::Evaluate(args)) => {
            logging::init(cli.log.as_deref(), None)?;
            Ok(evaluate::evaluate(cli.config.as_deref(), args)?)
        }
        Some(Command::Calibrate(args)) => execute_calibrate(cli, args),
        Some(Command::Demo(args)) => {
            logging::init(cli.log.as_deref(), None)?;
            Ok(demo::demo(cli.config.as_deref(), args)?)
        }
        Some(Command::DemoConsumer(args)) => {
            logging::init(cli.log.as_deref(), None)?;
            Ok(demo::consumer(args)?)
        }
        Some(Command::Depth(args)) => {
            logging::init(cli.log.as_deref(), None)?;
            Ok(depth::depth(&load(cli.config.as_deref())?, args)?)
        }
    }
}

/// Has the kernel end this process, as by SIGTERM, when its parent ends, in whichever way.
fn end_with(parent: i32) -> Result<(), CommandError> {
    let asked = set_parent_process_death_signal(Some(Signal::TERM)).is_ok();
    // The parent may have ended before the kernel was asked.
    let is_parent = getppid().is_some_and(|pid| pid.as_raw_nonzero().get() == parent);
    (asked && is_parent).then_some(()).ok_or(CommandError::Orphan(parent))
}

fn execute_run(cli: &Cli, args: &crate::cli::RunArgs) -> Result<(), CommandError> {
    let loaded = load(cli.config.as_deref())?;
    let console = Console::choose();
    logging::init(cli.log.as_deref(), console.log_lines())?;
    check::check_files(&loaded)?;
    Ok(run::run(loaded, args, console, crate::pipeline::start)?)
}

fn execute_calibrate(cli: &Cli, args: &crate::cli::CalibrateArgs) -> Result<(), CommandError> {
    let guidance = calibrate::Guidance::choose(args.json || args.recording.is_some());
    logging::init(cli.log.as_deref(), guidance.log_lines())?;
    let loaded = load(cli.config.as_deref())?;
    Ok(calibrate::calibrate(&loaded, cli.config.is_some(), args, guidance)?)
}

/// The configuration of a file, or the embedded one.
fn load(file: Option<&Path>) -> Result<Loaded, LoadError> {
    let embedded = || Loaded { config: Config::embedded(), path: PathBuf::new() };
    file.map_or_else(|| Ok(embedded()), Config::load)
}
