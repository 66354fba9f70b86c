//! Poses as CSV, one row for each row of a recording.
//!
//! Every field is a plain decimal number with a fixed number of decimals, or empty where the value
//! is not known; the same poses give the same bytes.
//!
//! | column | unit | |
//! |---|---|---|
//! | `t` | s | the recording's time, 9 decimals |
//! | `px py pz` | m | position in the world (east, north, up) |
//! | `qw qx qy qz` | | rotation body to world, Hamilton, unit |
//! | `vx vy vz` | m/s | velocity in the world |
//! | `heading_sigma_deg` `tilt_sigma_deg` | ° | standard deviation of heading, and of roll and pitch |
//! | `velocity_sigma_m_s` `position_sigma_m` | m/s, m | standard deviation of the worst axis |
//! | `status` `validity` | | bits as in the shared-memory schema |
//! | `heading_source` `position_source` | | codes as in the shared-memory schema |

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use glam::DVec3;
use lodestone_fusion::{Body, Rotation, SensorTime, World};
use lodestone_schema::{HeadingSource, PositionSource, Status, Validity};

use crate::csv_file::CsvFile;

/// The first line.
pub const HEADER: &str = "t,px,py,pz,qw,qx,qy,qz,vx,vy,vz,heading_sigma_deg,tilt_sigma_deg,\
     velocity_sigma_m_s,position_sigma_m,status,validity,heading_source,position_source\n";

/// One row; a value that is `None` or not finite is written as unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseRow {
    /// Time of the recording's row.
    pub time: SensorTime,
    /// Position of the body in the world, m.
    pub position_m: Option<DVec3>,
    /// Rotation body to world.
    pub orientation: Option<Rotation<World, Body>>,
    /// Velocity of the body in the world, m/s.
    pub velocity_m_s: Option<DVec3>,
    /// Standard deviation of the heading, degrees.
    pub heading_sigma_deg: Option<f64>,
    /// Standard deviation of roll and pitch, the larger, degrees.
    pub tilt_sigma_deg: Option<f64>,
    /// Standard deviation of the velocity's worst axis, m/s.
    pub velocity_sigma_m_s: Option<f64>,
    /// Standard deviation of the position's worst axis, m.
    pub position_sigma_m: Option<f64>,
    /// What the lane says.
    pub status: Status,
    /// What is usable.
    pub validity: Validity,
    /// Where the heading comes from.
    pub heading_source: HeadingSource,
    /// Where the position comes from.
    pub position_source: PositionSource,
}

/// Why poses could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot write poses: {source}", path.display())]
pub struct PosesError {
    /// The file.
    pub path: PathBuf,
    /// What the system said.
    pub source: io::Error,
}

/// Writes poses to a file; allocates nothing after it was made.
#[derive(Debug)]
pub struct PosesWriter {
    file: CsvFile,
    line: Vec<u8>,
}

impl PosesWriter {
    /// Makes the file, or empties the one that is there, and writes the header.
    ///
    /// # Errors
    /// [`PosesError`] if the file cannot be made.
    pub fn create(path: &Path) -> Result<Self, PosesError> {
        Ok(Self { file: CsvFile::create(path, HEADER)?, line: Vec::with_capacity(1024) })
    }

    /// Writes one row.
    ///
    /// # Errors
    /// [`PosesError`] if the buffer was full and the file took no more.
    pub fn write(&mut self, row: &PoseRow) -> Result<(), PosesError> {
        self.line.clear();
        append(&mut self.line, row);
        self.file.write(&self.line)
    }

    /// Hands all rows to the system; without it, a full disk goes unnoticed.
    ///
    /// # Errors
    /// [`PosesError`] if the file does not take them.
    pub fn finish(self) -> Result<(), PosesError> {
        self.file.finish()
    }
}

