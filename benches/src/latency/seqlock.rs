//! A message in shared memory under a sequence lock: what the hardware allows, and no more.
//!
//! One writer, any readers, no queue: a reader gets the newest message or none. Words are atomics, so
//! that a read that overlaps a write is a torn message, which the sequence shows, and not undefined.
#![allow(unsafe_code)] // One mapping; the proof stands beside it.

use std::fs::{File, OpenOptions};
use std::io;
use std::path::Path;
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering, fence};
use std::time::Duration;

use rustix::mm::{MapFlags, ProtFlags, mmap, munmap};
use rustix::thread::futex;
use rustix::time::Timespec;

use super::payload::{Payload, WORDS};

/// What lies in the file.
#[repr(C)]
pub struct Seqlock {
    /// Odd while a message is being written; twice the number of messages otherwise.
    sequence: AtomicU64,
    /// Raised with each message, for whoever sleeps.
    bell: AtomicU32,
    _padding: u32,
    words: [AtomicU64; WORDS],
}

impl Default for Seqlock {
    fn default() -> Self {
        Self {
            sequence: AtomicU64::new(0),
            bell: AtomicU32::new(0),
            _padding: 0,
            words: [const { AtomicU64::new(0) }; WORDS],
        }
    }
}

impl Seqlock {
    /// Writes a message; for one writer only.
    pub fn write(&self, payload: &Payload) {
        let before = self.sequence.load(Ordering::Relaxed);
        self.sequence.store(before + 1, Ordering::Relaxed);
        // No word becomes visible before the odd sequence does.
        fence(Ordering::Release);
        for (place, word) in self.words.iter().zip(payload) {
            place.store(*word, Ordering::Relaxed);
        }
        self.sequence.store(before + 2, Ordering::Release);
    }

    /// The newest message, if it is not the one whose sequence is `known`, with its sequence.
    pub fn read(&self, known: u64) -> Option<(u64, Payload)> {
        loop {
            let before = self.sequence.load(Ordering::Acquire);
            if before == known || before == 0 {
                return None;
            }
            if before.is_multiple_of(2) {
                let payload = std::array::from_fn(|k| self.words[k].load(Ordering::Relaxed));
                // No word is read after the second look at the sequence.
                fence(Ordering::Acquire);
                if self.sequence.load(Ordering::Relaxed) == before {
                    return Some((before, payload));
                }
            }
            std::hint::spin_loop();
        }
    }

    /// Wakes those who sleep in [`Seqlock::sleep`]; always a system call, since who sleeps is not known.
    pub fn ring(&self) {
        self.bell.fetch_add(1, Ordering::Release);
        // It fails only on a bad address or flag, which these are not.
        let _ = futex::wake(&self.bell, futex::Flags::empty(), u32::MAX >> 1);
    }

    /// Sleeps until there is a message other than the one with this sequence, or the time is over.
    pub fn sleep(&self, known: u64, timeout: Duration) {
        let bell = self.bell.load(Ordering::Acquire);
        if self.read(known).is_none() {
            let timeout = Timespec::try_from(timeout).ok();
            // Woken, timed out or interrupted: the caller looks again in any case.
            let _ = futex::wait(&self.bell, futex::Flags::empty(), bell, timeout.as_ref());
        }
    }
}

/// A [`Seqlock`] in a file that several processes map.
pub struct Mapped {
    place: NonNull<Seqlock>,
    /// The file is there as long as its mapping.
    _file: File,
}

