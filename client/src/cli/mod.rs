//! The command: arguments, commands, and how they end.

mod args;
mod bench;
mod describe;
mod doctor;
mod echo;
mod failure;
mod json;
mod lookup;
mod merge;
mod output;
mod relative;
mod report;
mod seconds;
mod session;
mod status;
mod stop;
mod table;
mod transforms;
mod watch;
mod world;

use std::process::ExitCode;

use clap::Parser;
use iceoryx2::prelude::{LogLevel, set_log_level};
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::prelude::*;

use args::{Args, Command};
use failure::Failure;
use session::Session;

/// Runs the command line; the exit code is 0 (good), 2 (wrong usage) or 1 (anything else).
pub(crate) fn run() -> ExitCode {
    let args = Args::parse();
    log_to_stderr(args.common.verbose);
    match command(&args) {
        Ok(()) | Err(Failure::NobodyReads) => ExitCode::SUCCESS,
        Err(failure) => {
            output::remark(&failure);
            failure.exit_code()
        }
    }
}

fn command(args: &Args) -> Result<(), Failure> {
    let stop = stop::Stop::on_signals()?;
    let session = Session::new(&args.common, stop)?;
    match &args.command {
        Command::Status(chosen) => status::run(&session, chosen),
        Command::Watch(chosen) => watch::run(&session, chosen),
        Command::Echo(chosen) => echo::run(&session, chosen),
        Command::Lookup(chosen) => lookup::run(&session, chosen),
        Command::Merge(chosen) => merge::run(&session, chosen),
        Command::World(chosen) => world::run(&session, chosen),
        Command::Relative(chosen) => relative::run(&session, chosen),
        Command::Transforms => transforms::run(&session),
        Command::Bench(chosen) => bench::run(&session, chosen),
        Command::Doctor(chosen) => doctor::run(&session, chosen),
    }
}

/// The transport logs as errors what the command explains in its own words, so it is silent
/// unless asked.
fn log_to_stderr(verbose: bool) {
    if !verbose {
        set_log_level(LogLevel::Fatal);
        return;
    }
    set_log_level(LogLevel::Debug);
    let asked = std::env::var("LODESTONE_LOG").ok().and_then(|text| text.parse().ok());
    let filter = asked.unwrap_or_else(|| Targets::new().with_default(LevelFilter::DEBUG));
    let lines = tracing_subscriber::fmt().with_max_level(LevelFilter::TRACE);
    lines.with_writer(std::io::stderr).finish().with(filter).init();
}
