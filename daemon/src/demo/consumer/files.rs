//! The consumer's files.

use std::fs;
use std::path::Path;

use super::ConsumerError;
use super::merges::Merges;
use crate::demo::result::Seen;

/// Name of the file with everything but points.
pub const REPORT: &str = "consumer.json";

/// Writes a cloud for each merge, and what was seen.
pub(super) fn write(out: &Path, merges: &Merges, seen: &Seen) -> Result<(), ConsumerError> {
    for merged in &merges.all {
        let path = out.join(merged.variant.file());
        let written = super::export::write_ply(&path, &merged.map);
        written.map_err(|e| ConsumerError::Write { path, what: e.to_string() })?;
    }
    let path = out.join(REPORT);
    let text = serde_json::to_string_pretty(seen).map_err(std::io::Error::other);
    let written = text.and_then(|text| fs::write(&path, text + "\n"));
    written.map_err(|e| ConsumerError::Write { path, what: e.to_string() })
}
