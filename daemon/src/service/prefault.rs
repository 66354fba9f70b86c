//! Backs shared memory with pages before the lane touches it.
//!
//! iceoryx2 sizes its files with `ftruncate`, which reserves nothing: on a full `/dev/shm` the
//! first write to a new page is SIGBUS. [`prefault`] reserves every page (an error if there is no
//! room), then maps them, so that the lane takes no page fault either.
#![allow(unsafe_code)] // madvise on our own mappings; the one call below carries its proof.

use std::collections::BTreeSet;
use std::fs::{OpenOptions, read_to_string};
use std::io;
use std::sync::{Mutex, PoisonError};

use rustix::fs::{FallocateFlags, fallocate};
use rustix::io::Errno;
use rustix::mm::{Advice, madvise};

/// Where POSIX shared memory lies on Linux.
pub const SHARED_MEMORY_DIRECTORY: &str = "/dev/shm";

/// Why shared memory could not be backed.
#[derive(Debug, thiserror::Error)]
pub enum PrefaultError {
    /// There is no room for the pages.
    #[error("/dev/shm is full: no room for the {len} bytes of {path}")]
    Full {
        /// The file.
        path: String,
        /// Its size, bytes.
        len: u64,
    },
    /// The list of mappings or a file could not be read.
    #[error("cannot reserve the memory of {path}: {source}")]
    Io {
        /// The file.
        path: String,
        /// What the system says.
        source: io::Error,
    },
}

/// A mapping of a shared-memory file.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Mapping {
    start: usize,
    len: usize,
    path: String,
}

/// Reserves and maps every page of every shared-memory file that this process has mapped
/// writable and whose name begins with the prefix; returns their size in bytes.
///
/// Contents stay as they are. Call it after the publishers were made and before the first send. Of
/// several lanes each has its own made, and finds those of the others done.
///
/// # Errors
/// [`PrefaultError`]; nothing was written in that case, so nothing can have raised SIGBUS.
pub fn prefault(prefix: &str) -> Result<u64, PrefaultError> {
    let maps = read_to_string("/proc/self/maps")
        .map_err(|source| PrefaultError::Io { path: "/proc/self/maps".into(), source })?;
    let wanted = format!("{SHARED_MEMORY_DIRECTORY}/{prefix}");
    let mut total = 0;
    for mapping in maps.lines().filter_map(|line| parse(line, &wanted)) {
        if is_done(&mapping) {
            total += mapping.len as u64;
            continue;
        }
        total += reserve(&mapping.path)?;
        populate(&mapping);
        note_done(mapping);
    }
    Ok(total)
}

/// What this process has reserved and mapped so far. Names of iceoryx2's files are never used twice.
static DONE: Mutex<BTreeSet<(usize, String)>> = Mutex::new(BTreeSet::new());

fn is_done(mapping: &Mapping) -> bool {
    let done = DONE.lock().unwrap_or_else(PoisonError::into_inner);
    done.contains(&(mapping.start, mapping.path.clone()))
}

fn note_done(mapping: Mapping) {
    let mut done = DONE.lock().unwrap_or_else(PoisonError::into_inner);
    done.insert((mapping.start, mapping.path));
}

/// Reads a line of `/proc/self/maps`: `start-end perms offset device inode path`.
fn parse(line: &str, wanted: &str) -> Option<Mapping> {
    let path_at = line.find('/')?;
    let (fields, path) = line.split_at(path_at);
    let mut fields = fields.split_ascii_whitespace();
    let (start, end) = fields.next()?.split_once('-')?;
    let shared_and_writable = fields.next()? == "rw-s";
    let start = usize::from_str_radix(start, 16).ok()?;
    let end = usize::from_str_radix(end, 16).ok()?;
    let ours = path.starts_with(wanted) && !path.ends_with(" (deleted)");
    (shared_and_writable && ours).then(|| Mapping {
        start,
        len: end.saturating_sub(start),
        path: path.into(),
    })
}

fn reserve(path: &str) -> Result<u64, PrefaultError> {
    let failed = |source| PrefaultError::Io { path: path.into(), source };
    let file = match OpenOptions::new().read(true).write(true).open(path) {
        Ok(file) => file,
        // A neighbour's connection that ended between the listing and now.
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(0),
        Err(e) => return Err(failed(e)),
    };
    let len = file.metadata().map_err(failed)?.len();
    match fallocate(&file, FallocateFlags::KEEP_SIZE, 0, len.max(1)) {
        Ok(()) => Ok(len),
        Err(Errno::NOSPC) => Err(PrefaultError::Full { path: path.into(), len }),
        Err(errno) => Err(failed(errno.into())),
    }
}

/// Makes the page tables; where the kernel is older than 5.14 the first writes do it instead.
fn populate(mapping: &Mapping) {
    let address = std::ptr::with_exposed_provenance_mut(mapping.start);
    // SAFETY: MADV_POPULATE_WRITE changes neither contents nor the mapping's extent or
    // protection, whatever lies at the address: it only faults pages in, and reports ENOMEM or
    // EFAULT instead of raising a signal where it cannot. So even a range that another thread
    // has unmapped since the listing is harmless. No Rust reference is made.
    let _ = unsafe { madvise(address, mapping.len, Advice::LinuxPopulateWrite) };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_writable_shared_files_of_the_prefix_count() {
        let line = "7f00-9f00 rw-s 00000000 00:1a 22   /dev/shm/ls_1.data";
        let found = parse(line, "/dev/shm/ls_").unwrap();
        assert_eq!(
            found,
            Mapping { start: 0x7f00, len: 0x2000, path: "/dev/shm/ls_1.data".into() }
        );
        for other in [
            "7f00-9f00 r--s 00000000 00:1a 22   /dev/shm/ls_1.data",
            "7f00-9f00 rw-p 00000000 00:1a 22   /dev/shm/ls_1.data",
            "7f00-9f00 rw-s 00000000 00:1a 22   /dev/shm/other_1.data",
            "7f00-9f00 rw-s 00000000 00:1a 22   /dev/shm/ls_1.data (deleted)",
            "7f00-9f00 rw-p 00000000 00:00 0    [heap]",
            "",
        ] {
            assert_eq!(parse(other, "/dev/shm/ls_"), None, "{other}");
        }
    }
}
