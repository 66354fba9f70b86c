//! Maps as files that other programs open: PLY and PCD, both binary, both in the world's axes.

mod file;
mod pcd;
mod ply;
mod select;

pub use file::ExportError;
pub use pcd::write_pcd;
pub use ply::write_ply;
pub use select::{ExportFilter, ExportPoint, export_points};

/// Stands for a colour that nobody gave, in a file whose other points have one.
const GREY: [u8; 3] = [128; 3];

#[cfg(test)]
mod tests;
