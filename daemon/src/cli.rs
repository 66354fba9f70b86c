//! The command line of `lodestoned`.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Parser, Subcommand, ValueEnum};

/// Tells every process on a vehicle where each of its cameras is and which way it looks.
///
/// Exit codes: 0 good, 2 wrong usage or configuration, 1 anything else.
#[derive(Debug, Parser)]
#[command(name = "lodestoned", version, max_term_width = 100)]
pub struct Cli {
    /// Configuration file; without it, two synthetic cameras in a room
    #[arg(long, value_name = "FILE", global = true)]
    pub config: Option<PathBuf>,

    /// What to log, as in `RUST_LOG`: info, or `lodestone_daemon=debug,warn`
    #[arg(long, value_name = "FILTER", global = true)]
    pub log: Option<String>,

    /// End when the process with this number does; for processes that `demo` starts
    #[arg(long, value_name = "PID", global = true, hide = true)]
    pub with_parent: Option<i32>,

    /// What to do; `run` if nothing is said
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// What the daemon can be asked to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Publish the poses of all configured cameras until SIGINT or SIGTERM (the default)
    Run(RunArgs),
    /// Validate a configuration and say what it means
    Check(CheckArgs),
    /// Turn recordings into poses, through the same lane, as fast as it goes
    Replay(ReplayArgs),
    /// Measure how good it is, in the synthetic world, by the paper's tables and figures
    ///
    /// Without `static` or `dynamic` it does both. Into --out go report.html, one self-contained page, and
    /// report.json with all numbers; both hold what was evaluated and replace what was there.
    Evaluate(EvaluateArgs),
    /// Find the errors of a camera's sensors while it is turned, or from a recording
    Calibrate(CalibrateArgs),
    /// Be the depth source of synthetic cameras: publish clouds of what they see of the scene
    Depth(DepthArgs),
    /// See the clouds of two cameras fit: daemon, depth sources and a consumer in the synthetic world
    Demo(DemoArgs),
    /// The demo's consumer, a process of its own
    #[command(hide = true)]
    DemoConsumer(DemoConsumerArgs),
}

/// Options of `demo`.
#[derive(Clone, Debug, Args)]
pub struct DemoArgs {
    /// Directory for the clouds, the picture, the numbers and the logs; files of an earlier demo are
    /// overwritten
    #[arg(long, value_name = "DIR", default_value = "demo")]
    pub out: PathBuf,

    /// How long clouds are merged
    #[arg(long, value_name = "S", default_value = "20", value_parser = duration)]
    pub duration: Duration,

    /// Seed of noise, biases and survey; another one is another pair of cameras
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,

    /// Print the numbers as JSON instead of the table
    #[arg(long)]
    pub json: bool,
}

/// Options of the demo's consumer.
#[derive(Clone, Debug, Args)]
pub struct DemoConsumerArgs {
    /// Directory for its files
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,

    /// How long clouds are merged
    #[arg(long, value_name = "S", value_parser = duration)]
    pub duration: Duration,

    /// How long filters settle before that
    #[arg(long, value_name = "S", value_parser = duration)]
    pub settle: Duration,
}

/// Options of `evaluate`: those of both parts, or one part with its own.
#[derive(Clone, Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct EvaluateArgs {
    /// One part alone.
    #[command(subcommand)]
    pub part: Option<EvaluatePart>,

    /// Where the report goes.
    #[command(flatten)]
    pub report: ReportArgs,

    /// Options of the static part.
    #[command(flatten)]
    pub statics: StaticOptions,

    /// Options of the dynamic part.
    #[command(flatten)]
    pub dynamic: DynamicOptions,
}

/// What can be evaluated alone.
#[derive(Clone, Debug, Subcommand)]
pub enum EvaluatePart {
    /// How much calibration steadies the magnetometer: the paper's six places, or your own
    Static(StaticArgs),
    /// How far positions drift and orientations wander: at rest, in motion, on the paper's stairs
    Dynamic(DynamicArgs),
}

/// Options of `evaluate static`.
#[derive(Clone, Debug, Args)]
pub struct StaticArgs {
    /// Where the report goes.
    #[command(flatten)]
    pub report: ReportArgs,

    /// What is evaluated.
    #[command(flatten)]
    pub options: StaticOptions,
}

/// Options of `evaluate dynamic`.
#[derive(Clone, Debug, Args)]
pub struct DynamicArgs {
    /// Where the report goes.
    #[command(flatten)]
    pub report: ReportArgs,