/// Appends a row and its line end.
fn append(line: &mut Vec<u8>, row: &PoseRow) {
    append_nanos_as_seconds(line, row.time.as_nanos());
    append_vector(line, row.position_m, 6);
    let quaternion = row.orientation.map(Rotation::quaternion);
    let parts = quaternion.map(|q| [q.w, q.x, q.y, q.z]);
    (0..4).for_each(|at| append_field(line, parts.map(|parts| parts[at]), 9));
    append_vector(line, row.velocity_m_s, 6);
    append_field(line, row.heading_sigma_deg, 4);
    append_field(line, row.tilt_sigma_deg, 4);
    append_field(line, row.velocity_sigma_m_s, 6);
    append_field(line, row.position_sigma_m, 6);
    for bits in [row.status.bits(), row.validity.bits()] {
        line.push(b',');
        append_integer(line, u64::from(bits), 1);
    }
    for code in [row.heading_source.code(), row.position_source.code()] {
        line.push(b',');
        append_integer(line, u64::from(code), 1);
    }
    line.push(b'\n');
}

fn append_vector(line: &mut Vec<u8>, vector: Option<DVec3>, decimals: u8) {
    let parts = vector.filter(|vector| vector.is_finite()).map(|vector| vector.to_array());
    (0..3).for_each(|at| append_field(line, parts.map(|parts| parts[at]), decimals));
}

fn append_field(line: &mut Vec<u8>, value: Option<f64>, decimals: u8) {
    line.push(b',');
    if let Some(value) = value.filter(|value| value.is_finite()) {
        append_fixed(line, value, decimals);
    }
}

/// Appends a finite number with `decimals` decimals, at most 9, half away from zero.
///
/// Through integers: `format!` rounds the exact binary value, at several times the cost.
fn append_fixed(line: &mut Vec<u8>, value: f64, decimals: u8) {
    /// Below it every scaled value is an integer of `f64`.
    const EXACT: f64 = (1_u64 << 53) as f64;
    let scale = 10_u64.pow(u32::from(decimals));
    let scaled = (value.abs() * scale as f64).round();
    if scaled >= EXACT {
        // Writing to a Vec does not fail.
        let _ = write!(line, "{value:.*}", usize::from(decimals));
        return;
    }
    let scaled = scaled as u64;
    if value < 0.0 && scaled > 0 {
        line.push(b'-');
    }
    append_integer(line, scaled / scale, 1);
    line.push(b'.');
    append_integer(line, scaled % scale, usize::from(decimals));
}

fn append_nanos_as_seconds(line: &mut Vec<u8>, nanos: i64) {
    const NANOS: u64 = 1_000_000_000;
    if nanos < 0 {
        line.push(b'-');
    }
    append_integer(line, nanos.unsigned_abs() / NANOS, 1);
    line.push(b'.');
    append_integer(line, nanos.unsigned_abs() % NANOS, 9);
}

/// Appends a natural number with at least `width` digits, which is at least 1.
fn append_integer(line: &mut Vec<u8>, mut number: u64, width: usize) {
    let mut digits = [b'0'; 20];
    let mut start = digits.len();
    while number > 0 {
        start -= 1;
        digits[start] = b'0' + (number % 10) as u8;
        number /= 10;
    }
    line.extend_from_slice(&digits[start.min(digits.len() - width)..]);
}

#[cfg(test)]
mod tests {
    use glam::DQuat;
    use proptest::prelude::*;

    use super::*;

    fn unknown(nanos: i64) -> PoseRow {
        PoseRow {
            time: SensorTime::from_nanos(nanos),
            position_m: None,
            orientation: None,
            velocity_m_s: None,
            heading_sigma_deg: None,
            tilt_sigma_deg: None,
            velocity_sigma_m_s: None,
            position_sigma_m: None,
            status: Status::empty(),
            validity: Validity::empty(),
            heading_source: HeadingSource::None,
            position_source: PositionSource::None,
        }
    }

