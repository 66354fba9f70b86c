//! The header: which column of the file is which quantity.

use std::path::Path;

use super::error::RecordingError;
use super::lines::{Line, LineReader};
use super::source::Source;

/// What is read, in the order of the row's values.
pub(super) const NAMES: [&str; COUNT] =
    ["t", "gx", "gy", "gz", "ax", "ay", "az", "mx", "my", "mz", "temp"];
pub(super) const COUNT: usize = 11;
pub(super) const TIME: usize = 0;
pub(super) const GYRO: usize = 1;
pub(super) const ACCEL: usize = 4;
pub(super) const MAG: usize = 7;
pub(super) const TEMPERATURE: usize = 10;

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
    let mut columns = Columns { roles: Vec::new(), unknown: Vec::new(), magnetometer: false };
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
    let required = if columns.magnetometer { TEMPERATURE } else { MAG };
    match missing(&found[..required]) {
        Some(missing) => Err(RecordingError::MissingColumns { path: path.to_path_buf(), missing }),
        None => Ok(columns),
    }
}

fn missing(found: &[bool]) -> Option<String> {
    let names: Vec<&str> =
        NAMES.iter().zip(found).filter(|&(_, &found)| !found).map(|(&name, _)| name).collect();
    (!names.is_empty()).then(|| names.join(" "))
}
