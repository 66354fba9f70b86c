//! A thread that notes when its core was kept from it.

use std::fs::File;
use std::os::unix::fs::FileExt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use core::time::Duration;

use rustix::process::setpriority_process;

use super::gaps::Gap;
use super::processors::pin_to;
use crate::time::monotonic_now_ns;

/// No other thread comes and goes faster: below this nothing has happened between two looks.
const SWITCH_NS: i64 = 2_000;
/// As `nice` counts.
const LOWEST_PRIORITY: i32 = 19;

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

/// Looks at the clock over and over on one processor and notes when it was kept from it for longer than
/// a threshold by something that is no thread: the host that stood still, or an interrupt.
///
/// While another thread has the processor, a lane's say, the sentinel waits for its turn; the kernel
/// accounts for that time, and it is taken off. What a lane costs itself is therefore no gap. It yields
/// after each look and has the lowest priority, so nobody waits for it. It keeps the processor from
/// sleeping, though: whoever wakes up beside it does so as with the kernel's `idle=poll`.
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

fn watch(threshold_ns: i64, stop: &AtomicBool, gaps: &Mutex<Vec<Gap>>) {
    // Refused, it yields nevertheless.
    let _ = setpriority_process(None, LOWEST_PRIORITY);
    let turns = Turns::open();
    let (mut last_ns, mut waited_ns) = (monotonic_now_ns(), turns.waited_ns());
    while !stop.load(Ordering::Relaxed) {
        thread::yield_now();
        let now_ns = monotonic_now_ns();
        if now_ns - last_ns > SWITCH_NS {
            let waited_before_ns = std::mem::replace(&mut waited_ns, turns.waited_ns());
            let for_others_ns = waited_ns - waited_before_ns;
            if let Some(gap) = missing(last_ns, now_ns, for_others_ns, threshold_ns) {
                gaps.lock().unwrap_or_else(PoisonError::into_inner).push(gap);
            }
            // The reading itself took a while.
            last_ns = monotonic_now_ns();
        } else {
            last_ns = now_ns;
        }
    }
}

/// The gap between two looks, if more than the threshold is left of it without the time that other
/// threads had. Where in it the processor was missing cannot be told, so the gap is all of it.
fn missing(last_ns: i64, now_ns: i64, for_others_ns: i64, threshold_ns: i64) -> Option<Gap> {
    let gap = Gap { begin_ns: last_ns, end_ns: now_ns };
    (gap.span_ns() - for_others_ns > threshold_ns).then_some(gap)
}

/// What the kernel says of the calling thread's turns.
struct Turns(Option<File>);

impl Turns {
    /// Without the file (a kernel without `CONFIG_SCHED_INFO`) all time that is missing is a gap.
    fn open() -> Self {
        Self(File::open("/proc/thread-self/schedstat").ok())
    }

    /// How long this thread has waited for its turn so far, ns.
    fn waited_ns(&self) -> i64 {
        let mut text = [0; 96];
        let read = self.0.as_ref().and_then(|file| file.read_at(&mut text, 0).ok());
        read.and_then(|len| waited_ns(str::from_utf8(text.get(..len)?).ok()?)).unwrap_or(0)
    }
}

/// Of `run waited turns`.
fn waited_ns(schedstat: &str) -> Option<i64> {
    schedstat.split_ascii_whitespace().nth(1)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use rustix::thread::CpuSet;

    use super::super::processors::allowed_processors;
    use super::*;

    #[test]
    fn time_that_no_thread_had_is_a_gap_and_time_that_others_had_is_not() {
        assert_eq!(missing(0, 50_000, 0, 50_000), None);
        assert_eq!(missing(7, 50_008, 0, 50_000), Some(Gap { begin_ns: 7, end_ns: 50_008 }));
        assert_eq!(missing(0, 300_000, 260_000, 50_000), None, "a lane ran");
        assert!(missing(0, 900_000, 260_000, 50_000).is_some(), "and the host stood still");
    }

    #[test]
    fn a_turn_of_another_thread_on_the_same_processor_is_no_gap() {
        // Given another thread on the sentinel's processor that has it for a millisecond at a time
        let cpu = first_processor();
        let sentinel = Sentinel::start(cpu, Duration::from_micros(300)).expect("starts");
        pin_to(cpu).expect("own processor");
        let turns: Vec<(i64, i64)> =
            (0..50).map(|_| (monotonic_now_ns(), busy_for_1_ms())).collect();
        let gaps = sentinel.take();
        let explained = turns.iter().filter(|(begin_ns, end_ns)| {
            gaps.iter().any(|gap| gap.begin_ns < *end_ns && *begin_ns < gap.end_ns)
        });
        // The host may have stood still in some of them.
        assert!(explained.count() < 25, "{gaps:?}");
    }

    fn busy_for_1_ms() -> i64 {
        let begin_ns = monotonic_now_ns();
        while monotonic_now_ns() - begin_ns < 1_000_000 {
            std::hint::spin_loop();
        }
        let end_ns = monotonic_now_ns();
        thread::sleep(Duration::from_millis(1));
        end_ns
    }

    #[test]
    fn a_sentinel_notes_gaps_in_order_until_it_is_stopped() {
        // Given a threshold that every interrupt exceeds
        let sentinel = Sentinel::start(first_processor(), Duration::ZERO).expect("starts");
        let mut gaps = Vec::new();
        while gaps.len() < 3 {
            thread::sleep(Duration::from_millis(1));
            gaps.extend(sentinel.take());
        }
        assert!(gaps.windows(2).all(|w| w[0].end_ns <= w[1].begin_ns));
        drop(sentinel);
    }

    fn first_processor() -> usize {
        allowed_processors().expect("own processors")[0]
    }

    #[test]
    fn a_processor_that_is_not_there_is_an_error() {
        for cpu in [CpuSet::MAX_CPU - 1, CpuSet::MAX_CPU] {
            let error = Sentinel::start(cpu, Duration::ZERO).expect_err("not there");
            assert!(error.to_string().contains(&cpu.to_string()), "{error}");
        }
    }
}
