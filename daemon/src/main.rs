//! The daemon's command line.

use std::process::ExitCode;

use clap::Parser;
use lodestone_daemon::cli::Cli;
use lodestone_daemon::commands::execute;

fn main() -> ExitCode {
    match execute(&Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            // Standard error may be closed; the exit code still tells.
            let _ = std::io::Write::write_fmt(
                &mut std::io::stderr(),
                format_args!("lodestoned: {e}\n"),
            );
            ExitCode::from(e.exit_code())
        }
    }
}
