//! What `lodestoned` does when it is asked to.

pub mod check;
pub mod replay;
pub mod run;
pub mod supervision;

use std::path::Path;

use lodestone_config::model::Config;

use crate::cli::{Cli, Command};
use crate::console::Console;
use crate::logging::{self, LoggingError};

/// Why a command failed.
#[derive(Debug, thiserror::Error)]
pub enum CommandError {
    /// The configuration cannot be used.
    #[error("{0}")]
    Configuration(String),
    /// The log filter cannot be used.
    #[error(transparent)]
    Logging(#[from] LoggingError),
    /// Running failed.
    #[error(transparent)]
    Run(#[from] run::RunError),
    /// This build does not have it.
    #[error("{0} is not part of this build")]
    NotBuilt(&'static str),
}

impl CommandError {
    /// 2 for wrong usage or configuration, 1 for anything else.
    pub const fn exit_code(&self) -> u8 {
        match self {
            Self::Configuration(_) | Self::Logging(_) => 2,
            Self::Run(e) => e.exit_code(),
            Self::NotBuilt(_) => 1,
        }
    }
}

/// Does what the command line says.
///
/// # Errors
/// [`CommandError`], with its exit code.
pub fn execute(cli: &Cli) -> Result<(), CommandError> {
    match &cli.command {
        None => execute_run(cli, &crate::cli::RunArgs::default()),
        Some(Command::Run(args)) => execute_run(cli, args),
        Some(Command::Check(args)) => {
            logging::init(cli.log.as_deref(), None)?;
            check::check(cli.config.as_deref(), args)
        }
        Some(Command::Replay(args)) => {
            logging::init(cli.log.as_deref(), None)?;
            replay::replay(&load(cli.config.as_deref())?, args)
        }
    }
}

fn execute_run(cli: &Cli, args: &crate::cli::RunArgs) -> Result<(), CommandError> {
    let config = load(cli.config.as_deref())?;
    let console = Console::choose();
    logging::init(cli.log.as_deref(), console.log_lines())?;
    Ok(run::run(config, args, console, run::start_lane)?)
}

/// CONNECT: the one place where a configuration is loaded and validated, or the embedded one taken.
fn load(file: Option<&Path>) -> Result<Config, CommandError> {
    let Some(file) = file else { return Ok(Config::default()) };
    let named = |what: &dyn std::fmt::Display| {
        CommandError::Configuration(format!("{}: {what}", file.display()))
    };
    let text = std::fs::read_to_string(file).map_err(|e| named(&e))?;
    toml::from_str(&text).map_err(|e| named(&e))
}
