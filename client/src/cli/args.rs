//! Arguments.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Parser, Subcommand, ValueEnum};

use super::seconds::{Instant, duration, instant};

/// Shows where the cameras of a running Lodestone daemon are, and how they fare.
///
/// Exit codes: 0 good, 2 wrong usage, 1 anything else (no daemon, another schema version, no pose
/// at that time).
#[derive(Debug, Parser)]
#[command(name = "lodestone", version)]
pub(super) struct Args {
    #[command(flatten)]
    pub(super) common: Common,
    #[command(subcommand)]
    pub(super) command: Command,
}

/// What every command takes.
#[derive(Debug, clap::Args)]
pub(super) struct Common {
    /// One JSON object per line; what is unknown is null.
    #[arg(long, global = true, help_heading = EVERY)]
    pub(super) json: bool,
    // Given as attributes: a doc comment would want the names in backticks.
    #[arg(long, global = true, help_heading = EVERY, value_name = "PREFIX", help = PREFIX_HELP)]
    pub(super) prefix: Option<String>,
    #[arg(long, global = true, help_heading = EVERY, value_name = "DIRECTORY", help = ROOT_HELP)]
    pub(super) root: Option<String>,
    /// Wait this long for a daemon to appear.
    #[arg(
        long, global = true, help_heading = EVERY, value_name = "SECONDS",
        value_parser = duration, default_value = "0"
    )]
    pub(super) wait: Duration,
    #[arg(long, short, global = true, help_heading = EVERY, help = VERBOSE_HELP)]
    pub(super) verbose: bool,
}

const EVERY: &str = "Options of every command";
const PREFIX_HELP: &str = "Prefix of the daemon's files in shared memory [default: $LODESTONE_SHM_PREFIX, else lodestone_]";
const ROOT_HELP: &str = "Directory of the daemon's service files [default: $LODESTONE_SHM_ROOT, else /dev/shm/lodestone/]";
const VERBOSE_HELP: &str =
    "Log to stderr what the transport does; $LODESTONE_LOG filters [default: debug]";

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// State, rates, losses, heading and position of each camera, once.
    Status(StatusArgs),
    /// The same as a live table; without a terminal, one line per camera and second.
    Watch(WatchArgs),
    /// Poses of one camera as they come.
    Echo(EchoArgs),
    /// Where a camera was at a time: interpolated, or predicted for at most 50 ms.
    Lookup(LookupArgs),
    /// Merges the clouds of cameras into one file, live.
    Merge(MergeArgs),
    /// The world that all cameras share, or a new one.
    World(WorldArgs),
    /// Each camera as the others have it: relative orientation and distance, once.
    Relative(RelativeArgs),
    /// The tree of frames: world, bodies, cameras, lenses, magnetometers.
    Transforms,
    /// Check whether this machine lets poses be in time, and say what to change; 1 if something is bad.
    Doctor(DoctorArgs),
    /// How long samples take from their arrival to a consumer, stage by stage. Takes one processor while
    /// it measures, and one place among the cameras' subscribers.
    Bench(BenchArgs),
}

