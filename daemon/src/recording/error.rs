//! What can be wrong with a recording, and with one of its rows.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::lines::MAX_LINE_BYTES;

/// Why a file cannot be opened as a recording.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The file cannot be opened or read, or its compressed data are damaged or cut short.
    #[error("{}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system or the decoder said.
        source: io::Error,
    },
    /// The name promises Zstandard, the content is something else.
    #[error("{}: named .zst, but does not begin as Zstandard data do", path.display())]
    NotZstandard {
        /// The file.
        path: PathBuf,
    },
    /// There is no header.
    #[error("{}: empty; the first line must name the columns: t,gx,gy,gz,ax,ay,az,…", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// The first line is not text or far too long: most likely not a CSV file.
    #[error(
        "{}: line 1: not a CSV header; it must be UTF-8 text of at most {MAX_LINE_BYTES} bytes \
         that names the columns: t,gx,gy,gz,ax,ay,az,…",
        path.display()
    )]
    NotText {
        /// The file.
        path: PathBuf,
    },
    /// The header lacks columns.
    #[error(
        "{}: line 1: no column {missing}; required: t gx gy gz ax ay az; together or not at all: \
         mx my mz, fix_x fix_y fix_z fix_sigma, fix_qw fix_qx fix_qy fix_qz fix_rot_sigma; and a \
         speed or fix before what is said about it",
        path.display()
    )]
    MissingColumns {
        /// The file.
        path: PathBuf,
        /// Names of the missing columns, separated by blanks.
        missing: String,
    },
    /// A column that is read stands in the header twice.
    #[error("{}: line 1: column {column} is named twice", path.display())]
    DuplicateColumn {
        /// The file.
        path: PathBuf,
        /// Its name.
        column: &'static str,
    },
    /// No rate can be told.
    #[error(
        "{}: {rows} readable row(s) at its beginning; at least two with increasing t are needed{}",
        path.display(),
        Because(first_error.as_deref())
    )]
    TooFewRows {
        /// The file.
        path: PathBuf,
        /// Rows that could be read.
        rows: usize,
        /// The first row that could not.
        first_error: Option<Box<RowError>>,
    },
}

struct Because<'a>(Option<&'a RowError>);

impl fmt::Display for Because<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(error) => write!(out, " (line {}: {})", error.line, error.fault),
            None => Ok(()),
        }
    }
}

/// A row that could not be read; made and cloned without allocation, but for
/// [`RowFault::Unreadable`].
#[derive(Clone, Debug, thiserror::Error)]
#[error("{}: line {line}: {fault}", path.display())]
pub struct RowError {
    /// The file.
    pub path: Arc<Path>,
    /// The line, the header being 1.
    pub line: u64,
    /// What is wrong.
    pub fault: RowFault,
}

impl RowError {
    /// Whether nothing can be read after it.
    pub const fn is_fatal(&self) -> bool {
        matches!(self.fault, RowFault::Unreadable(_))
    }
}

/// What is wrong with a row.
#[derive(Clone, Debug, thiserror::Error)]
pub enum RowFault {
    /// The number of fields is not the header's.
    #[error("{found} fields; the header names {expected}")]
    FieldCount {
        /// Fields in this row.
        found: usize,
        /// Columns in the header.
        expected: usize,
    },
    /// A field is not a number.
    #[error("column {column}: '{text}' is not a decimal number")]
    NotANumber {
        /// The column's name.
        column: &'static str,
        /// The field's beginning.
        text: Excerpt,
    },
    /// The time is not a decimal number in range.
    #[error("column t: '{text}' is not a time; a decimal number of seconds within ±9e9 is allowed")]
    BadTime {
        /// The field's beginning.
        text: Excerpt,
    },
    /// One or two of three magnetometer fields are empty.
    #[error("columns mx my mz: all three must hold a number, or none")]
    PartialMagnetometer,
    /// Some fields of a fix are empty.
    #[error(
        "columns fix_x fix_y fix_z fix_sigma, and fix_qw fix_qx fix_qy fix_qz fix_rot_sigma: all of \
         them must hold a number, or none"
    )]
    PartialFix,
    /// The line is longer than any row.
    #[error("longer than {MAX_LINE_BYTES} bytes")]
    LineTooLong,
    /// The file ends here against its will: read error, damaged or truncated compressed data.
    #[error("the rest cannot be read: {0}")]
    Unreadable(Arc<io::Error>),
}

/// The first bytes of a field, printable whatever they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Excerpt {
    bytes: [u8; Self::LENGTH],
    kept: u8,
    cut: bool,
}

impl Excerpt {
    const LENGTH: usize = 24;

    pub(super) fn new(field: &[u8]) -> Self {
        let kept = field.len().min(Self::LENGTH);
        let mut bytes = [0; Self::LENGTH];
        bytes[..kept].copy_from_slice(&field[..kept]);
        Self { bytes, kept: kept as u8, cut: kept < field.len() }
    }
}

impl fmt::Display for Excerpt {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}", self.bytes[..usize::from(self.kept)].escape_ascii())?;
        out.write_str(if self.cut { "…" } else { "" })
    }
}
