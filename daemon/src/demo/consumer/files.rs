//! The consumer's files.

use std::fs;
use std::path::Path;

use lodestone_client::{ExportFilter, export_points, write_ply};

use super::ConsumerError;
use super::merges::Merges;
use crate::demo::result::Seen;

/// Name of the file with everything but points.
pub const REPORT: &str = "consumer.json";

/// Every voxel: what is scored is all that was merged.
const ALL: ExportFilter = ExportFilter { min_points: 1, min_clouds: 1 };

/// Writes a cloud for each merge, and what was seen.
pub(super) fn write(out: &Path, merges: &Merges, seen: &Seen) -> Result<(), ConsumerError> {
    for merged in &merges.all {
        let path = out.join(merged.variant.file());
        let written = write_ply(&path, &export_points(&merged.map, ALL));
        written.map_err(|e| ConsumerError::Write { path, what: e.to_string() })?;
    }
    let path = out.join(REPORT);
    let text = serde_json::to_string_pretty(seen).map_err(std::io::Error::other);
    let written = text.and_then(|text| fs::write(&path, text + "\n"));
    written.map_err(|e| ConsumerError::Write { path, what: e.to_string() })
}
