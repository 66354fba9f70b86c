//! A triple buffer of atomic words.
//!
//! The writer fills a slot that no reader can see and exchanges it for the shared one in a single
//! atomic operation; the reader does the same from its side. So both are wait-free, and a reader
//! sees one report whole, never a mixture of two. (A queue of capacity one would make the lane
//! spin while a reader is preempted inside it: with real-time priority on the same core, forever.)

use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// Set in `shared` while the slot it names holds a report that no reader took.
const FRESH: u8 = 0b100;
const SLOT: u8 = 0b011;

/// Where one thread reports and others look.
#[derive(Debug)]
pub(crate) struct TripleBuffer<const WORDS: usize> {
    slots: [[AtomicU64; WORDS]; 3],
    /// The slot between writer and reader.
    shared: AtomicU8,
    /// The slot being written; the writer's alone.
    back: AtomicU8,
    /// The slot being read; readers take turns, the writer never touches it.
    front: Mutex<u8>,
}

impl<const WORDS: usize> TripleBuffer<WORDS> {
    /// A buffer in which readers find `blank` until something is reported.
    pub(crate) fn new(blank: &[u64; WORDS]) -> Self {
        let slot = || core::array::from_fn(|word| AtomicU64::new(blank[word]));
        Self {
            slots: [slot(), slot(), slot()],
            shared: AtomicU8::new(1),
            back: AtomicU8::new(0),
            front: Mutex::new(2),
        }
    }

    /// Reports. Wait-free; for one thread only (two would mix their reports).
    pub(crate) fn report(&self, words: &[u64; WORDS]) {
        let back = self.back.load(Ordering::Relaxed);
        for (place, word) in self.slots[usize::from(back)].iter().zip(words) {
            place.store(*word, Ordering::Relaxed);
        }
        // Release: the words are written before the slot is handed over. Acquire: the reader has
        // finished with the slot that comes back.
        let given = self.shared.swap(back | FRESH, Ordering::AcqRel);
        self.back.store(given & SLOT, Ordering::Relaxed);
    }

    /// The last report; the blank one before the first.
    pub(crate) fn read(&self) -> [u64; WORDS] {
        let mut front = self.front.lock().unwrap_or_else(PoisonError::into_inner);
        if self.shared.load(Ordering::Relaxed) & FRESH != 0 {
            *front = self.shared.swap(*front, Ordering::AcqRel) & SLOT;
        }
        let slot = &self.slots[usize::from(*front)];
        core::array::from_fn(|word| slot[word].load(Ordering::Relaxed))
    }
}
