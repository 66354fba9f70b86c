//! Who runs on which processor.

use std::io;

use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

/// The processors that the calling thread may use, in ascending order.
///
/// # Errors
/// Whatever the system says.
pub fn allowed_processors() -> io::Result<Vec<usize>> {
    let set = sched_getaffinity(None)?;
    Ok((0..CpuSet::MAX_CPU).filter(|cpu| set.is_set(*cpu)).collect())
}

/// Keeps the calling thread, and those that it starts from now on, on one processor.
///
/// # Errors
/// If there is no such processor, or it is not for this process.
pub fn pin_to(cpu: usize) -> io::Result<()> {
    let mut set = CpuSet::new();
    if cpu >= CpuSet::MAX_CPU {
        return Err(io::Error::other("no such processor"));
    }
    set.set(cpu);
    Ok(sched_setaffinity(None, &set)?)
}
