//! What the demo found, as it stands in `demo.json`.

use std::path::Path;

use lodestone_config::model::{self, Config};
use serde::Serialize;

use super::calibration::Expected;
use super::cloud_file::{self, ReadError, Voxel};
use super::headings::{HeadingError, RelativeErrors, heading_error, relative_errors};
use super::result::{Merge, Refinement, Seen, Variant};
use super::score::{Score, score};
use crate::scene::Scene;

/// Refined clouds are to be at most so many times as far from the truth as those by perfect poses.
const ALLOWED_RATIO: f64 = 1.3;
/// Headings are to differ by no more than this before refinement, degrees.
const ALLOWED_HEADING_DEG: f64 = 0.5;

/// Everything that was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// Seed of all that is random.
    pub seed: u64,
    /// Time that filters had to settle, s.
    pub settled_s: f64,
    /// Time that clouds were merged for, s.
    pub merged_s: f64,
    /// What each calibration expects of itself.
    pub calibration: Vec<Expected>,
    /// Each merge against the truth, in the order of the table.
    pub clouds: Vec<Row>,
    /// Each camera's heading against the truth.
    pub headings: Vec<HeadingError>,
    /// The second camera's pose as seen from the first, against the truth.
    pub relative: Option<RelativeErrors>,
    /// Clouds lost between source and consumer, all cameras.
    pub clouds_lost: u64,
    /// How ICP went.
    pub refinement: Refinement,
    /// What was to be reached, and what was.
    pub targets: Vec<Target>,
}

/// One merge against the truth.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Row {
    /// What was merged.
    #[serde(flatten)]
    pub merge: Merge,
    /// Its distances from the surfaces; `None` where nothing was merged.
    pub score: Option<Score>,
}

/// Something to be reached.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Target {
    /// For people.
    pub what: &'static str,
    /// Unit of the numbers, or nothing.
    pub unit: &'static str,
    /// What was measured; `None` if it could not be.
    pub measured: Option<f64>,
    /// The largest that is allowed.
    pub allowed: f64,
    /// Whether it was reached.
    pub met: bool,
}

impl Target {
    fn new(what: &'static str, unit: &'static str, measured: Option<f64>, allowed: f64) -> Self {
        Self { what, unit, measured, allowed, met: measured.is_some_and(|m| m <= allowed) }
    }
}

/// A merge with its points.
#[derive(Clone, Debug)]
pub struct Cloud {
    /// By whose poses.
    pub variant: Variant,
    /// Its voxels.
    pub voxels: Vec<Voxel>,
}

/// Reads the consumer's clouds.
///
/// # Errors
/// [`ReadError`].
pub fn clouds(out: &Path, seen: &Seen) -> Result<Vec<Cloud>, ReadError> {
    let read = |merge: &Merge| {
        let voxels = cloud_file::read(&out.join(merge.variant.file()))?;
        Ok(Cloud { variant: merge.variant, voxels })
    };
    seen.merges.iter().map(read).collect()
}

impl Outcome {
    /// Scores what the consumer saw.
    pub fn of(seed: u64, config: &Config, seen: &Seen, clouds: &[Cloud]) -> Self {
        let scene = Scene::new(config.scene.as_ref().unwrap_or(&model::Scene::default()));
        let rows: Vec<Row> = seen
            .merges
            .iter()
            .zip(clouds)
            .map(|(merge, cloud)| Row { merge: *merge, score: score(&cloud.voxels, &scene) })
            .collect();
        let relative = match &seen.cameras[..] {
            [first, second] => relative_errors(first, second),
            _ => None,
        };
        Self {
            seed,
            settled_s: seen.settled_s,
            merged_s: seen.merged_s,
            calibration: Vec::new(),
            targets: targets(&rows, relative.as_ref()),
            clouds: rows,
            headings: seen.cameras.iter().filter_map(heading_error).collect(),
            relative,
            clouds_lost: seen.cameras.iter().map(|camera| camera.lost).sum(),
            refinement: seen.refinement.clone(),
        }
    }

    /// How far a merge is from the truth, as many times as that by perfect poses.
    pub fn ratio(&self, variant: Variant) -> Option<f64> {
        ratio(&self.clouds, variant)
    }

    /// The score of a merge.
    pub fn score(&self, variant: Variant) -> Option<Score> {
        score_of(&self.clouds, variant)
    }
}

fn score_of(rows: &[Row], variant: Variant) -> Option<Score> {
    rows.iter().find(|row| row.merge.variant == variant)?.score
}

fn ratio(rows: &[Row], variant: Variant) -> Option<f64> {
    let rmse = |variant| Some(score_of(rows, variant)?.in_world.rmse_m);
    Some(rmse(variant)? / rmse(Variant::Perfect)?)
}

fn targets(rows: &[Row], relative: Option<&RelativeErrors>) -> Vec<Target> {
    let refined = ratio(rows, Variant::Refined);
    let heading = relative.map(|errors| errors.own.heading_deg.abs());
    vec![
        Target::new("RMSE after ICP against perfect poses", "times", refined, ALLOWED_RATIO),
        Target::new("headings differ before ICP by", "°", heading, ALLOWED_HEADING_DEG),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_target_that_could_not_be_measured_was_not_met() {
        assert!(Target::new("a", "°", Some(0.5), 0.5).met);
        assert!(!Target::new("a", "°", Some(0.51), 0.5).met);
        assert!(!Target::new("a", "°", None, 0.5).met);
        assert!(!Target::new("a", "°", Some(f64::NAN), 0.5).met);
    }
}
