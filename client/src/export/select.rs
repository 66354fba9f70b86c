//! Which voxels of a map become points of a file.

use crate::merge::{VoxelMap, VoxelView};

/// What a voxel must have to be written.
///
/// What moves through the scene leaves a trail of voxels that were each seen briefly; asking for some clouds and
/// some points keeps most of it out, and the noise of single points too. A voxel that the camera itself passes
/// quickly is thinned out as well: 1 and 1 keep all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExportFilter {
    /// Fewest points seen in it; default 3.
    pub min_points: u32,
    /// Fewest clouds that it was seen in; default 3, 0.2 s at 15 Hz.
    pub min_clouds: u32,
}

impl Default for ExportFilter {
    fn default() -> Self {
        Self { min_points: 3, min_clouds: 3 }
    }
}

impl ExportFilter {
    /// Whether a voxel has enough.
    pub const fn admits(self, voxel: &VoxelView) -> bool {
        voxel.points >= self.min_points && voxel.clouds >= self.min_clouds
    }
}

/// A point as files hold it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExportPoint {
    /// In the world, m. f32 is exact to 1 mm up to 16 km from the origin.
    pub position_m: [f32; 3],
    /// Red, green, blue.
    pub colour: Option<[u8; 3]>,
    /// Points that it is the mean of.
    pub count: u32,
    /// Cameras that saw it, one bit for each in the merger's order.
    pub cameras: u16,
}

/// The points of a map's voxels that have enough, in no order.
pub fn export_points(map: &VoxelMap, filter: ExportFilter) -> Vec<ExportPoint> {
    let admitted = map.voxels().filter(|voxel| filter.admits(voxel));
    admitted
        .map(|voxel| ExportPoint {
            position_m: voxel.position_m.as_vec3().to_array(),
            colour: voxel.colour,
            count: voxel.points,
            cameras: voxel.cameras,
        })
        .collect()
}
