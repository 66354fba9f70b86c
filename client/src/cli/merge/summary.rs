//! What is said in the end.

use std::path::Path;

use lodestone_client::{CloudMerger, ExportPoint, Lateness, LensPlace};
use serde::Serialize;

use super::super::args::MergeArgs;
use super::super::table::aligned;
use super::refine::Refining;
use super::refine_line::RefineLine;

/// All of it, as one JSON object.
#[derive(Debug, Serialize)]
pub(super) struct Summary {
    cameras: Vec<CameraLine>,
    map: MapLine,
    files: Vec<FileLine>,
}

/// What became of one camera's clouds; `null` stands for what is unknown.
#[derive(Debug, Serialize)]
struct CameraLine {
    camera: String,
    poses: String,
    clouds: u64,
    points: u64,
    points_without_depth: u64,
    points_out_of_range: u64,
    points_out_of_time: u64,
    clouds_without_pose: u64,
    clouds_of_past_world: u64,
    clouds_lost: u64,
    clouds_invalid: u64,
    source_restarts: u64,
    /// From published to merged.
    late_p50_s: Option<f64>,
    late_p99_s: Option<f64>,
    behind: bool,
    lens_configured: Option<bool>,
    without_pose_because: Option<String>,
    /// `null` without `--refine`, and for the anchor.
    refinement: Option<RefineLine>,
}

#[derive(Debug, Serialize)]
struct MapLine {
    voxels: usize,
    voxel_m: f64,
    max_voxels: usize,
    evicted: u64,
    points_beyond_grid: u64,
    bytes: usize,
    world_epoch: Option<u32>,
    begun_anew: u64,
}

/// A file that was written.
#[derive(Clone, Debug, Serialize)]
pub(super) struct FileLine {
    path: String,
    points: usize,
    from_m: [f32; 3],
    to_m: [f32; 3],
}

impl FileLine {
    pub(super) fn new(path: &Path, points: &[ExportPoint]) -> Self {
        let extreme = |start: f32, of: fn(f32, f32) -> f32| {
            [0, 1, 2].map(|axis| points.iter().map(|p| p.position_m[axis]).fold(start, of))
        };
        Self {
            path: path.display().to_string(),
            points: points.len(),
            from_m: extreme(f32::INFINITY, f32::min),
            to_m: extreme(f32::NEG_INFINITY, f32::max),
        }
    }
}

impl Summary {
    pub(super) fn new(
        merger: &CloudMerger,
        refining: Option<&Refining>,
        args: &MergeArgs,
        written: &[FileLine],
    ) -> Self {
        let map = merger.map();
        let camera = |i| CameraLine::new(merger, refining, i);
        Self {
            cameras: (0..merger.cameras().len()).map(camera).collect(),
            map: MapLine {
                voxels: map.len(),
                voxel_m: args.voxel_m,
                max_voxels: args.max_voxels,
                evicted: map.counts().evicted,
                points_beyond_grid: map.counts().beyond_grid,
                bytes: map.bytes(),
                world_epoch: merger.world_epoch(),
                begun_anew: merger.begun_anew(),
            },
            files: written.to_vec(),
        }
    }

    /// For people.
    pub(super) fn to_lines(&self) -> Vec<String> {
        let mut rows = vec![TITLES.map(str::to_owned)];
        rows.extend(self.cameras.iter().map(CameraLine::cells));
        let mut lines = aligned(&rows);
        lines.extend(self.cameras.iter().filter_map(CameraLine::refinement));
        let map = &self.map;
        lines.push(format!(
            "{} voxels of {} m, {} forgotten for want of room; {} MB for {} at most",
            map.voxels,
            map.voxel_m,
            map.evicted,
            map.bytes / 1_000_000,
            map.max_voxels
        ));
        let metres = |m: &[f32; 3]| format!("[{:.2} {:.2} {:.2}]", m[0], m[1], m[2]);
        lines.extend(self.files.iter().map(|file| {
            let (from, to) = (metres(&file.from_m), metres(&file.to_m));
            format!("{}: {} points, {from} to {to} m", file.path, file.points)
        }));
        lines.extend(self.problems().into_iter().map(|problem| format!("  ! {problem}")));
        lines
    }

    fn problems(&self) -> Vec<String> {
        let mut problems: Vec<String> =
            self.cameras.iter().flat_map(CameraLine::problems).collect();
        if self.map.begun_anew > 0 {
            let times = self.map.begun_anew;
            problems.push(format!("the world was defined anew, so was the map: {times} times"));
        }
        if self.map.points_beyond_grid > 0 {
            let points = self.map.points_beyond_grid;
            problems.push(format!("{points} points are too far from the origin: larger --voxel-m"));
        }
        problems
    }
}