impl Mapped {
    /// Makes the file, or opens it if it is there already.
    ///
    /// # Errors
    /// Whatever the system says.
    pub fn open(path: &Path) -> io::Result<Self> {
        let file =
            OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path)?;
        let length = size_of::<Seqlock>();
        // A file that grows is filled with zeros, which is an empty lock. A larger one is not cut.
        if file.metadata()?.len() < length as u64 {
            file.set_len(length as u64)?;
        }
        let (rights, shared) = (ProtFlags::READ | ProtFlags::WRITE, MapFlags::SHARED);
        // SAFETY: the kernel chooses the address, so that nothing that exists is replaced.
        let address = unsafe { mmap(std::ptr::null_mut(), length, rights, shared, &file, 0) }?;
        let place =
            NonNull::new(address.cast()).ok_or_else(|| io::Error::other("mapped at zero"))?;
        Ok(Self { place, _file: file })
    }

    /// What is mapped.
    pub const fn get(&self) -> &Seqlock {
        // SAFETY: `place` is the start of a mapping of the length of a `Seqlock`, at the beginning of
        // a page and so aligned; it is mapped until this value is dropped, to which the reference is
        // bound. Every bit pattern is a `Seqlock`: it consists of integers. Other processes write to it,
        // and nobody writes but through atomics; the padding is never touched. The file is not
        // shortened: it is in a directory of the harness's own, whose parts only ever open it here.
        unsafe { self.place.as_ref() }
    }
}

impl Drop for Mapped {
    fn drop(&mut self) {
        // SAFETY: the mapping was made in `open` with this length, and no reference outlives `self`.
        let unmapped = unsafe { munmap(self.place.as_ptr().cast(), size_of::<Seqlock>()) };
        debug_assert!(unmapped.is_ok(), "{unmapped:?}");
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::thread;

    use super::*;
    use crate::latency::payload::{payload, sequence};

    /// Panics on a message that mixes two.
    fn assert_whole(found: &Payload) {
        assert_eq!(*found, payload(sequence(found), 0), "torn");
    }

    #[test]
    fn two_mappings_of_one_file_see_each_other() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("lock");
        let (a, b) = (Mapped::open(&path).expect("makes"), Mapped::open(&path).expect("opens"));
        assert_eq!(b.get().read(0), None);
        a.get().write(&payload(5, 0));
        let (known, found) = b.get().read(0).expect("a message");
        assert_eq!(found, payload(5, 0));
        assert_eq!(b.get().read(known), None, "nothing new");
    }

    #[test]
    fn no_reader_ever_sees_a_torn_message_or_one_from_before() {
        const MESSAGES: u64 = 200_000;
        let lock = Arc::new(Seqlock::default());
        let readers: Vec<_> = (0..2)
            .map(|_| {
                let lock = Arc::clone(&lock);
                thread::spawn(move || {
                    let (mut known, mut last) = (0, 0);
                    while last < MESSAGES {
                        let Some((at, found)) = lock.read(known) else {
                            thread::yield_now();
                            continue;
                        };
                        assert_whole(&found);
                        assert!(sequence(&found) > last, "back in time");
                        (known, last) = (at, sequence(&found));
                    }
                })
            })
            .collect();
        for n in 1..=MESSAGES {
            lock.write(&payload(n, 0));
        }
        for reader in readers {
            reader.join().expect("reads whole messages");
        }
    }

    #[test]
    fn a_sleeper_is_woken_by_the_next_message() {
        // Given a reader that sleeps for as long as it takes: a lost wake-up hangs the test
        let lock = Arc::new(Seqlock::default());
        let reader = {
            let lock = Arc::clone(&lock);
            thread::spawn(move || {
                let mut known = 0;
                for n in 1..=50 {
                    while lock.read(known).is_none() {
                        lock.sleep(known, Duration::from_hours(1));
                    }
                    let (at, found) = lock.read(known).expect("a message");
                    assert!(sequence(&found) >= n);
                    known = at;
                    lock.words[WORDS - 1].load(Ordering::Relaxed);
                    if sequence(&found) >= 50 {
                        return;
                    }
                }
            })
        };
        for n in 1..=50 {
            lock.write(&payload(n, 0));
            lock.ring();
            thread::yield_now();
        }
        reader.join().expect("sees the last message");
    }
}
