//! Why clouds cannot be merged as asked.

use super::camera::MOST_CAMERAS;
use super::grid::{LARGEST_VOXEL_M, SMALLEST_VOXEL_M};
use super::map::MOST_VOXELS;
use crate::error::CameraNameError;

/// Why a voxel map cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum VoxelMapError {
    /// An edge that makes no sense.
    #[error("voxels of {0} m; allowed: {SMALLEST_VOXEL_M} to {LARGEST_VOXEL_M} m")]
    VoxelSize(f64),
    /// A number that makes no sense.
    #[error("{0} voxels; allowed: 1 to {MOST_VOXELS}")]
    VoxelCount(usize),
}

/// Why clouds cannot be merged as asked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MergeError {
    /// A camera's name cannot be one.
    #[error(transparent)]
    Name(#[from] CameraNameError),
    /// The map cannot be made.
    #[error(transparent)]
    Map(#[from] VoxelMapError),
    /// Nothing to merge.
    #[error("no camera to merge clouds of")]
    NoCamera,
    /// More cameras than a voxel can remember.
    #[error("{0} cameras; allowed: up to {MOST_CAMERAS}")]
    TooManyCameras(usize),
    /// One camera twice.
    #[error("camera {0:?} is named twice")]
    Twice(String),
    /// Distances between which no point lies.
    #[error("points from {min_m} to {max_m} m; allowed: from 0 or more to something larger")]
    Range {
        /// Smallest distance, m.
        min_m: f32,
        /// Largest distance, m.
        max_m: f32,
    },
}