    fn known() -> PoseRow {
        PoseRow {
            position_m: Some(DVec3::new(1.5, -2.25, -0.000_000_4)),
            orientation: Rotation::from_quaternion(DQuat::from_xyzw(0.0, 0.6, 0.0, -0.8)),
            velocity_m_s: Some(DVec3::new(0.0, 22.222_222_22, -1.0)),
            heading_sigma_deg: Some(1.234_56),
            tilt_sigma_deg: Some(0.1),
            velocity_sigma_m_s: Some(0.01),
            position_sigma_m: Some(1e18),
            status: Status::INITIALISED | Status::BRIDGED,
            validity: Validity::TILT,
            heading_source: HeadingSource::GyroscopeHeld,
            position_source: PositionSource::Inertial,
            ..unknown(3_500_000)
        }
    }

    fn text(row: &PoseRow) -> String {
        let mut line = Vec::new();
        append(&mut line, row);
        String::from_utf8(line).unwrap()
    }

    #[test]
    fn a_known_pose_is_written_in_full() {
        assert_eq!(
            text(&known()),
            "0.003500000,1.500000,-2.250000,0.000000,-0.800000000,0.000000000,0.600000000,\
             0.000000000,0.000000,22.222222,-1.000000,1.2346,0.1000,0.010000,\
             1000000000000000000.000000,17,1,2,2\n"
        );
    }

    #[test]
    fn what_is_unknown_or_not_finite_is_empty() {
        let mut row = unknown(-1);
        assert_eq!(text(&row), "-0.000000001,,,,,,,,,,,,,,,0,0,0,0\n");
        row.velocity_m_s = Some(DVec3::new(1.0, f64::NAN, 1.0));
        row.heading_sigma_deg = Some(f64::INFINITY);
        assert_eq!(text(&row), text(&unknown(-1)));
    }

    #[test]
    fn the_file_has_a_header_and_as_many_fields_in_each_row() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("poses.csv");
        let mut writer = PosesWriter::create(&path).unwrap();
        for row in [unknown(0), known()] {
            writer.write(&row).unwrap();
        }
        writer.finish().unwrap();
        let content = std::fs::read_to_string(&path).unwrap();
        let fields: Vec<usize> = content.lines().map(|line| line.split(',').count()).collect();
        assert_eq!(fields, [19, 19, 19]);
        assert!(content.starts_with(HEADER));
    }

    #[test]
    fn errors_name_the_file() {
        let error = PosesWriter::create(Path::new("/nowhere/poses.csv")).unwrap_err();
        assert!(error.to_string().starts_with("/nowhere/poses.csv: cannot write poses: "));
        let mut full = PosesWriter::create(Path::new("/dev/full")).unwrap();
        full.write(&known()).unwrap();
        assert!(full.finish().unwrap_err().to_string().starts_with("/dev/full: "));
    }

    proptest! {
        #[test]
        fn any_number_is_rounded_to_its_decimals(value in prop::num::f64::NORMAL, decimals in 0_u8..10) {
            let mut line = Vec::new();
            append_fixed(&mut line, value, decimals);
            let back: f64 = std::str::from_utf8(&line).unwrap().parse().unwrap();
            let half_unit = 0.5 * 10_f64.powi(-i32::from(decimals));
            prop_assert!((back - value).abs() <= half_unit * 1.000_001 + value.abs() * 1e-15);
        }

        #[test]
        fn usual_numbers_too(value in -1e4..1e4, decimals in 1_u8..10) {
            let mut line = Vec::new();
            append_fixed(&mut line, value, decimals);
            let text = String::from_utf8(line).unwrap();
            let (whole, fraction) = text.trim_start_matches('-').split_once('.').unwrap();
            prop_assert!(!whole.is_empty() && fraction.len() == usize::from(decimals));
            let back: f64 = text.parse().unwrap();
            let half_unit = 0.5 * 10_f64.powi(-i32::from(decimals));
            prop_assert!((back - value).abs() <= half_unit * 1.000_001 + value.abs() * 1e-15);
        }

        #[test]
        fn times_are_exact(nanos in any::<i64>()) {
            let mut line = Vec::new();
            append_nanos_as_seconds(&mut line, nanos);
            let digits: String = String::from_utf8(line).unwrap().replace('.', "");
            prop_assert_eq!(digits.parse::<i64>().unwrap(), nanos);
        }
    }
}
