//! Recordings: CSV, plain or compressed by Zstandard, read row by row.
//!
//! The first line names the columns, in any order:
//!
//! | column | unit | |
//! |---|---|---|
//! | `t` | s | required; decimal, kept to the nanosecond |
//! | `gx gy gz` | rad/s | required; angular rate, body axes |
//! | `ax ay az` | m/s² | required; specific force, body axes |
//! | `mx my mz` | µT | optional, all three or none; empty or `nan` where there is no new reading |
//! | `temp` | °C | optional; empty or `nan` where there is no new reading |
//! | `speed` | m/s | optional; forward speed of the vehicle, empty where there is no new one |
//! | `speed_sigma` | m/s | optional; its standard deviation |
//! | `speed_age` | s | optional; how much older than the row it is |
//! | `fix_x fix_y fix_z` `fix_sigma` | m | optional, all or none; position in the world, its standard deviation per axis |
//! | `fix_qw fix_qx fix_qy fix_qz` `fix_rot_sigma` | rad | optional, all or none; orientation with the position |
//! | `fix_age` | s | optional; how much older than the row both are |
//!
//! Ground truth (`qw qx qy qz`, `px py pz`, `movement`) is not handed on: an estimator must not
//! see it. Other columns are ignored and listed by [`Recording::unknown_columns`]. A magnetometer
//! reading that repeats the one before is handed on as a new one; the format says empty when it is
//! not, and whether equal values are one reading is for the estimator to judge.
//!
//! Lines end in LF or CRLF; a byte order mark and blank lines are skipped. Compression is told from
//! the first bytes of the file, not from its name.

mod decimal;
mod error;
mod header;
mod lines;
mod row;
mod source;
#[cfg(test)]
mod tests;
pub mod truth;

use std::collections::VecDeque;
use std::path::Path;
use std::sync::Arc;

pub use error::{Excerpt, RecordingError, RowError, RowFault};
use header::Columns;
pub use lines::MAX_LINE_BYTES;
use lines::{Line, LineReader};
pub use row::Row;
use source::Source;

/// Sample intervals whose median is taken for the nominal rate.
const RATE_INTERVALS: usize = 200;

/// One recording, open for reading from its first row to its last.
#[derive(Debug)]
pub struct Recording {
    path: Arc<Path>,
    lines: LineReader<Source>,
    columns: Columns,
    /// Rows read to find the rate and not handed on yet.
    ahead: VecDeque<Result<Row, RowError>>,
    nominal_rate_hz: f64,
    broken: bool,
}

impl Recording {
    /// Opens a recording and reads its header and first rows.
    ///
    /// # Errors
    /// [`RecordingError`] if the file cannot be read, is not a recording, or holds fewer than two
    /// rows with increasing time.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let source = Source::open(path)?;
        let mut lines = LineReader::new(source);
        let columns = header::read(&mut lines, path)?;
        let mut recording = Self {
            path: Arc::from(path),
            lines,
            columns,
            ahead: VecDeque::with_capacity(RATE_INTERVALS + 1),
            nominal_rate_hz: 0.0,
            broken: false,
        };
        recording.read_ahead();
        recording.nominal_rate_hz = recording.median_rate_hz()?;
        Ok(recording)
    }

    /// The next row; `None` after the last one, and after an error that [`RowError::is_fatal`].
    ///
    /// Allocates nothing of its own. Values of gyroscope, accelerometer and magnetometer may be
    /// infinite, and those of gyroscope and accelerometer not a number.
    pub fn next_row(&mut self) -> Option<Result<Row, RowError>> {
        self.ahead.pop_front().or_else(|| self.read_row())
    }

    /// Rows per second: one over the median of the positive ones of the first 200 intervals.
    pub const fn nominal_rate_hz(&self) -> f64 {
        self.nominal_rate_hz
    }

    /// Names of the columns that mean nothing here, in the order of the file.
    pub fn unknown_columns(&self) -> &[String] {
        self.columns.unknown()
    }

    /// Whether the recording has magnetometer columns.
    pub const fn has_magnetometer(&self) -> bool {
        self.columns.has_magnetometer()
    }

    /// Whether the recording has a speed column.
    pub const fn has_speed(&self) -> bool {
        self.columns.has_speed()
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn read_row(&mut self) -> Option<Result<Row, RowError>> {
        while !self.broken {
            let number = self.lines.number() + 1;
            let parsed = match self.lines.next_line() {
                Ok(None) => return None,
                Ok(Some(Line::Text([]))) => continue,
                Ok(Some(Line::Text(text))) => row::parse(text, &self.columns),
                Ok(Some(Line::TooLong)) => Err(RowFault::LineTooLong),
                Err(error) => {
                    self.broken = true;
                    Err(RowFault::Unreadable(Arc::new(error)))
                }
            };
            return Some(parsed.map_err(|fault| self.row_error(number, fault)));
        }
        None
    }

    fn row_error(&self, line: u64, fault: RowFault) -> RowError {
        RowError { path: Arc::clone(&self.path), line, fault }
    }

    fn read_ahead(&mut self) {
        while self.ahead.len() <= RATE_INTERVALS
            && let Some(row) = self.read_row()
        {
            self.ahead.push_back(row);
        }
    }

    fn median_rate_hz(&self) -> Result<f64, RecordingError> {
        let times = || self.ahead.iter().flatten().map(|row| row.time);
        let mut spans: Vec<i64> = times()
            .zip(times().skip(1))
            .map(|(earlier, later)| (later - earlier).as_nanos())
            .filter(|&span| span > 0)
            .collect();
        if spans.is_empty() {
            let first_error = self.ahead.iter().find_map(|row| row.as_ref().err());
            return Err(RecordingError::TooFewRows {
                path: self.path.to_path_buf(),
                rows: times().count(),
                first_error: first_error.cloned().map(Box::new),
            });
        }
        let middle = spans.len() / 2;
        let (_, &mut median, _) = spans.select_nth_unstable(middle);
        Ok(1e9 / median as f64)
    }
}
