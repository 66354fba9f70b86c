//! One daemon per domain: an exclusive lock in the domain's root directory.
//!
//! iceoryx2 accepts a second publisher of the same service, and consumers would see two
//! interleaved streams. The lock is `flock`: the kernel drops it when its holder ends, however it
//! ends, so the file that stays behind locks nobody out.

use std::fs::{DirBuilder, File, OpenOptions};
use std::io::{self, Read, Seek, Write};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use lodestone_schema::transport::LOCK_FILE;
use rustix::fs::{FlockOperation, OFlags, flock};
use rustix::io::Errno;

/// More than a holder's description ever needs, bytes.
const LONGEST_DESCRIPTION: u64 = 256;

/// The proof that this process is the domain's only daemon; the lock ends with it.
#[derive(Debug)]
pub struct InstanceLock {
    // Closing the file releases the lock.
    _file: File,
}

/// Who holds the lock, as the lock file tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Holder {
    /// Process id.
    pub pid: u32,
    /// When it took the lock, whole seconds since the UNIX epoch.
    pub since_unix_s: u64,
}

/// Why the lock was not taken.
#[derive(Debug, thiserror::Error)]
pub enum InstanceError {
    /// Another daemon has it.
    #[error(
        "another lodestoned{} already serves {root}: stop it, or give this one another shared_memory.root",
        describe(*.holder)
    )]
    Held {
        /// The domain's root directory.
        root: String,
        /// The other daemon; `None` while it is still writing the file.
        holder: Option<Holder>,
    },
    /// The root directory is not there and cannot be made.
    #[error("cannot make the directory {root} (shared_memory.root): {source}")]
    MakeRoot {
        /// The domain's root directory.
        root: String,
        /// What the system says.
        source: io::Error,
    },
    /// The lock file cannot be opened or written.
    #[error(
        "cannot write {path}: {source} (does {root}, shared_memory.root, belong to another user, or is its file system full?)"
    )]
    Write {
        /// The lock file.
        path: String,
        /// The domain's root directory.
        root: String,
        /// What the system says.
        source: io::Error,
    },
}

fn describe(holder: Option<Holder>) -> String {
    holder.map_or_else(String::new, |holder| {
        format!(" (pid {}, running for {} s)", holder.pid, age_s(holder.since_unix_s))
    })
}

fn age_s(since_unix_s: u64) -> u64 {
    unix_now_s().saturating_sub(since_unix_s)
}

fn unix_now_s() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs())
}

impl InstanceLock {
    /// Takes the lock of the domain whose root directory is given, and never waits for it.
    ///
    /// A root that is missing is made, for this user alone (mode 0700 less the umask); one that
    /// exists keeps its mode, so a group can share it.
    ///
    /// # Errors
    /// [`InstanceError`] names the holder, or what the file system refused.
    pub fn acquire(root: &str) -> Result<Self, InstanceError> {
        make_root(root)?;
        let path = Path::new(root).join(LOCK_FILE);
        let mut file = open(&path).map_err(|source| refused(root, &path, source))?;
        match flock(&file, FlockOperation::NonBlockingLockExclusive) {
            Ok(()) => {}
            Err(Errno::WOULDBLOCK) => {
                return Err(InstanceError::Held { root: root.into(), holder: read(&mut file) });
            }
            Err(errno) => return Err(refused(root, &path, errno.into())),
        }
        match write(&mut file) {
            Ok(()) => {}
            // The lock holds without a description. A root on /dev/shm is full together with
            // the memory, and the check that follows says what is needed.
            Err(e) if e.kind() == io::ErrorKind::StorageFull => {}
            Err(source) => return Err(refused(root, &path, source)),
        }
        Ok(Self { _file: file })
    }
}

fn make_root(root: &str) -> Result<(), InstanceError> {
    let made = DirBuilder::new().recursive(true).mode(0o700).create(root);
    made.map_err(|source| InstanceError::MakeRoot { root: root.into(), source })
}

/// Opens without truncating: the holder's description must survive a second daemon's attempt.
fn open(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).write(true).create(true).truncate(false).mode(0o644);
    // In a directory that others may write, a link could point at any file of ours.
    options.custom_flags(OFlags::NOFOLLOW.bits().cast_signed()).open(path)
}

fn write(file: &mut File) -> io::Result<()> {
    let text = format!("pid {}\nsince_unix_s {}\n", std::process::id(), unix_now_s());
    file.set_len(0)?;
    file.write_all(text.as_bytes())
}

fn read(file: &mut File) -> Option<Holder> {
    let mut text = String::new();
    file.rewind().ok()?;
    file.take(LONGEST_DESCRIPTION).read_to_string(&mut text).ok()?;
    let value = |key: &str| text.lines().find_map(|line| line.strip_prefix(key));
    Some(Holder {
        pid: value("pid ")?.parse().ok()?,
        since_unix_s: value("since_unix_s ")?.parse().ok()?,
    })
}

fn refused(root: &str, path: &Path, source: io::Error) -> InstanceError {
    let path: PathBuf = path.into();
    InstanceError::Write { path: path.display().to_string(), root: root.into(), source }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_daemon_is_refused_and_told_who_the_first_one_is() {
        let root = tempfile::tempdir().unwrap();
        let root = root.path().join("deep/inside").display().to_string();
        let _first = InstanceLock::acquire(&root).unwrap();

        // A second open file description contends even within one process.
        let refused = InstanceLock::acquire(&root).unwrap_err();

        let holder = match &refused {
            InstanceError::Held { holder: Some(holder), .. } => *holder,
            other => panic!("expected a holder, got {other:?}"),
        };
        assert_eq!(holder.pid, std::process::id());
        assert!(refused.to_string().contains(&format!("pid {}", std::process::id())), "{refused}");
    }

    #[test]
    fn a_lock_given_back_can_be_taken_again_though_its_file_stays() {
        let root = tempfile::tempdir().unwrap();
        let root = root.path().display().to_string();
        drop(InstanceLock::acquire(&root).unwrap());
        assert!(Path::new(&root).join(LOCK_FILE).exists());
        InstanceLock::acquire(&root).unwrap();
    }

    #[test]
    fn a_root_that_cannot_be_made_is_named() {
        let root = tempfile::tempdir().unwrap();
        let file = root.path().join("file");
        std::fs::write(&file, "not a directory").unwrap();
        let wanted = file.join("root").display().to_string();
        let error = InstanceLock::acquire(&wanted).unwrap_err();
        assert!(matches!(error, InstanceError::MakeRoot { .. }), "{error:?}");
        assert!(error.to_string().contains(&wanted), "{error}");
    }

    #[test]
    fn a_lock_file_that_cannot_be_written_is_named() {
        let root = tempfile::tempdir().unwrap();
        std::fs::create_dir(root.path().join(LOCK_FILE)).unwrap();
        let error = InstanceLock::acquire(&root.path().display().to_string()).unwrap_err();
        assert!(matches!(error, InstanceError::Write { .. }), "{error:?}");
        assert!(error.to_string().contains(LOCK_FILE), "{error}");
    }
}
