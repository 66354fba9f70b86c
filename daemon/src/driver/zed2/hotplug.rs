//! A notice when a hidraw node appears or changes its rights.
//!
//! inotify on `/dev`, not netlink: a service with a private network gets no uevents. udev changes
//! the node's group after the kernel made it, so a change of attributes counts, too.

use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

use rustix::fs::inotify::{self, CreateFlags, WatchFlags};
use rustix::io::Errno;

/// Watches a directory for device nodes.
pub(super) struct Watch {
    inotify: OwnedFd,
}

impl Watch {
    /// Begins to watch.
    ///
    /// # Errors
    ///
    /// The directory is not there, or the user's inotify instances are used up.
    pub(super) fn new(directory: &str) -> Result<Self, Errno> {
        let inotify = inotify::init(CreateFlags::NONBLOCK | CreateFlags::CLOEXEC)?;
        let flags = WatchFlags::CREATE | WatchFlags::ATTRIB | WatchFlags::MOVED_TO;
        inotify::add_watch(&inotify, directory, flags)?;
        Ok(Self { inotify })
    }

    /// Takes all notices; whether one was of a hidraw node (or may have been).
    pub(super) fn take(&self) -> bool {
        let mut buffer = [MaybeUninit::uninit(); 1024];
        let mut reader = inotify::Reader::new(&self.inotify, &mut buffer);
        let mut relevant = false;
        while let Ok(event) = reader.next() {
            let is_hidraw = |name: &std::ffi::CStr| name.to_bytes().starts_with(b"hidraw");
            let overflow = event.events().contains(inotify::ReadFlags::QUEUE_OVERFLOW);
            relevant |= overflow || event.file_name().is_some_and(is_hidraw);
        }
        relevant
    }
}

impl AsFd for Watch {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.inotify.as_fd()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_hidraw_nodes_are_noticed_once_each() {
        let directory = tempfile::tempdir().unwrap();
        let watch = Watch::new(directory.path().to_str().unwrap()).unwrap();
        assert!(!watch.take(), "nothing happened yet");

        std::fs::write(directory.path().join("ttyUSB0"), "").unwrap();
        assert!(!watch.take(), "another device");

        std::fs::write(directory.path().join("hidraw3"), "").unwrap();
        assert!(watch.take());
        assert!(!watch.take(), "the notice was taken");
    }
}
