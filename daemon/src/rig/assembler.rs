//! Members' steps put side by side, one row for each instant of the common grid.
//!
//! A row leaves when every member that keeps up has given its step, or when others are so far ahead that
//! waiting would cost more than the missing one is worth. A member that was once not waited for is
//! waited for again as soon as it keeps up. Which rows leave, and when, depends on the steps alone.

use lodestone_fusion::rig::MAX_MEMBERS;
use lodestone_fusion::{SensorSpan, SensorTime, Step};

/// One instant of the grid: each member's step, where there is one.
pub type Row = [Option<Step>; MAX_MEMBERS];

/// Rows that are kept while members wait for each other.
const CAPACITY: i64 = 64;

/// Steps that a member may be behind the newest before it is no longer waited for: 20 ms at 400 Hz.
const PATIENCE: i64 = 8;

/// What the assembler counted since it was made. Nothing decreases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AssemblerCounts {
    /// Steps that came after their row had left.
    pub late: u64,
    /// Steps missing from rows that left, of members that gave any.
    pub missing: u64,
}

/// Whether a step found its row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fit {
    /// It did.
    In,
    /// Its row has left.
    Late,
    /// It lies so far ahead that its time stamp may be wrong.
    Far,
    /// So many steps lie far ahead that nobody was there meanwhile.
    AllFar,
}

/// The state of the assembler.
#[derive(Clone, Debug)]
pub struct Assembler {
    step: SensorSpan,
    members: usize,
    rows: Vec<Row>,
    /// Index of the row that leaves next; none before the first step.
    next: Option<i64>,
    /// Index of the newest step of each member.
    newest: [Option<i64>; MAX_MEMBERS],
    /// Steps in a row that were far ahead.
    far: i64,
    counts: AssemblerCounts,
}

impl Assembler {
    /// An assembler for so many members whose grids have a common step.
    pub fn new(members: usize, step: SensorSpan) -> Self {
        Self {
            step,
            members,
            rows: vec![[None; MAX_MEMBERS]; CAPACITY as usize],
            next: None,
            newest: [None; MAX_MEMBERS],
            far: 0,
            counts: AssemblerCounts::default(),
        }
    }

    /// What was counted so far.
    pub const fn counts(&self) -> AssemblerCounts {
        self.counts
    }

    /// Takes a step. Afterwards call [`Assembler::next_row`] until it gives nothing.
    pub fn insert(&mut self, member: usize, step: Step) -> Fit {
        let index = self.index_of(step.time);
        let next = *self.next.get_or_insert(index);
        if index < next {
            // Late, but there: it is waited for from now on, if it is not far behind.
            self.newest[member] = self.newest[member].max(Some(index));
            self.counts.late += 1;
            return Fit::Late;
        }
        if index - next >= CAPACITY {
            self.far += 1;
            return if self.far > PATIENCE { Fit::AllFar } else { Fit::Far };
        }
        self.far = 0;
        self.newest[member] = Some(index);
        self.rows[slot(index)][member] = Some(step);
        Fit::In
    }

    /// The next row that is complete, or no longer waited for.
    pub fn next_row(&mut self) -> Option<Row> {
        let next = self.next?;
        let ahead = self.newest[..self.members].iter().flatten().max()? - next;
        if ahead < 0 {
            return None;
        }
        let waits = self.rows[slot(next)][..self.members]
            .iter()
            .zip(&self.newest)
            .any(|(step, newest)| step.is_none() && newest.is_some_and(|n| next - n <= PATIENCE));
        if waits && ahead < PATIENCE {
            return None;
        }
        Some(self.leave(next))
    }

    /// The next row, complete or not, once no more steps come.
    pub fn flush(&mut self) -> Option<Row> {
        let next = self.next?;
        let newest = *self.newest[..self.members].iter().flatten().max()?;
        (newest >= next).then(|| self.leave(next))
    }

    /// Begins anew at a step far ahead: everything before it is given up.
    pub fn skip_to(&mut self, member: usize, step: Step) {
        self.rows.fill([None; MAX_MEMBERS]);
        self.newest = [None; MAX_MEMBERS];
        self.next = None;
        self.far = 0;
        self.insert(member, step);
    }

    fn leave(&mut self, index: i64) -> Row {
        let row = std::mem::replace(&mut self.rows[slot(index)], [None; MAX_MEMBERS]);
        let given = |k: usize| self.newest[k].is_some();
        let missing = (0..self.members).filter(|&k| row[k].is_none() && given(k)).count();
        self.counts.missing += missing as u64;
        self.next = Some(index + 1);
        row
    }

