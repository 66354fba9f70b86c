//! Processor time of processes and their threads, from the scheduler's own account.

use std::fs;
use std::path::Path;

/// What each thread of a process has used since it started, ns, by its name; threads of the same name
/// together. Empty if the process is gone, or the kernel keeps no account.
pub fn by_thread(pid: u32) -> Vec<(String, u64)> {
    let tasks = fs::read_dir(format!("/proc/{pid}/task")).into_iter().flatten().flatten();
    let mut threads: Vec<(String, u64)> = Vec::new();
    for (name, ns) in tasks.filter_map(|task| thread(&task.path())) {
        match threads.iter_mut().find(|(known, _)| *known == name) {
            Some((_, total)) => *total += ns,
            None => threads.push((name, ns)),
        }
    }
    threads
}

/// What a whole process has used, ns.
pub fn of_process(pid: u32) -> u64 {
    by_thread(pid).iter().map(|(_, ns)| ns).sum()
}

/// Name and time of one thread, by its directory under `/proc`.
fn thread(task: &Path) -> Option<(String, u64)> {
    let name = fs::read_to_string(task.join("comm")).ok()?;
    // schedstat: time on a processor and time waiting for one, ns, and time slices.
    let account = fs::read_to_string(task.join("schedstat")).ok()?;
    Some((name.trim().to_owned(), account.split(' ').next()?.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::*;

    #[test]
    fn time_that_is_spent_is_accounted_for() {
        let pid = std::process::id();
        let before = of_process(pid);
        let begin = Instant::now();
        while of_process(pid) == before && begin.elapsed() < Duration::from_mins(1) {
            std::hint::spin_loop();
        }
        assert!(of_process(pid) > before);
        assert_eq!(of_process(u32::MAX), 0);
    }
}
