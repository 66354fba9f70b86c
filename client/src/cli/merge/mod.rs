//! `lodestone merge`: the clouds of cameras, live, into one file.

mod progress;
mod refine;
mod refine_line;
mod summary;

use std::time::{Duration, Instant};

use lodestone_client::{
    CameraMerge, CloudMerger, ExportFilter, PoseSource, Range, VoxelMapSettings, export_points,
    write_pcd, write_ply,
};

use super::args::MergeArgs;
use super::failure::Failure;
use super::output::Output;
use super::session::Session;
use progress::Progress;
use refine::Refining;
use summary::{FileLine, Summary};

/// A signal is noticed, and progress shown, no later than this.
const LONGEST_WAIT: Duration = Duration::from_millis(20);

pub(super) fn run(session: &Session, args: &MergeArgs) -> Result<(), Failure> {
    let cameras = session.cameras_with_clouds(&args.cameras)?;
    let mut merger = open(session, args, &cameras)?;
    let mut refining = Refining::open(session, args, &merger)?;
    merge(session, args, &mut merger, refining.as_mut());
    let written = write(args, &merger)?;
    show(session, &Summary::new(&merger, refining.as_ref(), args, &written))
}

fn open(session: &Session, args: &MergeArgs, cameras: &[String]) -> Result<CloudMerger, Failure> {
    if let Some(other) = args.poses.iter().find(|choice| !cameras.contains(&choice.clouds)) {
        let there = cameras.join(", ");
        let what = format!(
            "--poses: no clouds of camera {:?} are merged; there are: {there}",
            other.clouds
        );
        return Err(Failure::Usage(what));
    }
    let size = VoxelMapSettings { voxel_m: args.voxel_m, max_voxels: args.max_voxels };
    let range = Range { min_m: args.min_range_m, max_m: args.max_range_m };
    let merger = session.client.merger().map(size).range(range).compensate(!args.no_compensation);
    let add = |merger: lodestone_client::CloudMergerBuilder, camera: &String| {
        merger.camera(CameraMerge::new(camera).by(pose_source(args, camera)))
    };
    Ok(cameras.iter().fold(merger, add).open()?)
}

fn pose_source(args: &MergeArgs, camera: &str) -> PoseSource {
    let chosen = args.poses.iter().find(|choice| choice.clouds == camera);
    let poses = chosen.map_or(camera, |choice| &choice.poses).to_owned();
    if args.truth { PoseSource::Truth(poses) } else { PoseSource::Estimate(poses) }
}

/// Merges until the time is over or the user stops.
fn merge(
    session: &Session,
    args: &MergeArgs,
    merger: &mut CloudMerger,
    mut refining: Option<&mut Refining>,
) {
    let begin = Instant::now();
    let mut progress = Progress::new(begin, args.duration);
    let is_over = || args.duration.is_some_and(|duration| begin.elapsed() >= duration);
    while !session.stop.asked() && !is_over() {
        if let Some(cloud) = merger.wait(LONGEST_WAIT) {
            match &mut refining {
                Some(refining) => refining.insert(merger, cloud),
                None => merger.insert(cloud),
            }
        }
        progress.show_if_due(merger);
    }
    progress.end();
}

/// Writes the files; a map in which nothing is worth writing is a failure that says why.
fn write(args: &MergeArgs, merger: &CloudMerger) -> Result<Vec<FileLine>, Failure> {
    if merger.map().is_empty() {
        return Err(Failure::Other(summary::why_nothing(merger)));
    }
    let filter = ExportFilter { min_points: args.min_points, min_clouds: args.min_clouds };
    let points = export_points(merger.map(), filter);
    if points.is_empty() {
        return Err(Failure::Other(format!(
            "none of {} voxels was seen in {} clouds with {} points: merge for longer, or ask for less by --min-clouds and --min-points",
            merger.map().len(),
            args.min_clouds,
            args.min_points
        )));
    }
    write_ply(&args.out, &points)?;
    let mut written = vec![FileLine::new(&args.out, &points)];
    if let Some(pcd) = &args.pcd {
        write_pcd(pcd, &points)?;
        written.push(FileLine::new(pcd, &points));
    }
    Ok(written)
}

fn show(session: &Session, summary: &Summary) -> Result<(), Failure> {
    let mut output = Output::new();
    if session.json {
        return output.json(summary);
    }
    summary.to_lines().iter().try_for_each(|line| output.line(line))
}
