//! PLY: `x y z` as floats, `red green blue` as bytes if any point has a colour, `count` and
//! `cameras` as whole numbers.

use std::path::Path;

use ply_rs_bw::ply::{
    Addable, ElementDef, Encoding, Header, PropertyAccess, PropertyDef, PropertyType, ScalarType,
};
use ply_rs_bw::writer::Writer;

use super::GREY;
use super::file::{ExportError, write_whole};
use super::select::ExportPoint;

impl PropertyAccess for ExportPoint {
    fn new() -> Self {
        Self { position_m: [f32::NAN; 3], colour: None, count: 0, cameras: 0 }
    }

    fn get_float(&self, name: &str) -> Option<f32> {
        let axis = ["x", "y", "z"].iter().position(|axis| *axis == name)?;
        Some(self.position_m[axis])
    }

    fn get_uchar(&self, name: &str) -> Option<u8> {
        let channel = ["red", "green", "blue"].iter().position(|channel| *channel == name)?;
        Some(self.colour.unwrap_or(GREY)[channel])
    }

    fn get_uint(&self, name: &str) -> Option<u32> {
        (name == "count").then_some(self.count)
    }

    fn get_ushort(&self, name: &str) -> Option<u16> {
        (name == "cameras").then_some(self.cameras)
    }
}

/// Writes points as binary PLY, replacing the file.
///
/// # Errors
/// [`ExportError`]; then a file of that name is as it was.
pub fn write_ply(path: &Path, points: &[ExportPoint]) -> Result<(), ExportError> {
    let bytes = encoded(points)
        .map_err(|error| ExportError::Format { path: path.into(), what: error.to_string() })?;
    write_whole(path, &bytes)
}

/// Element by element: the crate's own model of a whole file would hold all points once more.
fn encoded(points: &[ExportPoint]) -> std::io::Result<Vec<u8>> {
    let element = element(points);
    let mut header = Header::new();
    header.encoding = Encoding::BinaryLittleEndian;
    header.comments.push(
        "Lodestone: x east, y north, z up, m; count: points of each voxel; cameras: a bit for each"
            .into(),
    );
    header.elements.add(element.clone());
    let mut bytes = Vec::new();
    let writer = Writer::new();
    writer.write_header(&mut bytes, &header)?;
    for point in points {
        writer.write_little_endian_element(&mut bytes, point, &element)?;
    }
    Ok(bytes)
}

fn element(points: &[ExportPoint]) -> ElementDef {
    let mut element = ElementDef::new("vertex".into());
    element.count = points.len();
    let mut add = |names: &[&str], kind: ScalarType| {
        for name in names {
            let kind = PropertyType::Scalar(kind.clone());
            element.properties.add(PropertyDef::new((*name).into(), kind));
        }
    };
    add(&["x", "y", "z"], ScalarType::Float);
    if points.iter().any(|point| point.colour.is_some()) {
        add(&["red", "green", "blue"], ScalarType::UChar);
    }
    add(&["count"], ScalarType::UInt);
    add(&["cameras"], ScalarType::UShort);
    element
}
