//! Latency from a sample's arrival to a consumer, stage by stage: see `lodestone_benches::latency`.
//!
//! `cargo bench -p lodestone-benches --bench latency [-- --rounds 3 --seconds 1]`

use std::error::Error;

use clap::Parser;
use lodestone_benches::latency::role::{Role, play};
use lodestone_benches::latency::{rounds, table};

/// Measures the latency from a sample's arrival to a consumer, stage by stage.
#[derive(Parser)]
struct Args {
    /// Rounds; each runs every subject once.
    #[arg(long, default_value_t = 3)]
    rounds: usize,
    /// Seconds each subject is measured in a round.
    #[arg(long, default_value_t = 1.0)]
    seconds: f64,
    /// Given by `cargo bench`; without it (as in `cargo test`) nothing is measured.
    #[arg(long, hide = true)]
    bench: bool,
    /// Parts the harness starts itself for.
    #[command(subcommand)]
    role: Option<Role>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let args = Args::parse();
    if let Some(role) = &args.role {
        return play(role);
    }
    if !args.bench {
        println!("skipped: latencies are measured by cargo bench");
        return Ok(());
    }
    let mut seen = Vec::new();
    for round in 1..=args.rounds {
        eprintln!("round {round} of {}", args.rounds);
        seen.extend(rounds::round(args.seconds)?);
    }
    table::print(&seen);
    Ok(())
}
