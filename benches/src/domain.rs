//! A place in shared memory that nothing else uses, and that goes with the bench.

use std::fs;
use std::io;

use lodestone_schema::transport::Domain;
use tempfile::TempDir;

/// A domain of its own; dropping it removes its files.
#[derive(Debug)]
pub struct OwnDomain {
    domain: Domain,
    _root: TempDir,
}

impl OwnDomain {
    /// A domain named after this process and a purpose.
    ///
    /// # Errors
    /// If there is no place for temporary files.
    pub fn new(purpose: &str) -> io::Result<Self> {
        let root = tempfile::tempdir()?;
        let prefix = format!("bench{}_{purpose}_", std::process::id());
        let domain = Domain { prefix, root: format!("{}/", root.path().display()) };
        Ok(Self { domain, _root: root })
    }

    /// The domain.
    pub const fn domain(&self) -> &Domain {
        &self.domain
    }
}

impl Drop for OwnDomain {
    fn drop(&mut self) {
        let Ok(files) = fs::read_dir("/dev/shm") else { return };
        let of_ours =
            |name: &std::ffi::OsStr| name.to_string_lossy().starts_with(&self.domain.prefix);
        for file in files.flatten().filter(|file| of_ours(&file.file_name())) {
            // Already gone is as good.
            let _ = fs::remove_file(file.path());
        }
    }
}
