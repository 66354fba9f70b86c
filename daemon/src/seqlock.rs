//! The last report of one thread, which any number of others read, none of them in anybody's way.
//!
//! Two slots of atomic words and a counter. The writer fills the slot that the counter does not name and
//! counts on: wait-free. A reader copies the slot that the counter names; where the counter has gone on
//! meanwhile, the writer may have begun in that very slot, and it reads anew. A writer that is interrupted
//! does not count, so a reader waits for nobody, and what a lane reads of another one needs no lock.
//! (Boehm 2012, "Can seqlocks get along with programming language memory models?", for the fences.)

use std::sync::atomic::{AtomicU64, Ordering, fence};

/// A reader must be interrupted as often, each time for a whole report, to come away without one.
const TRIES: usize = 16;

/// Where one thread reports and others look.
#[derive(Debug)]
pub(crate) struct SeqLock<const WORDS: usize> {
    slots: [[AtomicU64; WORDS]; 2],
    /// Reports so far.
    count: AtomicU64,
}

impl<const WORDS: usize> SeqLock<WORDS> {
    /// A lock in which readers find `blank` until something is reported.
    pub(crate) fn new(blank: &[u64; WORDS]) -> Self {
        let slot = || core::array::from_fn(|word| AtomicU64::new(blank[word]));
        Self { slots: [slot(), slot()], count: AtomicU64::new(0) }
    }

    /// Reports. Wait-free; for one thread only (two would mix their reports).
    pub(crate) fn report(&self, words: &[u64; WORDS]) {
        let count = self.count.load(Ordering::Relaxed) + 1;
        // A reader that sees one of the words below sees the count before this one too, and reads anew.
        fence(Ordering::Release);
        for (place, word) in self.slots[(count % 2) as usize].iter().zip(words) {
            place.store(*word, Ordering::Relaxed);
        }
        self.count.store(count, Ordering::Release);
    }

    /// The last report; the blank one before the first. `None` if reports came faster than they could be
    /// read, again and again.
    pub(crate) fn read(&self) -> Option<[u64; WORDS]> {
        (0..TRIES).find_map(|_| {
            let count = self.count.load(Ordering::Acquire);
            let slot = &self.slots[(count % 2) as usize];
            let words = core::array::from_fn(|word| slot[word].load(Ordering::Relaxed));
            fence(Ordering::Acquire);
            (self.count.load(Ordering::Relaxed) == count).then_some(words)
        })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use super::*;

    #[test]
    fn blank_before_the_first_and_the_last_one_after() {
        let lock = SeqLock::new(&[7; 3]);
        assert_eq!(lock.read(), Some([7; 3]));
        for k in 0..5 {
            lock.report(&[k; 3]);
            assert_eq!(lock.read(), Some([k; 3]));
        }
    }

    #[test]
    fn two_readers_beside_a_busy_writer_see_whole_reports_in_order() {
        let lock = Arc::new(SeqLock::<64>::new(&[0; 64]));
        let done = Arc::new(AtomicBool::new(false));
        let reader = || {
            let (lock, done) = (Arc::clone(&lock), Arc::clone(&done));
            std::thread::spawn(move || {
                let (mut last, mut seen) = (0, 0_u64);
                while !done.load(Ordering::Relaxed) {
                    let Some(words) = lock.read() else { continue };
                    assert!(words.iter().all(|word| *word == words[0]), "torn: {words:?}");
                    assert!(words[0] >= last);
                    (last, seen) = (words[0], seen + 1);
                }
                seen
            })
        };
        let readers = [reader(), reader()];
        for k in 0..200_000 {
            lock.report(&[k; 64]);
        }
        done.store(true, Ordering::Relaxed);
        for reader in readers {
            assert!(reader.join().expect("nothing was torn") > 0);
        }
    }
}
