//! A thread that notes when its core was kept from it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use core::time::Duration;

use rustix::thread::{CpuSet, clock_nanosleep_absolute, sched_setaffinity};
use rustix::time::{ClockId, Timespec};

use super::gaps::Gap;
use crate::time::monotonic_now_ns;

/// Between two looks at the clock.
const NAP_NS: i64 = 100_000;

/// Why there is no sentinel.
#[derive(Debug, thiserror::Error)]
pub enum SentinelError {
    /// No thread.
    #[error("cannot start a thread: {0}")]
    Thread(std::io::Error),
    /// The processor is not there, or not for this process.
    #[error("cannot run on processor {cpu}: {why}")]
    Processor {
        /// Which.
        cpu: usize,
        /// What the system says.
        why: std::io::Error,
    },
}

/// Naps for 100 µs at a time on one processor and notes each nap that was longer than it should be by a
/// threshold: the host stood still, or another process had the core.
///
/// It has an ordinary priority: it never keeps a lane with a real-time one from the core, and one
/// step of a lane keeps the core for some microseconds only, far below the threshold.
#[derive(Debug)]
pub struct Sentinel {
    stop: Arc<AtomicBool>,
    gaps: Arc<Mutex<Vec<Gap>>>,
    thread: Option<JoinHandle<()>>,
}

impl Sentinel {
    /// Starts on a processor.
    ///
    /// # Errors
    /// [`SentinelError`].
    pub fn start(cpu: usize, threshold: Duration) -> Result<Self, SentinelError> {
        let (stop, gaps) = (Arc::new(AtomicBool::new(false)), Arc::new(Mutex::new(Vec::new())));
        let (stopped, noted) = (Arc::clone(&stop), Arc::clone(&gaps));
        let threshold_ns = i64::try_from(threshold.as_nanos()).unwrap_or(i64::MAX);
        let (ready, pinned) = std::sync::mpsc::sync_channel(1);
        let body = move || {
            let result = pin_to(cpu);
            let good = result.is_ok();
            // Whoever started it waits for this.
            let _ = ready.send(result);
            if good {
                watch(threshold_ns, &stopped, &noted);
            }
        };
        let thread = thread::Builder::new().name("sentinel".into()).spawn(body);
        let thread = thread.map_err(SentinelError::Thread)?;
        let pinned = pinned.recv().unwrap_or_else(|_| Err(std::io::Error::other("it ended")));
        pinned.map_err(|why| SentinelError::Processor { cpu, why })?;
        Ok(Self { stop, gaps, thread: Some(thread) })
    }

    /// The gaps noted since the last call.
    pub fn take(&self) -> Vec<Gap> {
        std::mem::take(&mut *self.gaps.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Drop for Sentinel {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // It has nothing to say that is not in the list.
            let _ = thread.join();
        }
    }
}

fn pin_to(cpu: usize) -> std::io::Result<()> {
    let mut set = CpuSet::new();
    if cpu >= CpuSet::MAX_CPU {
        return Err(std::io::Error::other("no such processor"));
    }
    set.set(cpu);
    Ok(sched_setaffinity(None, &set)?)
}

fn watch(threshold_ns: i64, stop: &AtomicBool, gaps: &Mutex<Vec<Gap>>) {
    let mut last_ns = monotonic_now_ns();
    while !stop.load(Ordering::Relaxed) {
        nap_until(last_ns + NAP_NS);
        let now_ns = monotonic_now_ns();
        if let Some(gap) = late(last_ns, now_ns, threshold_ns) {
            gaps.lock().unwrap_or_else(PoisonError::into_inner).push(gap);
        }
        last_ns = now_ns;
    }
}

/// The gap in a nap, if it was longer than it should be by the threshold. When in it the core was
/// missing cannot be told, so the gap is the whole nap.
fn late(last_ns: i64, now_ns: i64, threshold_ns: i64) -> Option<Gap> {
    let gap = Gap { begin_ns: last_ns, end_ns: now_ns };
    (gap.span_ns() - NAP_NS > threshold_ns).then_some(gap)
}

fn nap_until(time_ns: i64) {
    const SECOND_NS: i64 = 1_000_000_000;
    let time = Timespec { tv_sec: time_ns / SECOND_NS, tv_nsec: time_ns % SECOND_NS };
    // Cut short by a signal is as good.
    let _ = clock_nanosleep_absolute(ClockId::Monotonic, &time);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_nap_that_lasts_too_long_is_a_gap_and_any_other_is_not() {
        assert_eq!(late(0, NAP_NS + 50_000, 50_000), None);
        let expected = Gap { begin_ns: 7, end_ns: 7 + NAP_NS + 50_001 };
        assert_eq!(late(7, 7 + NAP_NS + 50_001, 50_000), Some(expected));
    }

    #[test]
    fn a_sentinel_notes_gaps_in_order_until_it_is_stopped() {
        // Given a threshold that every nap exceeds
        let allowed = rustix::thread::sched_getaffinity(None).expect("own processors");
        let cpu = (0..CpuSet::MAX_CPU).find(|cpu| allowed.is_set(*cpu)).expect("one");
        let sentinel = Sentinel::start(cpu, Duration::ZERO).expect("starts");
        let mut gaps = Vec::new();
        while gaps.len() < 3 {
            thread::sleep(Duration::from_millis(1));
            gaps.extend(sentinel.take());
        }
        assert!(gaps.windows(2).all(|w| w[0].end_ns <= w[1].begin_ns));
        drop(sentinel);
    }

    #[test]
    fn a_processor_that_is_not_there_is_an_error() {
        for cpu in [CpuSet::MAX_CPU - 1, CpuSet::MAX_CPU] {
            let error = Sentinel::start(cpu, Duration::ZERO).expect_err("not there");
            assert!(error.to_string().contains(&cpu.to_string()), "{error}");
        }
    }
}
