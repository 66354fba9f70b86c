//! From a voxel's hash to its slot: a hash table of fixed size.
//!
//! Of our own, because a general one must be free to grow or to rehash itself, and this one may do neither:
//! its memory is promised, and a pause of some milliseconds in the middle of a cloud would show. Open
//! addressing with linear probing, half empty at most, and removal that moves later entries back (Knuth,
//! TAOCP 3, 6.4, Algorithm R), so that no tombstones pile up.

/// An entry's upper half is the hash, its lower half the slot plus one; zero is empty.
const EMPTY: u64 = 0;

/// A fixed number of entries, at least twice the slots.
#[derive(Clone, Debug)]
pub(super) struct SlotTable {
    entries: Vec<u64>,
    /// The hash shifted right by this, but for its lowest three bits, is an entry's home.
    shift: u32,
}

impl SlotTable {
    /// A table for so many slots, at most 2^30.
    pub(super) fn new(slots: usize) -> Self {
        let size = (2 * slots).next_power_of_two().max(8);
        Self { entries: vec![EMPTY; size], shift: 32 - size.ilog2() }
    }

    /// Bytes in use, whatever is stored.
    pub(super) fn bytes(&self) -> usize {
        self.entries.capacity() * size_of::<u64>()
    }

    /// The slot stored with this hash that `is_it` recognises.
    #[inline]
    pub(super) fn find(&self, hash: u32, is_it: impl Fn(u32) -> bool) -> Option<u32> {
        let mut at = self.home(hash);
        loop {
            let entry = self.entries[at];
            if entry == EMPTY {
                return None;
            }
            let slot = slot_of(entry);
            if hash_of(entry) == hash && is_it(slot) {
                return Some(slot);
            }
            at = self.after(at);
        }
    }

    /// What the first look finds: most likely the slot stored with this hash, perhaps another's.
    #[inline]
    pub(super) fn guess(&self, hash: u32) -> Option<u32> {
        let entry = self.entries[self.home(hash)];
        (entry != EMPTY).then(|| slot_of(entry))
    }

    /// Stores a slot that is not stored yet; there must be room.
    pub(super) fn insert(&mut self, hash: u32, slot: u32) {
        let mut at = self.home(hash);
        while self.entries[at] != EMPTY {
            at = self.after(at);
        }
        self.entries[at] = u64::from(hash) << 32 | (u64::from(slot) + 1);
    }

    /// Takes a slot out that is stored.
    pub(super) fn remove(&mut self, hash: u32, slot: u32) {
        let wanted = u64::from(hash) << 32 | (u64::from(slot) + 1);
        let mut gap = self.home(hash);
        while self.entries[gap] != wanted {
            if self.entries[gap] == EMPTY {
                debug_assert!(false, "slot {slot} is not stored");
                return;
            }
            gap = self.after(gap);
        }
        self.close(gap);
    }

    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.entries.fill(EMPTY);
    }

    /// Moves entries after a gap back, as far as each may go.
    fn close(&mut self, mut gap: usize) {
        let mask = self.entries.len() - 1;
        let mut at = self.after(gap);
        while self.entries[at] != EMPTY {
            let home = self.home(hash_of(self.entries[at]));
            // It may go to the gap unless its home lies between gap and itself.
            let from_home = at.wrapping_sub(home) & mask;
            let from_gap = at.wrapping_sub(gap) & mask;
            if from_home >= from_gap {
                self.entries[gap] = self.entries[at];
                gap = at;
            }
            at = self.after(at);
        }
        self.entries[gap] = EMPTY;
    }

    #[inline]
    fn home(&self, hash: u32) -> usize {
        ((hash >> self.shift) & !7 | hash & 7) as usize
    }

    #[inline]
    fn after(&self, at: usize) -> usize {
        (at + 1) & (self.entries.len() - 1)
    }
}

#[inline]
const fn hash_of(entry: u64) -> u32 {
    (entry >> 32) as u32
}

#[inline]
const fn slot_of(entry: u64) -> u32 {
    entry as u32 - 1
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn behaves_as_a_map_whatever_comes_and_goes(
            orders in prop::collection::vec((any::<bool>(), 0..16_u32, 0..4_u32), 1..400),
        ) {
            // Given a table that is full to the brim at times, with hashes that collide
            let mut table = SlotTable::new(16);
            let mut expected: HashMap<u32, u32> = HashMap::new();
            for (insert, slot, hash) in orders {
                // Homes at both ends of the table, so that runs wrap around.
                let hash = (hash.wrapping_sub(1) << 30) | (slot % 3);
                if insert {
                    expected.entry(slot).or_insert_with(|| {
                        table.insert(hash, slot);
                        hash
                    });
                } else if let Some(hash) = expected.remove(&slot) {
                    table.remove(hash, slot);
                }
                for slot in 0..16 {
                    let hash = expected.get(&slot).copied();
                    let found = hash.and_then(|hash| table.find(hash, |s| s == slot));
                    prop_assert_eq!(found, hash.map(|_| slot));
                }
            }
            let stored = table.entries.iter().filter(|&&entry| entry != EMPTY).count();
            prop_assert_eq!(stored, expected.len());
        }
    }
}
