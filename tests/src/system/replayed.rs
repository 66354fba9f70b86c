//! `lodestoned replay`, and what it wrote.

use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};

use super::{lodestoned, said};

/// One row of poses; `None` where a field is empty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseLine {
    /// The recording's time, s.
    pub time_s: f64,
    /// Position in the world, m.
    pub position_m: Option<DVec3>,
    /// Body to world.
    pub orientation: Option<DQuat>,
    /// Standard deviation of the heading, degrees, where it is known.
    pub heading_sigma_deg: Option<f64>,
    /// Status bits.
    pub status: u32,
}

/// How a replay ended.
#[derive(Clone, Debug)]
pub struct Replayed {
    /// Exit code; `None` if a signal ended it.
    pub code: Option<i32>,
    /// The log.
    pub log: String,
    /// The poses, byte by byte; empty if there are none.
    pub bytes: Vec<u8>,
}

/// Replays one recording into a directory.
///
/// # Panics
/// If the daemon panicked, or was killed by a signal.
pub fn replay(recording: &Path, out: &Path, options: &[&str]) -> Replayed {
    let ended = lodestoned()
        .arg("replay")
        .args(options)
        .arg(recording)
        .arg("--out")
        .arg(out)
        .output()
        .expect("runs");
    let log = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert!(ended.status.code().is_some() && !log.contains("panicked"), "{}", said(&ended));
    let bytes = fs::read(poses_path(recording, out)).unwrap_or_default();
    Replayed { code: ended.status.code(), log, bytes }
}

fn poses_path(recording: &Path, out: &Path) -> PathBuf {
    let name = recording.file_name().unwrap_or_default().to_string_lossy();
    let name = name.trim_end_matches(".zst").trim_end_matches(".csv");
    out.join(format!("{name}.csv"))
}

impl Replayed {
    /// A number of the summary in the log.
    ///
    /// # Panics
    /// If the summary lacks it.
    pub fn count(&self, what: &str) -> u64 {
        let (_, after) = self
            .log
            .split_once(&format!(" {what}="))
            .unwrap_or_else(|| panic!("no {what} in {}", self.log));
        let digits = after.chars().take_while(char::is_ascii_digit).collect::<String>();
        digits.parse().expect("a number")
    }

    /// The poses.
    ///
    /// # Panics
    /// If a field is no number: poses hold numbers or nothing.
    pub fn poses(&self) -> Vec<PoseLine> {
        let text = String::from_utf8_lossy(&self.bytes);
        let poses: Vec<_> = text.lines().skip(1).map(pose_line).collect();
        for pose in &poses {
            if let Some(q) = pose.orientation {
                assert!((q.length() - 1.0).abs() < 1e-5, "{pose:?}");
            }
        }
        poses
    }

    /// The poses, after a look that once there is an orientation there always is one.
    ///
    /// # Panics
    /// If one is missing, or all are.
    pub fn unbroken_poses(&self) -> Vec<PoseLine> {
        let poses = self.poses();
        let aligned = poses.iter().position(|pose| pose.orientation.is_some()).expect("aligned");
        let hole =
            poses[aligned..].iter().find(|p| p.orientation.is_none() || p.position_m.is_none());
        assert_eq!(hole, None, "a pose is missing after the alignment");
        poses
    }
}

fn pose_line(line: &str) -> PoseLine {
    let numbers: Vec<Option<f64>> = line.split(',').map(number).collect();
    let all = |range: std::ops::Range<usize>| {
        numbers[range].iter().copied().collect::<Option<Vec<f64>>>()
    };
    PoseLine {
        time_s: numbers[0].expect("a time"),
        position_m: all(1..4).map(|p| DVec3::from_slice(&p)),
        orientation: all(4..8).map(|q| DQuat::from_xyzw(q[1], q[2], q[3], q[0])),
        heading_sigma_deg: numbers[11],
        status: numbers[15].expect("a status") as u32,
    }
}

fn number(field: &str) -> Option<f64> {
    let value: f64 = (!field.is_empty()).then(|| field.parse().expect("a number"))?;
    assert!(value.is_finite(), "not finite: {field}");
    Some(value)
}

/// The columns of a recording by name, `NaN` where a field is empty; plain or `.zst`.
///
/// # Panics
/// If the file cannot be read.
pub fn table(path: &Path, columns: &[&str]) -> Vec<Vec<f64>> {
    let text = text_of(path);
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let index = |name: &&str| header.iter().position(|column| column == name).expect("a column");
    let wanted: Vec<usize> = columns.iter().map(index).collect();
    let mut values = vec![Vec::new(); columns.len()];
    let mut fields = Vec::new();
    for line in lines {
        fields.clear();
        fields.extend(line.split(','));
        for (column, &index) in values.iter_mut().zip(&wanted) {
            column.push(fields[index].parse().unwrap_or(f64::NAN));
        }
    }
    values
}

pub(super) fn text_of(path: &Path) -> String {
    let mut text = String::new();
    let mut file = File::open(path).expect("opens");
    if path.extension().is_some_and(|extension| extension == "zst") {
        let mut decoder = ruzstd::decoding::StreamingDecoder::new(file).expect("Zstandard");
        decoder.read_to_string(&mut text).expect("text");
    } else {
        file.read_to_string(&mut text).expect("text");
    }
    text
}