#[derive(Debug, clap::Args)]
pub(super) struct BenchArgs {
    /// Cameras; all if left out.
    #[arg(value_name = "CAMERA")]
    pub(super) cameras: Vec<String>,
    /// Time that is measured.
    #[arg(long, value_name = "SECONDS", value_parser = duration, default_value = "10")]
    pub(super) duration: Duration,
    /// Time before it, in which nothing counts.
    #[arg(long, value_name = "SECONDS", value_parser = duration, default_value = "1")]
    pub(super) warm_up: Duration,
    /// Processor on which this consumer polls [default: the last one it may use]
    #[arg(long, value_name = "N")]
    pub(super) cpu: Option<usize>,
    /// Write a page with curves of percentiles.
    #[arg(long, value_name = "FILE")]
    pub(super) html: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
pub(super) struct WorldArgs {
    #[command(subcommand)]
    pub(super) action: Option<WorldAction>,
}

#[derive(Clone, Copy, Debug, Subcommand)]
pub(super) enum WorldAction {
    /// Have the daemon define the world anew: the first camera is at its origin again, those with a
    /// start stand there again.
    Reset,
}

#[derive(Debug, clap::Args)]
pub(super) struct RelativeArgs {
    /// Camera a, in whose axes all is given, and camera b; every pair if left out.
    #[arg(num_args = 2, value_names = ["A", "B"])]
    pub(super) cameras: Vec<String>,
}

#[derive(Debug, clap::Args)]
pub(super) struct DoctorArgs {
    /// Look at the files of a machine below this directory instead.
    #[arg(long, value_name = "DIRECTORY", hide = true)]
    pub(super) machine: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
pub(super) struct StatusArgs {
    /// Only this camera.
    #[arg(long, value_name = "NAME")]
    pub(super) camera: Option<String>,
}

#[derive(Debug, clap::Args)]
pub(super) struct WatchArgs {
    /// Time between two looks [default: 0.2 in a terminal, else 1]
    #[arg(long, value_name = "SECONDS", value_parser = duration)]
    pub(super) interval: Option<Duration>,
    /// Stop after so many looks.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub(super) count: Option<u64>,
}

#[derive(Debug, clap::Args)]
pub(super) struct EchoArgs {
    /// The camera; may be left out if there is one only.
    #[arg(long, value_name = "NAME")]
    pub(super) camera: Option<String>,
    /// Stop after so many poses.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub(super) count: Option<u64>,
}

#[derive(Debug, clap::Args)]
pub(super) struct LookupArgs {
    /// The camera; may be left out if there is one only.
    #[arg(long, value_name = "NAME")]
    pub(super) camera: Option<String>,
    /// The time, as decimal seconds (12.345678901) or nanoseconds (12345678901ns).
    #[arg(long, value_name = "T", value_parser = instant, required_unless_present = "ago")]
    pub(super) time: Option<Instant>,
    /// The clock that the time is of.
    #[arg(long, value_enum, default_value_t = ClockName::Unix, conflicts_with = "ago")]
    pub(super) clock: ClockName,
    /// So long before now, as decimal seconds.
    #[arg(long, value_name = "SECONDS", value_parser = duration, conflicts_with = "time")]
    pub(super) ago: Option<Duration>,
}

/// Each point is placed by the pose at its own time and gathered with its neighbours in voxels; the file
/// holds the mean of each voxel, with its colour and how many points it is the mean of. Ends after the
/// duration or with ctrl-c, and writes the file either way.
#[derive(Debug, clap::Args)]
pub(super) struct MergeArgs {
    /// The cameras; all that have clouds if left out.
    #[arg(value_name = "CAMERA")]
    pub(super) cameras: Vec<String>,
    /// The file, binary PLY.
    #[arg(long, value_name = "FILE", default_value = "merged.ply")]
    pub(super) out: PathBuf,
    /// A second file, binary PCD.
    #[arg(long, value_name = "FILE")]
    pub(super) pcd: Option<PathBuf>,
    /// Stop after this long [default: with ctrl-c]
    #[arg(long, value_name = "SECONDS", value_parser = duration)]
    pub(super) duration: Option<Duration>,
    /// Edge of a voxel, m.
    #[arg(long, value_name = "M", default_value_t = 0.05)]
    pub(super) voxel_m: f64,
    /// Voxels kept at most, at 80 bytes each; those not seen for longest go.
    #[arg(long, value_name = "N", default_value_t = 2_000_000)]
    pub(super) max_voxels: usize,
    /// Leave out points nearer to the camera, m.
    #[arg(long, value_name = "M", default_value_t = 0.1)]
    pub(super) min_range_m: f32,
    /// Leave out points farther from the camera, m.
    #[arg(long, value_name = "M", default_value_t = 40.0)]
    pub(super) max_range_m: f32,
    /// Leave out of the file voxels with fewer points.
    #[arg(long, value_name = "N", default_value_t = 3)]
    pub(super) min_points: u32,
    /// Leave out of the file voxels seen in fewer clouds, as what moves leaves behind; 1 keeps all.
    #[arg(long, value_name = "N", default_value_t = 3)]
    pub(super) min_clouds: u32,
    #[arg(long, help = POSES_HELP, value_name = "CLOUDS=POSES", value_parser = pose_choice)]
    pub(super) poses: Vec<PoseChoice>,
    /// Place by the true poses of synthetic cameras, to compare with.
    #[arg(long)]
    pub(super) truth: bool,
    #[command(flatten)]
    pub(super) refinement: RefineArgs,
    /// Place all points of a cloud by one pose, to compare with.
    #[arg(long)]
    pub(super) no_compensation: bool,
}

/// Corrections by laying clouds over each other.
#[derive(Debug, clap::Args)]
pub(super) struct RefineArgs {
    /// Lay each camera's clouds over what the anchor sees, by registration with the pose as prior; refused where
    /// the geometry tells too little or contradicts the pose.
    #[arg(long)]
    pub(super) refine: bool,
    /// With --refine: the camera whose clouds stay where its poses place them [default: the first]
    #[arg(long, value_name = "CAMERA", requires = "refine")]
    pub(super) anchor: Option<String>,
    /// With --refine: offer what is found to the daemon, as fixes measured against the anchor.
    #[arg(long, requires = "refine", conflicts_with = "truth")]
    pub(super) aid: bool,
}

const POSES_HELP: &str = "Place the clouds of one camera by the poses of another on the same body, such as front=front_gyro; may be repeated";

/// By whose poses a camera's clouds are placed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct PoseChoice {
    pub(super) clouds: String,
    pub(super) poses: String,
}

fn pose_choice(text: &str) -> Result<PoseChoice, String> {
    match text.split_once('=') {
        Some((clouds, poses)) if !clouds.is_empty() && !poses.is_empty() => {
            Ok(PoseChoice { clouds: clouds.into(), poses: poses.into() })
        }
        _ => Err("allowed: two cameras, such as front=front_gyro".into()),
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum ClockName {
    /// Since the UNIX epoch, as cameras stamp images.
    Unix,
    #[value(help = "CLOCK_MONOTONIC, time since boot without suspend")]
    Monotonic,
}
