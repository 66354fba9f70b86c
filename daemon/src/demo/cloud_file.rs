//! The consumer's PLY files, read back: what is scored is what others get.

use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

use glam::DVec3;
use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

/// A voxel of a merged cloud.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Voxel {
    /// Mean of its points in the world, m.
    pub position_m: DVec3,
    /// Red, green, blue.
    pub colour: [u8; 3],
    /// Its points.
    pub points: u32,
    /// Cameras that saw it, bit n for the n-th.
    pub cameras: u32,
}

/// A file cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot be read: {source}", path.display())]
pub struct ReadError {
    /// The file.
    pub path: PathBuf,
    /// Why.
    pub source: io::Error,
}

/// All voxels of a file.
///
/// # Errors
/// [`ReadError`] if it is not there or no PLY file.
pub fn read(path: &Path) -> Result<Vec<Voxel>, ReadError> {
    let failed = |source| ReadError { path: path.into(), source };
    let mut file = BufReader::new(File::open(path).map_err(failed)?);
    let mut ply =
        Parser::<Voxel>::new().read_ply(&mut file).map_err(io::Error::other).map_err(failed)?;
    Ok(ply.payload.swap_remove("vertex").unwrap_or_default())
}

impl PropertyAccess for Voxel {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        match (name, value) {
            ("x", Property::Float(x)) => self.position_m.x = x.into(),
            ("y", Property::Float(y)) => self.position_m.y = y.into(),
            ("z", Property::Float(z)) => self.position_m.z = z.into(),
            ("red", Property::UChar(red)) => self.colour[0] = red,
            ("green", Property::UChar(green)) => self.colour[1] = green,
            ("blue", Property::UChar(blue)) => self.colour[2] = blue,
            ("count", Property::UInt(count)) => self.points = count,
            ("cameras", Property::UShort(cameras)) => self.cameras = cameras.into(),
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_voxel_is_read_with_all_that_it_has_and_what_is_unknown_is_passed_over() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.ply");
        let text = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n\
                    property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
                    property float shininess\nproperty uint count\nproperty ushort cameras\nend_header\n\
                    1.5 -2 0.25 10 20 30 0.1 7 3\n0 0 0 0 0 0 0 1 1\n";
        std::fs::write(&path, text).unwrap();
        let voxels = read(&path).unwrap();
        let position_m = DVec3::new(1.5, -2.0, 0.25);
        let first = Voxel { position_m, colour: [10, 20, 30], points: 7, cameras: 3 };
        assert_eq!((voxels.len(), voxels[0]), (2, first));
    }

    #[test]
    fn what_is_no_cloud_says_which_file() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("b.ply");
        assert!(read(&path).unwrap_err().to_string().contains("b.ply"));
        std::fs::write(&path, "solid").unwrap();
        assert!(read(&path).is_err());
    }
}
