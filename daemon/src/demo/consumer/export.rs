//! A map as a PLY file.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use lodestone_client::VoxelMap;

pub(super) fn write_ply(path: &Path, map: &VoxelMap) -> io::Result<()> {
    let mut out = BufWriter::new(File::create(path)?);
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
         property uint count\nproperty ushort cameras\nend_header\n",
        map.len()
    )?;
    for voxel in map.voxels() {
        for coordinate in voxel.position_m.to_array() {
            out.write_all(&(coordinate as f32).to_le_bytes())?;
        }
        out.write_all(&voxel.colour.unwrap_or([128; 3]))?;
        out.write_all(&voxel.points.to_le_bytes())?;
        out.write_all(&voxel.cameras.to_le_bytes())?;
    }
    out.flush()
}
