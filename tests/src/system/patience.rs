//! Waiting for what must come, and saying what could not be tried.

use std::io::Write;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// What is waited for comes within milliseconds; this only ends a test that would hang.
pub const PATIENCE: Duration = Duration::from_mins(1);

/// Tries until something is there.
///
/// # Panics
/// If it never comes.
pub fn eventually<T>(what: &str, mut attempt: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    while begin.elapsed() < PATIENCE {
        if let Some(found) = attempt() {
            return found;
        }
        sleep(Duration::from_millis(5));
    }
    panic!("never happened: {what}")
}

/// Says that a test could not be tried here, past the harness, which swallows what a passing test
/// prints.
pub fn skipped(why: &str) {
    let _ = writeln!(std::io::stderr(), "skipped: {why}");
}
