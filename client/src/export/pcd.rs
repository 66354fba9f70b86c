//! PCD: `x y z` as floats, `rgb` as the float that PCL packs colours into if any point has one, `count`.

use std::io::{Cursor, Seek, Write};
use std::path::Path;

use pcd_rs::{
    DataKind, PcdSerialize, Schema, ValueKind, ViewPoint, Writer, WriterInit, rgb_to_float,
};

use super::GREY;
use super::file::{ExportError, write_whole};
use super::select::ExportPoint;

/// Writes points as binary PCD, replacing the file.
///
/// # Errors
/// [`ExportError`]; then a file of that name is as it was.
pub fn write_pcd(path: &Path, points: &[ExportPoint]) -> Result<(), ExportError> {
    let has_colour = points.iter().any(|point| point.colour.is_some());
    let encoded = if has_colour {
        encoded(points.iter().map(Coloured))
    } else {
        encoded(points.iter().map(Plain))
    };
    let bytes = encoded
        .map_err(|error| ExportError::Format { path: path.into(), what: error.to_string() })?;
    write_whole(path, &bytes)
}

/// Into memory: the crate's writer panics where a full disk keeps it from its end.
fn encoded<R: PcdSerialize>(points: impl ExactSizeIterator<Item = R>) -> pcd_rs::Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    let settings = WriterInit {
        width: points.len() as u64,
        height: 1,
        viewpoint: ViewPoint::default(),
        data_kind: DataKind::Binary,
        schema: None,
        version: None,
    };
    let mut writer: Writer<R, _> = settings.build_from_writer(&mut bytes)?;
    let pushed = points.into_iter().try_for_each(|point| writer.push(&point));
    writer.finish()?;
    pushed?;
    Ok(bytes.into_inner())
}

/// With `rgb`.
struct Coloured<'a>(&'a ExportPoint);

/// Without.
struct Plain<'a>(&'a ExportPoint);

const POSITION: [(&str, ValueKind, u64); 3] =
    [("x", ValueKind::F32, 1), ("y", ValueKind::F32, 1), ("z", ValueKind::F32, 1)];
const RGB: (&str, ValueKind, u64) = ("rgb", ValueKind::F32, 1);
const COUNT: (&str, ValueKind, u64) = ("count", ValueKind::U32, 1);

impl PcdSerialize for Coloured<'_> {
    fn is_dynamic() -> bool {
        false
    }

    fn write_spec() -> Schema {
        POSITION.into_iter().chain([RGB, COUNT]).collect()
    }

    fn write_chunk<W: Write + Seek>(&self, out: &mut W, _: &Schema) -> pcd_rs::Result<()> {
        let [r, g, b] = self.0.colour.unwrap_or(GREY);
        write_position(out, self.0)?;
        out.write_all(&rgb_to_float(r, g, b).to_le_bytes())?;
        Ok(out.write_all(&self.0.count.to_le_bytes())?)
    }

    fn write_line<W: Write + Seek>(&self, out: &mut W, _: &Schema) -> pcd_rs::Result<()> {
        let ([x, y, z], [r, g, b]) = (self.0.position_m, self.0.colour.unwrap_or(GREY));
        Ok(writeln!(out, "{x} {y} {z} {} {}", rgb_to_float(r, g, b), self.0.count)?)
    }
}

impl PcdSerialize for Plain<'_> {
    fn is_dynamic() -> bool {
        false
    }

    fn write_spec() -> Schema {
        POSITION.into_iter().chain([COUNT]).collect()
    }

    fn write_chunk<W: Write + Seek>(&self, out: &mut W, _: &Schema) -> pcd_rs::Result<()> {
        write_position(out, self.0)?;
        Ok(out.write_all(&self.0.count.to_le_bytes())?)
    }

    fn write_line<W: Write + Seek>(&self, out: &mut W, _: &Schema) -> pcd_rs::Result<()> {
        let [x, y, z] = self.0.position_m;
        Ok(writeln!(out, "{x} {y} {z} {}", self.0.count)?)
    }
}

fn write_position(out: &mut impl Write, point: &ExportPoint) -> std::io::Result<()> {
    point.position_m.iter().try_for_each(|axis| out.write_all(&axis.to_le_bytes()))
}
