//! Reads reports from a hidraw descriptor.
//!
//! hidapi could read as well, but it polls again before each read (two calls a report), turns an
//! unplugged device into a text, and gives up the reports still in the ring when the device
//! hangs up (hidapi 2.6.7, `src/linux_native.rs`, `read_timeout`). Reading the descriptor until
//! it would block is one call a report, tells errors apart by number, and drains what the kernel
//! still holds. Neither way allocates.

use std::os::fd::OwnedFd;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags};
use rustix::io::Errno;

use super::attendant::timespec;
use super::raw::REPORT_LEN;

/// Most reports taken after one wake-up: twice the kernel's ring, so that a device which never
/// stops sending cannot hold the thread.
const BATCH: usize = 128;

/// How reading went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// Nothing came within the time.
    Silent,
    /// Reports came, or may come: ask again.
    Open,
    /// The device is gone.
    Gone,
}

/// Waits at most `timeout` for a report.
pub(super) fn wait(fd: &OwnedFd, timeout: Duration) -> Outcome {
    let mut fds = [PollFd::new(fd, PollFlags::IN)];
    match rustix::event::poll(&mut fds, Some(&timespec(timeout))) {
        Ok(0) => Outcome::Silent,
        // A hang-up shows in `drain`, after what the ring still holds.
        Ok(_) | Err(Errno::INTR) => Outcome::Open,
        Err(_) => Outcome::Gone,
    }
}

/// Hands every report that the kernel holds to `take`, oldest first.
pub(super) fn drain(fd: &OwnedFd, mut take: impl FnMut(&[u8])) -> Outcome {
    let mut buffer = [0_u8; REPORT_LEN];
    for _ in 0..BATCH {
        match rustix::io::read(fd, &mut buffer) {
            Ok(0) => return Outcome::Gone,
            Ok(length) => take(&buffer[..length]),
            Err(Errno::AGAIN) => return Outcome::Open,
            Err(Errno::INTR) => {}
            Err(_) => return Outcome::Gone,
        }
    }
    Outcome::Open
}
