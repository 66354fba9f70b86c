//! What outlives the daemon: the world, where that is configured, and the number of its epoch.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use lodestone_config::KeptWorld;

/// Name of the file with the last epoch, in the domain's root directory.
const EPOCH_FILE: &str = "lodestoned.epoch";

/// Why something could not be kept.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The system refuses.
    #[error("{}: cannot be written: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A number that the file cannot hold.
    #[error("{}: cannot be written: {what}", path.display())]
    Text {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
}

/// Replaces the file that keeps the world, whole or not at all: a process that is killed, or a power
/// cut, leaves the old one or the new one.
pub(super) fn write(path: &Path, kept: &KeptWorld) -> Result<(), StoreError> {
    let text =
        kept.to_toml().map_err(|e| StoreError::Text { path: path.into(), what: e.to_string() })?;
    replace(path, &text).map_err(|source| StoreError::Write { path: path.into(), source })
}

fn replace(path: &Path, text: &str) -> io::Result<()> {
    let mut beside = path.as_os_str().to_owned();
    beside.push(".new");
    let beside = PathBuf::from(beside);
    let mut file = OpenOptions::new().write(true).create(true).truncate(true).open(&beside)?;
    file.write_all(text.as_bytes())?;
    file.sync_all()?;
    fs::rename(&beside, path)?;
    // The new name must be on the disk as well.
    let directory = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    File::open(directory.unwrap_or(Path::new(".")))?.sync_all()
}

/// The number of the last epoch in a domain, so that worlds of different runs are told apart even where
/// none is kept. It lives in shared memory: after a boot nobody remembers the old numbers either.
#[derive(Clone, Debug)]
pub struct Epochs(PathBuf);

impl Epochs {
    /// The epochs of the domain with a root directory.
    pub fn of(root: &str) -> Self {
        Self(Path::new(root).join(EPOCH_FILE))
    }

    /// The epoch that the next world bears.
    pub fn next(&self) -> u32 {
        let last = fs::read_to_string(&self.0).ok().and_then(|text| text.trim().parse().ok());
        last.unwrap_or(0_u32).saturating_add(1)
    }

    /// Takes note of an epoch.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn note(&self, epoch: u32) -> Result<(), StoreError> {
        let text = format!("{epoch}\n");
        replace(&self.0, &text).map_err(|source| StoreError::Write { path: self.0.clone(), source })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn epochs_go_on_from_run_to_run() {
        let root = tempfile::tempdir().unwrap();
        let epochs = Epochs::of(root.path().to_str().unwrap());
        assert_eq!(epochs.next(), 1);
        epochs.note(1).unwrap();
        epochs.note(2).unwrap();
        assert_eq!(epochs.next(), 3);
        fs::write(root.path().join(EPOCH_FILE), "not a number").unwrap();
        assert_eq!(epochs.next(), 1);
    }

    #[test]
    fn what_cannot_be_written_is_an_error_that_names_the_file() {
        let error = Epochs::of("/nowhere").note(1).unwrap_err().to_string();
        assert!(error.starts_with("/nowhere/lodestoned.epoch: cannot be written: "), "{error}");
    }
}
