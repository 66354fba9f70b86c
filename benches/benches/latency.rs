//! Latency from a sample's arrival to a consumer, stage by stage, beside peers: see
//! `lodestone_benches::latency`.
//!
//! `cargo bench -p lodestone-benches --bench latency [-- --rounds 3 --seconds 1]`

use std::error::Error;
use std::fs;
use std::path::PathBuf;

use clap::Parser;
use lodestone_benches::latency::plan::Plan;
use lodestone_benches::latency::report::{Summary, markdown, page, text};
use lodestone_benches::latency::role::{Role, play};
use lodestone_benches::latency::subject::Subject;

/// Measures the latency from a sample's arrival to a consumer, stage by stage, beside peers that carry the
/// same number of bytes at the same rate.
#[derive(Parser)]
struct Args {
    /// Rounds; each runs every subject once, in an order drawn anew.
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(u64).range(1..))]
    rounds: u64,
    /// Seconds each subject is measured in a round.
    #[arg(long, default_value_t = 3.0, value_parser = seconds)]
    seconds: f64,
    /// Seed of the order.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Only this subject; may be given several times.
    #[arg(long, value_enum, value_name = "SUBJECT")]
    only: Vec<Subject>,
    /// Write all figures as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a page with curves of percentiles.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Print the tables of the README instead of the whole report.
    #[arg(long)]
    markdown: bool,
    /// Without real-time priority, also where it is allowed.
    #[arg(long)]
    ordinary: bool,
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
        return play(role, !args.ordinary);
    }
    if !args.bench {
        println!("skipped: latencies are measured by cargo bench");
        return Ok(());
    }
    let rounds = usize::try_from(args.rounds)?;
    let plan = Plan {
        rounds,
        seconds: args.seconds,
        seed: args.seed,
        real_time: !args.ordinary,
        only: args.only,
    };
    let summary = Summary::of(&plan, &plan.run()?);
    if let Some(file) = &args.json {
        fs::write(file, serde_json::to_string_pretty(&summary)? + "\n")?;
    }
    if let Some(file) = &args.html {
        fs::write(file, page(&summary))?;
    }
    println!("{}", if args.markdown { markdown(&summary) } else { text(&summary) });
    Ok(())
}

fn seconds(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|s: &f64| (0.2..=3600.0).contains(s));
    number.ok_or_else(|| "allowed: 0.2 to 3600".into())
}
