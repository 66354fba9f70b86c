//! Clouds of several cameras laid into one map of the world.
//!
//! The way of a cloud: [`feed`](self) takes it from its stream and waits for its poses, `place` turns its
//! points into the world by the pose at each one's time ([`PlacedCloud`]), [`VoxelMap`] takes them in.
//! Between the last two a caller may look at the placed cloud and correct it.

mod camera;
mod epoch;
mod error;
mod feed;
mod grid;
mod lateness;
mod lenses;
mod map;
mod merger;
mod place;
#[cfg(test)]
pub(crate) mod samples;
mod table;
mod voxel;

pub use camera::{CameraMerge, PoseSource};
pub use error::{MergeError, VoxelMapError};
pub use feed::MergeCounts;
pub use lateness::Lateness;
pub use map::{MapCounts, VoxelMap, VoxelMapSettings};
pub use merger::{CloudMerger, CloudMergerBuilder};
pub use place::{PlacedCloud, PlacedPoint, PointCounts, Range};
pub use voxel::VoxelView;
