//! The demo's own place in shared memory, of which nothing stays.

use std::fs;
use std::path::Path;

use lodestone_config::model::SharedMemory;

/// Where files of POSIX shared memory are.
const SHARED_MEMORY: &str = "/dev/shm";
/// How every demo's names begin; behind it stands its process's number.
const STEM: &str = "lodestone_demo";

/// Prefix and root that no other process uses; their files go with this value.
#[derive(Debug)]
pub struct OwnMemory {
    prefix: String,
    root: String,
}

impl OwnMemory {
    /// The place of a process, by its number. Clears what demos left that were killed.
    pub fn of(pid: u32) -> Self {
        clear_dead(Path::new(SHARED_MEMORY), Path::new("/proc"));
        let prefix = format!("{STEM}{pid}_");
        Self { root: format!("{SHARED_MEMORY}/{prefix}root/"), prefix }
    }

    /// First part of every file's name.
    pub fn prefix(&self) -> &str {
        &self.prefix
    }

    /// Directory of the services' files.
    pub fn root(&self) -> &str {
        &self.root
    }

    /// Has a configuration use it.
    pub fn apply(&self, settings: &mut SharedMemory) {
        settings.prefix.clone_from(&self.prefix);
        settings.root.clone_from(&self.root);
    }
}

impl Drop for OwnMemory {
    fn drop(&mut self) {
        clear(Path::new(SHARED_MEMORY), |name| name.starts_with(&self.prefix));
    }
}

/// Clears what belongs to demos whose process is no more.
fn clear_dead(memory: &Path, processes: &Path) {
    clear(memory, |name| {
        let number = name.strip_prefix(STEM).and_then(|rest| rest.split('_').next());
        let pid = number.and_then(|number| number.parse::<u32>().ok());
        pid.is_some_and(|pid| !processes.join(pid.to_string()).exists())
    });
}

/// What cannot be removed belongs to somebody else, or is gone already.
fn clear(memory: &Path, is_ours: impl Fn(&str) -> bool) {
    for entry in fs::read_dir(memory).into_iter().flatten().flatten() {
        if entry.file_name().to_str().is_some_and(&is_ours) {
            let _ = match entry.file_type() {
                Ok(kind) if kind.is_dir() => fs::remove_dir_all(entry.path()),
                _ => fs::remove_file(entry.path()),
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_dead_demos_left_goes_and_everything_else_stays() {
        let [memory, processes] = [(); 2].map(|()| tempfile::tempdir().unwrap());
        fs::create_dir(processes.path().join("12")).unwrap();
        let dead = ["lodestone_demo11_a.data", "lodestone_demo11_root"];
        let alive = ["lodestone_demo12_a.data", "lodestone_demo_a", "lodestone_x.data", "other"];
        fs::create_dir(memory.path().join(dead[1])).unwrap();
        for name in alive.iter().chain(&dead[..1]) {
            fs::write(memory.path().join(name), "").unwrap();
        }
        clear_dead(memory.path(), processes.path());
        let left = |name: &&str| memory.path().join(name).exists();
        assert_eq!(dead.iter().filter(|n| left(n)).count(), 0);
        assert_eq!(alive.iter().filter(|n| left(n)).count(), alive.len());
    }

    #[test]
    fn two_demos_never_meet() {
        let place = |pid| {
            let mut settings = SharedMemory::default();
            OwnMemory::of(pid).apply(&mut settings);
            settings
        };
        // Numbers that no process can have.
        let [one, two] = [u32::MAX, u32::MAX - 1].map(place);
        assert!(one.prefix != two.prefix && one.root != two.root);
        assert!(one.prefix != SharedMemory::default().prefix);
    }
}
