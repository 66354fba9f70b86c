//! A table on its way to a file: a header, then rows as they come.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::poses_csv::PosesError;

/// Rows that wait for the system to take them, bytes.
const BUFFER: usize = 256 * 1024;

/// A file of rows; allocates nothing after it was made.
#[derive(Debug)]
pub(crate) struct CsvFile {
    path: PathBuf,
    file: BufWriter<File>,
}

impl CsvFile {
    /// Makes the file, or empties the one that is there, and writes the header.
    pub(crate) fn create(path: &Path, header: &str) -> Result<Self, PosesError> {
        let error = |source| PosesError { path: path.to_path_buf(), source };
        let mut file = BufWriter::with_capacity(BUFFER, File::create(path).map_err(error)?);
        file.write_all(header.as_bytes()).map_err(error)?;
        Ok(Self { path: path.to_path_buf(), file })
    }

    /// Writes rows with their line ends.
    pub(crate) fn write(&mut self, rows: &[u8]) -> Result<(), PosesError> {
        self.file.write_all(rows).map_err(|source| self.error(source))
    }

    /// Hands all rows to the system; without it, a full disk goes unnoticed.
    pub(crate) fn finish(mut self) -> Result<(), PosesError> {
        self.file.flush().map_err(|source| self.error(source))
    }

    fn error(&self, source: std::io::Error) -> PosesError {
        PosesError { path: self.path.clone(), source }
    }
}
