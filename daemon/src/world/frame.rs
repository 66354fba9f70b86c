//! What lanes and keeper agree on, without a lock.

use std::sync::atomic::{AtomicU64, Ordering};

use lodestone_fusion::relative::Tied;

use super::founding::{self, Founding};
use super::motion::{self, Motion};
use super::tie::{self, TieReport};
use crate::seqlock::SeqLock;
use crate::triple_buffer::TripleBuffer;

/// How far the world is, as one atomic word says it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WorldPhase {
    /// Epoch of the world; while it waits, of the world to come.
    pub epoch: u32,
    /// Whether it is fixed.
    pub fixed: bool,
    /// Whether the starts of the configuration are places in it; while it waits, they are taken to be.
    pub starts_hold: bool,
    /// The member that fixed it, or that may fix it while it waits; `None` if a camera fixed it that is
    /// not here.
    pub member: Option<u16>,
}

/// The world as all members of one daemon share it.
///
/// Members are the cameras in the order of the configuration, and the bodies after them.
#[derive(Debug)]
pub struct WorldFrame {
    word: AtomicU64,
    members: Vec<Member>,
}

/// What one member's lane reports.
#[derive(Debug)]
struct Member {
    founding: TripleBuffer<{ founding::WORDS }>,
    motion: SeqLock<{ motion::WORDS }>,
    tie: SeqLock<{ tie::WORDS }>,
}

const FIXED: u64 = 1 << 16;
const STARTS_HOLD: u64 = 1 << 17;
const NOBODY: u16 = u16::MAX;

impl WorldPhase {
    fn to_word(self) -> u64 {
        let bit = |set: bool, bit: u64| if set { bit } else { 0 };
        u64::from(self.epoch) << 32
            | bit(self.fixed, FIXED)
            | bit(self.starts_hold, STARTS_HOLD)
            | u64::from(self.member.unwrap_or(NOBODY))
    }

    const fn from_word(word: u64) -> Self {
        let member = word as u16;
        Self {
            epoch: (word >> 32) as u32,
            fixed: word & FIXED != 0,
            starts_hold: word & STARTS_HOLD != 0,
            member: if member == NOBODY { None } else { Some(member) },
        }
    }

    /// A world that waits for its first member.
    pub const fn waiting(epoch: u32) -> Self {
        Self { epoch, fixed: false, starts_hold: true, member: Some(0) }
    }

    /// The epoch that a pose bears: 0 while there is no world.
    pub const fn published_epoch(self) -> u32 {
        if self.fixed { self.epoch } else { 0 }
    }
}

impl WorldFrame {
    /// A world that begins in a phase.
    pub fn new(members: usize, phase: WorldPhase) -> Self {
        let member = |_| Member {
            founding: TripleBuffer::new(&[0; founding::WORDS]),
            motion: SeqLock::new(&[0; motion::WORDS]),
            tie: SeqLock::new(&[0; tie::WORDS]),
        };
        Self { word: AtomicU64::new(phase.to_word()), members: (0..members).map(member).collect() }
    }

    /// A world that waits for its first member to fix it.
    pub fn waiting(members: usize, epoch: u32) -> Self {
        Self::new(members, WorldPhase::waiting(epoch))
    }

    /// Number of members.
    pub const fn member_count(&self) -> usize {
        self.members.len()
    }

    /// How far the world is. Wait-free.
    pub fn phase(&self) -> WorldPhase {
        WorldPhase::from_word(self.word.load(Ordering::Acquire))
    }

    /// Fixes the world, if it is still in the phase in which this member may; gives the new phase.
    pub(super) fn fix(&self, seen: WorldPhase, starts_hold: bool) -> Option<WorldPhase> {
        let fixed = WorldPhase { fixed: true, starts_hold, ..seen };
        self.exchange(seen, fixed).then_some(fixed)
    }

    /// Lets another member fix the world, if it still waits.
    pub(super) fn pass_on(&self, seen: WorldPhase, member: u16) -> bool {
        !seen.fixed && self.exchange(seen, WorldPhase { member: Some(member), ..seen })
    }

    /// Ends the present world: the next one waits for the first member. Nothing if none is fixed.
    pub(super) fn end(&self) -> bool {
        let seen = self.phase();
        seen.fixed && self.exchange(seen, WorldPhase::waiting(seen.epoch.saturating_add(1)))
    }

    fn exchange(&self, seen: WorldPhase, next: WorldPhase) -> bool {
        let (seen, next) = (seen.to_word(), next.to_word());
        self.word.compare_exchange(seen, next, Ordering::AcqRel, Ordering::Relaxed).is_ok()
    }

    /// Reports how a member fixed the world; by the member's lane alone. Wait-free.
    pub(super) fn report_founding(&self, member: usize, founding: &Founding) {
        if let Some(member) = self.members.get(member) {
            member.founding.report(&founding.to_words());
        }
    }

    /// How a member fixed the world, if it fixed that epoch's and has said so.
    pub(super) fn founding(&self, member: usize, epoch: u32) -> Option<Founding> {
        let words = self.members.get(member)?.founding.read();
        Founding::from_words(&words).filter(|founding| founding.epoch == epoch)
    }

    /// Reports where a member is and how it moves; by the member's lane alone. Wait-free.
    pub fn report_motion(&self, member: usize, motion: &Motion) {
        if let Some(member) = self.members.get(member) {
            member.motion.report(&motion.to_words());
        }
    }

    /// Where a member was last and how it moved; `None` before its first pose. Without a lock.
    pub fn motion(&self, member: usize) -> Option<Motion> {
        Motion::from_words(&self.members.get(member)?.motion.read()?)
    }

    /// Reports to whom a member is tied at the instant of a motion, if it is; by the member's lane alone.
    /// Wait-free.
    pub fn report_tie(&self, member: usize, motion: &Motion, tied: Option<&Tied>) {
        let (Some(member), Some(tied)) = (self.members.get(member), tied) else { return };
        let report = TieReport { time_ns: motion.time_ns, epoch: motion.epoch, tied: *tied };
        member.tie.report(&report.to_words());
    }

    /// To whom a member was tied last. Without a lock.
    pub(super) fn tie(&self, member: usize) -> Option<TieReport> {
        TieReport::from_words(&self.members.get(member)?.tie.read()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_survive_the_word() {
        for member in [None, Some(0), Some(7), Some(u16::MAX - 1)] {
            for (fixed, starts_hold) in [(false, true), (true, false), (true, true)] {
                for epoch in [0, 1, u32::MAX] {
                    let phase = WorldPhase { epoch, fixed, starts_hold, member };
                    assert_eq!(WorldPhase::from_word(phase.to_word()), phase);
                }
            }
        }
    }

    #[test]
    fn a_world_is_fixed_once_whoever_tries() {
        // Given two lanes that both saw that the first may fix it, and a keeper that passes it on
        let frame = WorldFrame::waiting(3, 5);
        let seen = frame.phase();
        assert!(frame.pass_on(seen, 2));
        // Then the first is too late, and the other one is not
        assert_eq!(frame.fix(seen, true), None);
        let fixed = frame.fix(frame.phase(), true).unwrap();
        assert_eq!((fixed.published_epoch(), fixed.member), (5, Some(2)));
        assert!(!frame.pass_on(frame.phase(), 0), "a fixed world is nobody's to fix");
        // When it is ended, the next one has the next epoch and waits for the first again
        assert!(frame.end());
        assert!(!frame.end(), "there is no world to end");
        assert_eq!(frame.phase(), WorldPhase::waiting(6));
        assert_eq!(frame.phase().published_epoch(), 0);
    }
}
