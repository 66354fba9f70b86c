//! A place in shared memory for one test.

use std::fs;
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicU64, Ordering};

use tempfile::TempDir;

/// Most consumers of one camera's poses in a [`TestDomain::configuration`].
pub const MOST_CONSUMERS: usize = 4;

static DOMAINS: AtomicU64 = AtomicU64::new(0);

/// Prefix and root that no other test uses, and a directory for its files; all of it goes with
/// this value, also after a panic. Processes of the domain must end first.
#[derive(Debug)]
pub struct TestDomain {
    /// Prefix of every file on `/dev/shm`.
    pub prefix: String,
    /// Root directory of the services.
    pub root: String,
    directory: TempDir,
}

impl Default for TestDomain {
    fn default() -> Self {
        Self::new()
    }
}

impl TestDomain {
    /// A domain that nobody is in.
    pub fn new() -> Self {
        let number = DOMAINS.fetch_add(1, Ordering::Relaxed);
        let prefix = format!("lt{}_{number}_", process::id());
        let directory = tempfile::tempdir().expect("a temporary directory");
        let root = format!("{}/", directory.path().join("root").display());
        Self { prefix, root, directory }
    }

    /// The directory for the test's files.
    pub fn directory(&self) -> &Path {
        self.directory.path()
    }

    /// Writes a configuration of this domain; `rest` is everything but `[shared_memory]`.
    pub fn configuration(&self, rest: &str) -> PathBuf {
        let path = self.directory().join("lodestone.toml");
        let text = format!(
            "[shared_memory]\nprefix = \"{}\"\nroot = \"{}\"\npose_history = 512\n\
             max_subscribers = {MOST_CONSUMERS}\n\n{rest}",
            self.prefix, self.root
        );
        fs::write(&path, text).expect("writes");
        path
    }

    /// Files of this domain on `/dev/shm`.
    pub fn shared_memory_files(&self) -> Vec<String> {
        let entries = fs::read_dir("/dev/shm").expect("shared memory").flatten();
        let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
        names.filter(|name| name.starts_with(&self.prefix)).collect()
    }

    /// Files on `/dev/shm` that hold messages, which only living processes have a use for.
    pub fn memory_in_use(&self) -> Vec<String> {
        let holds = |name: &String| {
            [".data", ".dynamic", ".connection"].iter().any(|suffix| name.ends_with(suffix))
        };
        self.shared_memory_files().into_iter().filter(holds).collect()
    }

    /// Everything the domain consists of: files on `/dev/shm` and below the root.
    pub fn all_files(&self) -> Vec<String> {
        let mut files = self.shared_memory_files();
        collect(Path::new(&self.root), &mut files);
        files
    }
}

fn collect(directory: &Path, files: &mut Vec<String>) {
    // A file may go while it is looked at: whoever made it lives.
    for entry in fs::read_dir(directory).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() { collect(&path, files) } else { files.push(path.display().to_string()) }
    }
}

impl Drop for TestDomain {
    fn drop(&mut self) {
        for name in self.shared_memory_files() {
            let _ = fs::remove_file(format!("/dev/shm/{name}"));
        }
    }
}
