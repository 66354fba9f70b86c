//! Runs samples through a lane's core, or through its peer, for an instruction counter to watch.
//!
//! However many samples are taken, the same number is made: two runs that take different numbers
//! differ by the cost of taking alone. `benches/callgrind.sh` does that.

use std::error::Error;
use std::hint::black_box;
use std::path::PathBuf;

use clap::{Parser, ValueEnum};
use lodestone_benches::readings::Load;
use lodestone_benches::vqf::VqfLane;
use lodestone_config::model::TrajectoryKind;
use lodestone_daemon::lane::Core;

/// Runs samples through a lane's core, or through its peer.
#[derive(Parser)]
#[command(name = "lane-steps")]
struct Args {
    /// What takes the samples.
    #[arg(long, value_enum, default_value = "lane")]
    subject: Subject,
    /// How the synthetic camera moves.
    #[arg(long, value_enum, default_value = "walk")]
    motion: Motion,
    /// A recording (CSV, plain or .zst) instead of the synthetic camera.
    #[arg(long, conflicts_with = "motion")]
    recording: Option<PathBuf>,
    /// Samples made before anything is taken.
    #[arg(long, default_value_t = 16_000)]
    made: usize,
    /// Samples taken, at most those made; all if absent.
    #[arg(long)]
    taken: Option<usize>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Subject {
    /// The lane's core: axes, calibration, grid, filter, pose.
    Lane,
    /// VQF, an orientation filter.
    Vqf,
    /// Nothing: the samples are only made.
    None,
}

#[derive(Clone, Copy, ValueEnum)]
enum Motion {
    /// Carried by hand: levelling and compass.
    Walk,
    /// At rest: zero-velocity and zero-rate updates too.
    Standing,
}

fn main() -> Result<(), Box<dyn Error>> {
    let args = Args::parse();
    let load = load(&args)?;
    let taken = args.taken.unwrap_or(load.readings.len());
    let Some(readings) = load.readings.get(..taken) else {
        return Err(format!("--taken {taken}: there are {} samples", load.readings.len()).into());
    };
    let outputs = match args.subject {
        Subject::Lane => {
            let mut core = Core::new(&load.settings);
            let mut steps = 0;
            for reading in readings {
                core.take(black_box(reading), |step| {
                    black_box(step);
                    steps += 1;
                });
            }
            steps
        }
        Subject::Vqf => {
            let mut peer = VqfLane::new(&load);
            readings.iter().map(|reading| black_box(peer.take(black_box(reading)))).count()
        }
        Subject::None => 0,
    };
    println!("{taken} samples taken, {outputs} outputs");
    Ok(())
}

fn load(args: &Args) -> Result<Load, Box<dyn Error>> {
    let trajectory = match args.motion {
        Motion::Walk => TrajectoryKind::Walk,
        Motion::Standing => TrajectoryKind::Standing,
    };
    Ok(match &args.recording {
        Some(recording) => Load::recorded(recording, args.made)?,
        None => Load::synthetic(trajectory, args.made)?,
    })
}
