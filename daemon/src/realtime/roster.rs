//! The threads of a lane, and what each of them did not get.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use lodestone_schema::RealTimeFlags;
use rustix::thread::{CpuSet, Pid, gettid, sched_getaffinity, sched_setaffinity};
use tracing::{info, warn};

use super::{Refusal, ThreadSetup};

/// The threads of one lane while they run. Locked when a thread comes or goes and once a second by
/// housekeeping, never on the way of a sample.
#[derive(Debug, Default)]
pub struct Roster {
    threads: Mutex<Vec<Post>>,
    memory_refused: AtomicBool,
}

#[derive(Debug)]
struct Post {
    thread: Pid,
    cpu: Option<u16>,
    refused: RealTimeFlags,
}

/// A thread on its roster, until it is dropped.
#[derive(Debug)]
pub struct Enrolled {
    roster: Arc<Roster>,
    thread: Pid,
}

/// Sets the calling thread up and puts it on the roster; what is refused is logged.
pub fn enter(setup: &ThreadSetup, roster: &Arc<Roster>) -> Enrolled {
    let thread = gettid();
    let refusals = setup.apply(thread);
    let name = std::thread::current().name().unwrap_or("?").to_owned();
    for refusal in &refusals {
        warn!(thread = name, "{refusal}");
    }
    if refusals.is_empty() && (setup.priority.is_some() || setup.cpu.is_some()) {
        info!(thread = name, priority = setup.priority, cpu = setup.cpu, "real time");
    }
    let refused = refusals.iter().map(Refusal::flag).collect();
    roster.posts().push(Post { thread, cpu: setup.cpu, refused });
    Enrolled { roster: Arc::clone(roster), thread }
}

impl Drop for Enrolled {
    fn drop(&mut self) {
        // The number of a thread that ended may become another's, whom nobody may pin.
        self.roster.posts().retain(|post| post.thread != self.thread);
    }
}

impl Roster {
    /// What the lane's threads, or the process, did not get.
    pub fn refused(&self) -> RealTimeFlags {
        let threads = self.posts().iter().map(|post| post.refused).collect();
        let memory = self.memory_refused.load(Ordering::Relaxed);
        if memory { threads | RealTimeFlags::MEMORY_LOCK } else { threads }
    }

    /// Notes that the process's memory is not locked.
    pub fn note_memory_refused(&self) {
        self.memory_refused.store(true, Ordering::Relaxed);
    }

    /// Puts threads back on their processors: when one goes off-line the kernel lets its threads run
    /// anywhere, and leaves it at that when the processor is back.
    pub fn pin_again(&self) {
        for post in &mut *self.posts() {
            let Some(cpu) = post.cpu.filter(|cpu| !is_pinned(post.thread, *cpu)) else { continue };
            let was_refused = post.refused.contains(RealTimeFlags::AFFINITY);
            let pinned = pin(post.thread, cpu);
            post.refused.set(RealTimeFlags::AFFINITY, pinned.is_err());
            match pinned {
                Ok(()) => info!(thread = post.thread.as_raw_nonzero(), cpu, "pinned again"),
                Err(refusal) if !was_refused => warn!("{refusal}"),
                Err(_) => {}
            }
        }
    }

    fn posts(&self) -> MutexGuard<'_, Vec<Post>> {
        self.threads.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Keeps a thread on one processor.
pub(super) fn pin(thread: Pid, cpu: u16) -> Result<(), Refusal> {
    sched_setaffinity(Some(thread), &only(cpu)).map_err(|errno| Refusal::Affinity { cpu, errno })
}

fn is_pinned(thread: Pid, cpu: u16) -> bool {
    sched_getaffinity(Some(thread)).is_ok_and(|set| set == only(cpu))
}

fn only(cpu: u16) -> CpuSet {
    let mut set = CpuSet::new();
    // The configuration allows no more than a set holds.
    set.set(usize::from(cpu).min(CpuSet::MAX_CPU - 1));
    set
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODEST: ThreadSetup =
        ThreadSetup { priority: None, cpu: None, timer_slack_ns: 1000, prefault_stack_kib: 8 };

    /// Where this thread may run, in the test's own thread so that no other test is pinned.
    fn allowed() -> CpuSet {
        sched_getaffinity(None).unwrap()
    }

    fn first_allowed() -> u16 {
        (0..1024).find(|cpu| allowed().is_set(usize::from(*cpu))).unwrap()
    }

    #[test]
    fn a_pinned_thread_that_was_moved_is_put_back() {
        let (everywhere, cpu) = (allowed(), first_allowed());
        let roster = Arc::new(Roster::default());
        let _here = enter(&ThreadSetup { cpu: Some(cpu), ..MODEST }, &roster);
        assert_eq!(allowed(), only(cpu));
        assert_eq!(roster.refused(), RealTimeFlags::empty());

        // As the kernel does when the processor goes off-line.
        sched_setaffinity(None, &everywhere).unwrap();
        roster.pin_again();

        assert_eq!(allowed(), only(cpu));
    }

    #[test]
    fn a_processor_that_is_not_there_is_refused_and_the_thread_runs_on() {
        let before = allowed();
        let roster = Arc::new(Roster::default());
        let here = enter(&ThreadSetup { cpu: Some(1023), ..MODEST }, &roster);
        roster.pin_again();
        assert_eq!(roster.refused(), RealTimeFlags::AFFINITY);
        assert_eq!(allowed(), before);
        // With the thread its refusal ends.
        drop(here);
        assert_eq!(roster.refused(), RealTimeFlags::empty());
    }

    #[test]
    fn timer_slack_is_set_and_locked_memory_is_a_matter_of_the_process() {
        let roster = Arc::new(Roster::default());
        let _here = enter(&MODEST, &roster);
        assert_eq!(rustix::thread::current_timer_slack().unwrap(), 1000);
        roster.note_memory_refused();
        assert_eq!(roster.refused(), RealTimeFlags::MEMORY_LOCK);
    }
}
