//! A domain of its own for each test process, and a publisher in a process of its own.
#![allow(dead_code, clippy::cast_possible_wrap, reason = "each test file uses a part of it")]

pub(crate) mod listener;
pub(crate) mod publisher;
pub(crate) mod scanner;

use std::env;
use std::fs;
use std::process;
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::thread::sleep;
use std::time::{Duration, Instant};

use lodestone_client::Client;

/// Prefix and root that no other test process uses; its files go with the last holder.
pub(crate) struct TestDomain {
    pub(crate) prefix: String,
    pub(crate) root: String,
}

/// A process is in one domain only, so its tests share it and differ in the cameras' names.
static IN_USE: Mutex<Weak<TestDomain>> = Mutex::new(Weak::new());

impl TestDomain {
    /// The domain of this process.
    pub(crate) fn shared() -> Arc<Self> {
        let mut in_use = IN_USE.lock().unwrap_or_else(PoisonError::into_inner);
        in_use.upgrade().unwrap_or_else(|| {
            let made = Arc::new(Self::named("s"));
            *in_use = Arc::downgrade(&made);
            made
        })
    }

    /// A domain for child processes only.
    pub(crate) fn named(name: &str) -> Self {
        let prefix = format!("lodestone_test_{}_{name}_", process::id());
        let root = format!("{}/{prefix}/", env::temp_dir().display());
        Self { prefix, root }
    }

    pub(crate) fn client(&self) -> Client {
        Client::builder().prefix(&self.prefix).root(&self.root).connect().expect("enters")
    }
}

impl Drop for TestDomain {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.root);
        for entry in fs::read_dir("/dev/shm").into_iter().flatten().flatten() {
            if entry.file_name().to_string_lossy().starts_with(&self.prefix) {
                let _ = fs::remove_file(entry.path());
            }
        }
    }
}

/// Tries until something is there; the limit only ends a test that would hang.
pub(crate) fn eventually<T>(what: &str, mut attempt: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    while begin.elapsed() < Duration::from_secs(30) {
        if let Some(found) = attempt() {
            return found;
        }
        sleep(Duration::from_millis(5));
    }
    panic!("never happened: {what}")
}