    /// What is evaluated.
    #[command(flatten)]
    pub options: DynamicOptions,
}

/// Options of every evaluation.
#[derive(Clone, Debug, Args)]
pub struct ReportArgs {
    /// Directory for report.html and report.json
    #[arg(long, value_name = "DIR", default_value = "evaluation")]
    pub out: PathBuf,

    /// Seed of everything simulated; the same seed gives the same report
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,

    /// Print the numbers as JSON instead of tables
    #[arg(long)]
    pub json: bool,
}

/// What the static part evaluates.
#[derive(Clone, Debug, Args)]
pub struct StaticOptions {
    /// How long the first place's camera stands for the Allan deviation
    #[arg(long, value_name = "S", default_value = "3600", value_parser = rest)]
    pub rest: Duration,

    /// Configuration with synthetic cameras to evaluate instead of the paper's places; repeatable
    #[arg(long, value_name = "FILE")]
    pub scenario: Vec<PathBuf>,
}

/// What the dynamic part evaluates.
#[derive(Clone, Debug, Args)]
pub struct DynamicOptions {
    /// Runs of each scene, each with another unit of the camera and another walker
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub runs: u32,

    /// Recording with a truth (columns qw qx qy qz, or px py), .csv or .csv.zst, to score as well;
    /// repeatable
    #[arg(long, value_name = "FILE")]
    pub recording: Vec<PathBuf>,

    /// What carried the recorded sensors
    #[arg(long, value_enum, value_name = "PRESET", default_value = "carried")]
    pub preset: PresetArg,
}

/// Options of `run`.
#[derive(Clone, Debug, Default, Args)]
pub struct RunArgs {
    /// Stop after this many seconds
    #[arg(long, value_name = "S", value_parser = duration)]
    pub duration: Option<Duration>,
}

/// Options of `depth`.
#[derive(Clone, Debug, Args)]
pub struct DepthArgs {
    /// Synthetic camera of the configuration; repeatable
    #[arg(long, value_name = "NAME", required = true)]
    pub camera: Vec<String>,

    /// Stop after this many seconds
    #[arg(long, value_name = "S", value_parser = duration)]
    pub duration: Option<Duration>,
}

/// Options of `check`.
#[derive(Clone, Debug, Default, Args)]
pub struct CheckArgs {
    /// Print every key with its unit, default and range
    #[arg(long)]
    pub explain: bool,

    /// Print it as JSON
    #[arg(long, requires = "explain")]
    pub json: bool,
}

/// Options of `replay`.
#[derive(Clone, Debug, Args)]
pub struct ReplayArgs {
    /// Recordings, .csv or .csv.zst; without any, those of the configuration's cameras with driver
    /// "replay", all together, rigs fused
    #[arg(value_name = "FILE")]
    pub files: Vec<PathBuf>,

    /// Directory for the poses, one .csv for each recording, or for each camera and body
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,

    /// Calibration to apply; its serial must be that of --serial or of the configured camera, where
    /// there is one
    #[arg(long, value_name = "FILE")]
    pub calibration: Option<PathBuf>,

    /// Serial number of the camera that made the recordings
    #[arg(long, value_name = "N", value_parser = serial())]
    pub serial: Option<u64>,

    /// What carried the sensor; goes before `estimator.preset` of the configuration
    #[arg(long, value_enum, value_name = "PRESET")]
    pub preset: Option<PresetArg>,

    /// Axes of the world that poses are written in [default: enu, with the preset foot auto]
    #[arg(long, value_enum, value_name = "FRAME")]
    pub frame: Option<WorldAxes>,

    /// 1 is real speed, 2 twice as fast, 0 as fast as it goes
    #[arg(long, value_name = "X", default_value = "0", value_parser = speed)]
    pub speed: f64,
}

/// What carried a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PresetArg {
    /// A vehicle or a hand
    Carried,
    /// A foot: position by zero velocity in each stance
    Foot,
}

/// Axes of the world that poses are written in; body axes are always the recording's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum WorldAxes {
    /// x east, y north, z up
    Enu,
    /// x north, y east, z down
    Ned,
    /// z points to where the recording's body z axis points in the alignment: up as enu, down, as in
    /// aerospace axes, as ned
    Auto,
}

/// Options of `calibrate`.
#[derive(Clone, Debug, Args)]
pub struct CalibrateArgs {
    /// Recording, .csv or .csv.zst; without it, --camera
    #[arg(value_name = "RECORDING", required_unless_present = "camera")]
    pub recording: Option<PathBuf>,