    const fn index_of(&self, time: SensorTime) -> i64 {
        time.as_nanos().div_euclid(self.step.as_nanos())
    }
}

const fn slot(index: i64) -> usize {
    index.rem_euclid(CAPACITY) as usize
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use lodestone_fusion::Increment;

    use super::*;

    const STEP: SensorSpan = SensorSpan::from_nanos(2_500_000);

    fn step(index: i64) -> Step {
        Step {
            time: SensorTime::from_nanos(index * 2_500_000),
            increment: Increment { span_s: 0.0025, angle: DVec3::ZERO, velocity: DVec3::Z },
            mag: None,
            bridged: false,
            saturated: false,
        }
    }

    /// Instants and members of the rows that leave.
    fn rows(assembler: &mut Assembler) -> Vec<(i64, Vec<usize>)> {
        let row = |row: Row| {
            let members: Vec<usize> = (0..MAX_MEMBERS).filter(|&k| row[k].is_some()).collect();
            let time = row.iter().flatten().next().map_or(0, |step| step.time.as_nanos());
            (time / 2_500_000, members)
        };
        std::iter::from_fn(|| assembler.next_row()).map(row).collect()
    }

    #[test]
    fn a_row_leaves_when_the_last_member_has_given_its_step() {
        let mut assembler = Assembler::new(2, STEP);
        assembler.insert(0, step(1000));
        assert_eq!(rows(&mut assembler), [(1000, vec![0])], "nobody else is known");
        assembler.insert(1, step(1001));
        assembler.insert(0, step(1001));
        assert_eq!(rows(&mut assembler), [(1001, vec![0, 1])]);
        assembler.insert(1, step(1002));
        assert!(rows(&mut assembler).is_empty(), "the other keeps up, and is waited for");
        assembler.insert(0, step(1002));
        assert_eq!(rows(&mut assembler), [(1002, vec![0, 1])]);
    }

    #[test]
    fn members_that_begin_at_the_same_time_are_together_after_the_first_step() {
        let mut assembler = Assembler::new(3, STEP);
        let mut left = Vec::new();
        for k in 0..5 {
            for member in 0..3 {
                assembler.insert(member, step(k));
                left.extend(rows(&mut assembler));
            }
        }
        assert_eq!(left[0], (0, vec![0]), "nobody else was known");
        assert!(left[1..].iter().all(|(_, members)| members.len() == 3), "{left:?}");
    }

    #[test]
    fn a_silent_member_is_waited_for_once_and_again_when_it_keeps_up() {
        let mut assembler = Assembler::new(2, STEP);
        for k in 0..10 {
            assembler.insert(0, step(k));
            assembler.insert(1, step(k));
        }
        assert_eq!(rows(&mut assembler).len(), 10);
        let mut left = Vec::new();
        for k in 10..40 {
            assembler.insert(0, step(k));
            left.extend(rows(&mut assembler));
        }
        assert_eq!(left.last(), Some(&(39, vec![0])), "no delay any more");
        assert_eq!(assembler.insert(1, step(30)), Fit::Late);
        assembler.insert(1, step(40));
        assert!(rows(&mut assembler).is_empty(), "it is waited for");
        assembler.insert(0, step(40));
        assert_eq!(rows(&mut assembler), [(40, vec![0, 1])]);
        assert_eq!(assembler.counts().late, 1);
    }

    #[test]
    fn no_row_is_left_out_or_changes_its_place() {
        // Given two members that deliver in bursts, then every instant leaves once and in order.
        let mut assembler = Assembler::new(2, STEP);
        let (mut left, mut given) = (Vec::new(), [0, 0]);
        for turn in 0..2000_i64 {
            let member = usize::from(turn * turn % 7 > 2);
            for _ in 0..turn % 4 {
                let ahead = given[member] - given[1 - member];
                if ahead < 6 {
                    assembler.insert(member, step(given[member]));
                    given[member] += 1;
                }
                left.extend(rows(&mut assembler).into_iter().map(|(index, _)| index));
            }
        }
        assert!(left.len() > 500 && left.windows(2).all(|w| w[1] == w[0] + 1));
    }

    #[test]
    fn a_step_far_ahead_does_not_fit_in() {
        let mut assembler = Assembler::new(1, STEP);
        assembler.insert(0, step(0));
        rows(&mut assembler);
        assert_eq!(assembler.insert(0, step(100_000)), Fit::Far);
        assert_eq!(assembler.insert(0, step(1)), Fit::In, "one wrong time stamp");
        let fits: Vec<Fit> = (0..9).map(|k| assembler.insert(0, step(100_000 + k))).collect();
        assert_eq!(fits.last(), Some(&Fit::AllFar));
    }
}
