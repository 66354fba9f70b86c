//! The header: which column of the file is which quantity.

use std::ops::Range;
use std::path::Path;

use super::error::RecordingError;
use super::lines::{Line, LineReader};
use super::source::Source;

/// What is read, in the order of the row's values.
pub(super) const NAMES: [&str; COUNT] = [
    "t",
    "gx",
    "gy",
    "gz",
    "ax",
    "ay",
    "az",
    "mx",
    "my",
    "mz",
    "temp",
    "speed",
    "speed_sigma",
    "speed_age",
    "fix_x",
    "fix_y",
    "fix_z",
    "fix_sigma",
    "fix_age",
    "fix_qw",
    "fix_qx",
    "fix_qy",
    "fix_qz",
    "fix_rot_sigma",
];
pub(super) const COUNT: usize = 24;
pub(super) const TIME: usize = 0;
pub(super) const GYRO: usize = 1;
pub(super) const ACCEL: usize = 4;
pub(super) const MAG: usize = 7;
pub(super) const TEMPERATURE: usize = 10;
pub(super) const SPEED: usize = 11;
pub(super) const SPEED_SIGMA: usize = 12;
pub(super) const SPEED_AGE: usize = 13;
pub(super) const FIX: usize = 14;
pub(super) const FIX_SIGMA: usize = 17;
pub(super) const FIX_AGE: usize = 18;
pub(super) const FIX_ROTATION: usize = 19;
pub(super) const FIX_ROTATION_SIGMA: usize = 23;

/// Columns of which all are there, or none; where the second part is there, the first is too.
const TOGETHER: [(Range<usize>, Range<usize>); 4] = [
    (MAG..TEMPERATURE, MAG..TEMPERATURE),
    (SPEED..SPEED + 1, SPEED_SIGMA..FIX),
    (FIX..FIX_AGE, FIX..FIX_ROTATION),
    (FIX..FIX_AGE, FIX_ROTATION..COUNT),
];

/// Ground truth, known and not read.
const TRUTH: [&str; 8] = ["qw", "qx", "qy", "qz", "px", "py", "pz", "movement"];

/// Marks a column that is not read.
pub(super) const UNREAD: u8 = u8::MAX;

/// The columns of one file.
#[derive(Debug)]
pub(super) struct Columns {
    /// For each column of the file its index in [`NAMES`], or [`UNREAD`].
    roles: Vec<u8>,
    unknown: Vec<String>,
    magnetometer: bool,
    speed: bool,
}

impl Columns {
    pub(super) fn roles(&self) -> &[u8] {
        &self.roles
    }

    pub(super) fn unknown(&self) -> &[String] {
        &self.unknown
    }

    pub(super) const fn has_magnetometer(&self) -> bool {
        self.magnetometer
    }

    pub(super) const fn has_speed(&self) -> bool {
        self.speed
    }
}

pub(super) fn read(lines: &mut LineReader<Source>, path: &Path) -> Result<Columns, RecordingError> {
    let path_of = || path.to_path_buf();
    let line = lines
        .next_line()
        .map_err(|source| RecordingError::Unreadable { path: path_of(), source })?;
    match line {
        None => Err(RecordingError::Empty { path: path_of() }),
        Some(Line::TooLong) => Err(RecordingError::NotText { path: path_of() }),
        Some(Line::Text(bytes)) => match std::str::from_utf8(bytes) {
            Ok(text) => parse(text.trim_start_matches('\u{FEFF}'), path),
            Err(_) => Err(RecordingError::NotText { path: path_of() }),
        },
    }
}

fn parse(text: &str, path: &Path) -> Result<Columns, RecordingError> {
    let mut found = [false; COUNT];
    let mut columns =
        Columns { roles: Vec::new(), unknown: Vec::new(), magnetometer: false, speed: false };
    for name in text.split(',').map(|name| name.trim().trim_matches('"')) {
        let Some(role) = NAMES.iter().position(|&known| known == name) else {
            columns.roles.push(UNREAD);
            if !TRUTH.contains(&name) {
                columns.unknown.push(name.to_owned());
            }
            continue;
        };
        if std::mem::replace(&mut found[role], true) {
            let column = NAMES[role];
            return Err(RecordingError::DuplicateColumn { path: path.to_path_buf(), column });
        }
        columns.roles.push(role as u8);
    }
    columns.magnetometer = found[MAG..TEMPERATURE].contains(&true);
    columns.speed = found[SPEED];
    match missing(&found) {
        Some(missing) => Err(RecordingError::MissingColumns { path: path.to_path_buf(), missing }),
        None => Ok(columns),
    }
}

/// Names of the columns without which those that were found mean nothing.
fn missing(found: &[bool; COUNT]) -> Option<String> {
    let mut needed = [false; COUNT];
    needed[TIME..MAG].fill(true);
    for (all, any) in TOGETHER {
        if found[any].contains(&true) {
            needed[all].fill(true);
        }
    }
    if found[FIX_ROTATION..COUNT].contains(&true) {
        needed[FIX_ROTATION..COUNT].fill(true);
    }
    let absent = (0..COUNT).filter(|&k| needed[k] && !found[k]).map(|k| NAMES[k]);
    let names: Vec<&str> = absent.collect();
    (!names.is_empty()).then(|| names.join(" "))
}