const TITLES: [&str; 10] = [
    "camera",
    "poses",
    "clouds",
    "points",
    "no depth",
    "out of range",
    "no pose",
    "lost",
    "invalid",
    "late p50/p99 ms",
];

impl CameraLine {
    fn new(merger: &CloudMerger, refining: Option<&Refining>, index: usize) -> Self {
        let (counts, lateness) = (merger.counts(index), merger.lateness(index));
        let setup = merger.cameras().nth(index);
        let refused = merger.refused(index).filter(|_| counts.without_pose > 0);
        Self {
            camera: setup.map(|setup| setup.camera.clone()).unwrap_or_default(),
            poses: setup.map(|setup| setup.poses.camera().to_owned()).unwrap_or_default(),
            clouds: counts.clouds,
            points: counts.points.placed,
            points_without_depth: counts.points.without_depth,
            points_out_of_range: counts.points.out_of_range,
            points_out_of_time: counts.points.out_of_time,
            clouds_without_pose: counts.without_pose,
            clouds_of_past_world: counts.past_world,
            clouds_lost: counts.lost,
            clouds_invalid: counts.invalid,
            source_restarts: counts.restarts,
            late_p50_s: seconds(lateness, 0.5),
            late_p99_s: seconds(lateness, 0.99),
            behind: counts.lost > 0,
            lens_configured: merger.lens(index).map(|place| place == LensPlace::Configured),
            without_pose_because: refused.map(ToString::to_string),
            refinement: refining.and_then(|refining| RefineLine::new(refining, index)),
        }
    }

    fn cells(&self) -> [String; TITLES.len()] {
        let ms = |s: Option<f64>| s.map_or_else(|| "-".into(), |s| format!("{:.1}", s * 1e3));
        [
            self.camera.clone(),
            self.poses.clone(),
            self.clouds.to_string(),
            self.points.to_string(),
            self.points_without_depth.to_string(),
            self.points_out_of_range.to_string(),
            self.clouds_without_pose.to_string(),
            self.clouds_lost.to_string(),
            self.clouds_invalid.to_string(),
            format!("{}/{}", ms(self.late_p50_s), ms(self.late_p99_s)),
        ]
    }

    /// Of a camera that was registered.
    fn refinement(&self) -> Option<String> {
        self.refinement.as_ref().map(|line| line.sentence(&self.camera))
    }

    fn problems(&self) -> Vec<String> {
        let camera = &self.camera;
        let of_refinement = self.refinement.iter().flat_map(RefineLine::problems);
        let mut problems: Vec<String> =
            of_refinement.map(|what| format!("{camera}: {what}")).collect();
        let mut say = |is_so: bool, what: String| {
            if is_so {
                problems.push(format!("{camera}: {what}"));
            }
        };
        say(self.behind, format!("fell behind: {} clouds lost", self.clouds_lost));
        let because = self.without_pose_because.as_deref().unwrap_or_default();
        say(self.clouds_without_pose > 0, format!("clouds without pose, the last: {because}"));
        let late = self.points_out_of_time;
        say(late > 0, format!("{late} points over 256 ms from their cloud's time, left out"));
        say(self.clouds_of_past_world > 0, "clouds of a world that was over".into());
        say(
            self.lens_configured == Some(false),
            "the lens's place is not configured and counts as at the IMU (camera.lens_position_m)"
                .into(),
        );
        problems
    }
}

fn seconds(lateness: &Lateness, share: f64) -> Option<f64> {
    lateness.quantile(share).map(|late| late.as_secs_f64())
}

/// Why a map is empty.
pub(super) fn why_nothing(merger: &CloudMerger) -> String {
    let reasons = merger.cameras().enumerate().map(|(index, setup)| {
        let counts = merger.counts(index);
        let camera = &setup.camera;
        match (merger.refused(index), merger.clouds(index).connection_error()) {
            (Some(error), _) => {
                format!("{camera}: {} clouds without pose: {error}", counts.without_pose)
            }
            (None, Some(error)) => format!("{camera}: {error}"),
            (None, None) if counts.clouds > 0 => {
                format!("{camera}: no point of {} clouds is in range", counts.clouds)
            }
            (None, None) => format!("{camera}: no cloud came"),
        }
    });
    format!("nothing was merged; {}", reasons.collect::<Vec<_>>().join("; "))
}
