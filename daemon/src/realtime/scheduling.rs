//! The one call that no crate of ours wraps.
#![allow(unsafe_code)] // A system call with a pointer; its proof stands beside it.

use std::io;

use libc::{SCHED_FIFO, SCHED_RESET_ON_FORK, SYS_sched_setscheduler, c_int};
use rustix::io::Errno;

/// `struct sched_param` of the kernel; the C library's may have more.
#[repr(C)]
struct SchedParam {
    sched_priority: c_int,
}

/// Puts the calling thread under `SCHED_FIFO`; threads that it starts are scheduled normally.
///
/// # Errors
/// What the kernel says: `EPERM` without the right.
pub(super) fn become_fifo(priority: u8) -> Result<(), Errno> {
    const THIS_THREAD: c_int = 0;
    let param = SchedParam { sched_priority: priority.into() };
    let policy = SCHED_FIFO | SCHED_RESET_ON_FORK;
    // SAFETY: the call takes a thread id, a policy and a pointer to a `struct sched_param`, which
    // `param` is in the kernel's layout. The kernel only reads it, and only during the call, and
    // `param` outlives the call. The C library's wrapper is passed by, as musl's refuses.
    let result =
        unsafe { libc::syscall(SYS_sched_setscheduler, THIS_THREAD, policy, &raw const param) };
    if result == 0 {
        return Ok(());
    }
    Err(Errno::from_io_error(&io::Error::last_os_error()).unwrap_or(Errno::PERM))
}
