//! What can be wrong with a file, in words that can be printed as they are.

use std::fmt;
use std::io;
use std::path::PathBuf;

use crate::model::North;

/// One thing that is wrong in a file.
///
/// Printed as `FILE:LINE: key: what is wrong; allowed: what is allowed`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConfigError {
    /// Name of the file, as it was given.
    pub file: String,
    /// Line, counted from 1.
    pub line: usize,
    /// Dotted path of the key, such as `camera.synthetic.rest_s`; `None` for a syntax error.
    pub key: Option<String>,
    /// What is wrong.
    pub problem: String,
    /// What is allowed.
    pub allowed: String,
}

impl fmt::Display for ConfigError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}:{}: ", self.file, self.line)?;
        if let Some(key) = &self.key {
            write!(out, "{key}: ")?;
        }
        write!(out, "{}; allowed: {}", self.problem, self.allowed)
    }
}

/// Everything that is wrong in a file, at least one thing, in the order of lines.
///
/// Printed as one line each, the first [`ConfigErrors::SHOWN`] of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConfigErrors {
    errors: Vec<ConfigError>,
}

impl ConfigErrors {
    /// Most errors that `Display` prints before it only counts them.
    pub const SHOWN: usize = 100;

    /// Sorts by line. The caller has seen to it that there is at least one.
    pub(crate) fn new(mut errors: Vec<ConfigError>) -> Self {
        errors.sort_by_key(|error| error.line);
        Self { errors }
    }

    /// The errors, in the order of lines.
    pub fn iter(&self) -> std::slice::Iter<'_, ConfigError> {
        self.errors.iter()
    }

    /// How many there are.
    #[allow(clippy::len_without_is_empty, reason = "never empty")]
    pub fn len(&self) -> usize {
        self.errors.len()
    }
}

impl<'a> IntoIterator for &'a ConfigErrors {
    type Item = &'a ConfigError;
    type IntoIter = std::slice::Iter<'a, ConfigError>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl fmt::Display for ConfigErrors {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, error) in self.errors.iter().take(Self::SHOWN).enumerate() {
            let separator = if index == 0 { "" } else { "\n" };
            write!(out, "{separator}{error}")?;
        }
        match self.errors.len().saturating_sub(Self::SHOWN) {
            0 => Ok(()),
            more => write!(out, "\nand {more} more errors"),
        }
    }
}

impl std::error::Error for ConfigErrors {}

/// Why a file could not be loaded.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// There is no such file.
    #[error("{}: no such file; allowed: the path of a TOML file", path.display())]
    NotFound {
        /// The path as it was given.
        path: PathBuf,
    },
    /// The file cannot be read: a directory, no permission, a failing disk.
    #[error("{}: cannot be read ({source}); allowed: a TOML file that this user may read", path.display())]
    Unreadable {
        /// The path as it was given.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The file is larger than any configuration.
    #[error("{}: is too large; allowed: at most {limit} bytes", path.display())]
    TooLarge {
        /// The path as it was given.
        path: PathBuf,
        /// Most bytes that are taken.
        limit: u64,
    },
    /// The file is not text.
    #[error("{}:{line}: byte {offset} is not UTF-8; allowed: text in UTF-8", path.display())]
    NotUtf8 {
        /// The path as it was given.
        path: PathBuf,
        /// Line of the first byte that is not text, counted from 1.
        line: usize,
        /// Offset of that byte, counted from 0.
        offset: usize,
    },
    /// The file's contents are wrong.
    #[error(transparent)]
    Invalid(#[from] ConfigErrors),
    /// The kept world points to another north.
    #[error(
        "{}: keeps a world of {} north, and world.north is \"{}\"; allowed: the same north, or remove the file to begin a new world",
        path.display(),
        found.word(),
        expected.word()
    )]
    OtherNorth {
        /// The path as it was given.
        path: PathBuf,
        /// North of the kept world.
        found: North,
        /// North of the configuration.
        expected: North,
    },
    /// The calibration belongs to another camera.
    #[error(
        "{}: is the calibration of camera {found}, not of camera {expected}; allowed: a file with serial = {expected}",
        path.display()
    )]
    OtherCamera {
        /// The path as it was given.
        path: PathBuf,
        /// Serial number in the file.
        found: u64,
        /// Serial number of the camera that asks for it.
        expected: u64,
    },
}