    /// Serial number of a configured camera, to calibrate it live
    #[arg(long, value_name = "SERIAL", conflicts_with = "recording", value_parser = serial())]
    pub camera: Option<u64>,

    /// Serial number of the camera that made the recording
    #[arg(long, value_name = "N", conflicts_with = "camera", value_parser = serial())]
    pub serial: Option<u64>,

    /// Calibration file to write [default: calibration-SERIAL.toml]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,

    /// Overwrite the file
    #[arg(long)]
    pub force: bool,

    /// How the camera is mounted, for people who read the file
    #[arg(long, value_name = "TEXT")]
    pub mounting: Option<String>,

    /// Live: end by itself at this expected heading σ, degrees
    #[arg(long, value_name = "DEG", default_value = "0.3", value_parser = degrees)]
    pub sigma: f64,

    /// Live: end after this many seconds with what is there
    #[arg(long, value_name = "S", value_parser = duration)]
    pub duration: Option<Duration>,

    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// What a calibration file may be bound to: 0 stands for none, and TOML has signed numbers.
fn serial() -> clap::builder::RangedU64ValueParser {
    clap::value_parser!(u64).range(1..=i64::MAX as u64)
}

fn degrees(text: &str) -> Result<f64, String> {
    let degrees: f64 = text.parse().map_err(|_| "not a number; allowed: above 0 to 180")?;
    let allowed = degrees > 0.0 && degrees <= 180.0;
    allowed.then_some(degrees).ok_or_else(|| "allowed: above 0 to 180".into())
}

fn duration(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| "not a number; allowed: seconds above 0")?;
    let duration = Duration::try_from_secs_f64(seconds).ok().filter(|d| !d.is_zero());
    duration.ok_or_else(|| "allowed: seconds above 0".into())
}

fn rest(text: &str) -> Result<Duration, String> {
    let allowed = Duration::from_secs(1)..=Duration::from_hours(10);
    let seconds = duration(text).ok().filter(|seconds| allowed.contains(seconds));
    seconds.ok_or_else(|| "allowed: 1 to 36000 seconds".into())
}

fn speed(text: &str) -> Result<f64, String> {
    let speed: f64 = text.parse().map_err(|_| "not a number; allowed: 0 or more")?;
    let allowed = speed.is_finite() && speed >= 0.0;
    allowed.then_some(speed).ok_or_else(|| "allowed: 0 or more".into())
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    fn parse(line: &str) -> Result<Cli, clap::Error> {
        Cli::try_parse_from(line.split_whitespace())
    }

    #[test]
    fn the_definition_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn options_may_stand_before_and_after_the_command() {
        for line in ["lodestoned --config a.toml run", "lodestoned run --config a.toml"] {
            let cli = parse(line).unwrap();
            assert_eq!(cli.config, Some("a.toml".into()), "{line}");
        }
        assert!(parse("lodestoned").unwrap().command.is_none());
    }

    #[test]
    fn values_out_of_range_are_wrong_usage() {
        for line in [
            "lodestoned run --duration 0",
            "lodestoned run --duration -1",
            "lodestoned run --duration nan",
            "lodestoned run --duration 1e300",
            "lodestoned replay a.csv --out d --speed -1",
            "lodestoned replay a.csv --out d --speed inf",
            "lodestoned replay a.csv",
            "lodestoned replay a.csv --out d --preset hand",
            "lodestoned replay a.csv --out d --frame flu",
            "lodestoned evaluate --rest 0.5",
            "lodestoned evaluate thermal",
            "lodestoned evaluate dynamic --runs 0",
            "lodestoned evaluate dynamic --runs 1001",
            "lodestoned evaluate dynamic --rest 20",
            "lodestoned evaluate static --runs 3",
            "lodestoned evaluate static --rest 0.5",
            "lodestoned evaluate static --rest 1e6",
            "lodestoned evaluate static --seed -1",
            "lodestoned calibrate",
            "lodestoned calibrate a.csv --camera 7",
            "lodestoned calibrate --camera 7 --serial 7",
            "lodestoned calibrate a.csv --serial 0",
            "lodestoned calibrate a.csv --serial 9223372036854775808",
            "lodestoned calibrate --camera 7 --sigma 0",
            "lodestoned calibrate --camera 7 --sigma nan",
            "lodestoned depth",
            "lodestoned depth --camera",
            "lodestoned depth --camera front --duration 0",
            "lodestoned fly",
        ] {
            assert_eq!(parse(line).unwrap_err().exit_code(), 2, "{line}");
        }
    }
}
