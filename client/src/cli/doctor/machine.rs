//! The machine as files: `/proc`, `/sys`, `/etc` and `/dev`, below a directory that a test can make up.

use std::fs::{self, File};
use std::io::{self, Read};
use std::os::unix::fs::MetadataExt;
use std::path::PathBuf;

/// No file that is looked at is longer than this, bytes; of a longer one the begin counts.
const LONGEST: u64 = 1 << 18;

/// Where the machine's files lie.
#[derive(Clone, Debug)]
pub(super) struct Machine {
    root: PathBuf,
}

/// Owner and mode of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rights {
    pub(super) uid: u32,
    pub(super) gid: u32,
    /// The permission bits, with sticky and set-id.
    pub(super) mode: u32,
}

impl Machine {
    pub(super) fn at(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into() }
    }

    /// A file's place in this process's own view.
    pub(super) fn path(&self, path: &str) -> PathBuf {
        self.root.join(path.trim_start_matches('/'))
    }

    /// A file's text without the white space around it; what is not UTF-8 is replaced.
    ///
    /// # Errors
    /// Why it cannot be read, with its name.
    pub(super) fn read(&self, path: &str) -> Result<String, String> {
        let mut bytes = Vec::new();
        File::open(self.path(path))
            .and_then(|file| file.take(LONGEST).read_to_end(&mut bytes))
            .map_err(|error| format!("{path}: {}", reason(&error)))?;
        Ok(String::from_utf8_lossy(&bytes).trim().to_owned())
    }

    /// Names in a directory, in order; none if it is not there.
    pub(super) fn names_in(&self, directory: &str) -> Vec<String> {
        let entries = fs::read_dir(self.path(directory)).into_iter().flatten().flatten();
        let mut names: Vec<String> =
            entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    pub(super) fn exists(&self, path: &str) -> bool {
        self.path(path).exists()
    }

    /// Owner and mode; nothing if there is no such file.
    pub(super) fn rights(&self, path: &str) -> Option<Rights> {
        let metadata = fs::metadata(self.path(path)).ok()?;
        let mode = metadata.mode() & 0o7777;
        Some(Rights { uid: metadata.uid(), gid: metadata.gid(), mode })
    }

    /// Numbers of the processors that have a directory.
    pub(super) fn processors(&self) -> Vec<u32> {
        let names = self.names_in("/sys/devices/system/cpu");
        let mut numbers: Vec<u32> = names
            .iter()
            .filter_map(|name| name.strip_prefix("cpu").and_then(|number| number.parse().ok()))
            .collect();
        numbers.sort_unstable();
        numbers
    }
}

fn reason(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "not there".into(),
        io::ErrorKind::PermissionDenied => "no right to read it".into(),
        _ => error.to_string(),
    }
}

/// The value behind a key at the begin of a line, as in `/proc/PID/status`.
pub(super) fn field<'t>(text: &'t str, key: &str) -> Option<&'t str> {
    text.lines().find_map(|line| line.strip_prefix(key)).map(str::trim)
}
