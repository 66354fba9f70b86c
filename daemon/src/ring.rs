//! The bounded ring between driver and loop: when it is full, the oldest reading makes room.
//!
//! One producer, one consumer, no lock. The producer never waits for a slow consumer. The queue is
//! crossbeam's, which lets either side spin while the other is between claiming and filling a
//! slot, a few instructions.
//!
//! A loop on its own thread sleeps in [`Consumer::wait`], on a futex; the producer makes the
//! system call to wake it only while it sleeps. A loop with several rings has one [`Doorbell`] for all
//! of them, and sleeps in [`wait_for_any`].

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, AtomicUsize, Ordering, fence};
use std::time::Duration;

use crossbeam::queue::ArrayQueue;
use rustix::thread::futex;
use rustix::time::Timespec;

use crate::driver::Sink;
use crate::reading::{HostTime, Reading};

/// What the ring counted since it was made. Nothing decreases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RingCounters {
    /// Readings the driver pushed.
    pub pushed: u64,
    /// Readings that made room for newer ones and never reached the loop.
    pub dropped: u64,
    /// Most readings that were waiting at a time.
    pub high_water: usize,
}

/// Reads the ring's counters, from any thread.
#[derive(Clone, Debug)]
pub struct RingMonitor(Arc<Shared>);

impl RingMonitor {
    /// What was counted so far.
    pub fn counters(&self) -> RingCounters {
        RingCounters {
            pushed: self.0.pushed.load(Ordering::Relaxed),
            dropped: self.0.dropped.load(Ordering::Relaxed),
            high_water: self.0.high_water.load(Ordering::Relaxed),
        }
    }

    /// Readings the ring holds before the oldest is dropped.
    pub fn capacity(&self) -> usize {
        self.0.queue.capacity()
    }
}

#[derive(Debug)]
struct Shared {
    queue: ArrayQueue<(Reading, HostTime)>,
    /// Written by the producer alone, as are the two below.
    pushed: AtomicU64,
    dropped: AtomicU64,
    high_water: AtomicUsize,
    closed: AtomicBool,
    bell: Doorbell,
}

const AWAKE: u32 = 0;
const ASLEEP: u32 = 1;

/// What producers wake a consumer by: its word is [`ASLEEP`] while the consumer sleeps or is about to.
#[derive(Clone, Debug, Default)]
pub struct Doorbell(Arc<AtomicU32>);

impl Doorbell {
    /// Wakes the consumer if it sleeps.
    fn ring(&self) {
        // With the fence in `wait`: either this load sees ASLEEP, or the consumer's look into its
        // queues after it stored ASLEEP sees what was pushed before this fence.
        fence(Ordering::SeqCst);
        if self.0.load(Ordering::Relaxed) == ASLEEP {
            self.0.store(AWAKE, Ordering::Relaxed);
            // It fails only on a bad address or flag, which these are not.
            let _ = futex::wake(&self.0, futex::Flags::PRIVATE, 1);
        }
    }

    /// Sleeps until it is rung or `timeout` has passed, unless there is something to do already; may
    /// return early.
    fn wait(&self, timeout: Duration, is_idle: impl FnOnce() -> bool) {
        self.0.store(ASLEEP, Ordering::Relaxed);
        fence(Ordering::SeqCst);
        if is_idle() {
            let timeout = Timespec::try_from(timeout).ok();
            // Timed out, interrupted, woken before it slept: the caller looks again in any case.
            let _ = futex::wait(&self.0, futex::Flags::PRIVATE, ASLEEP, timeout.as_ref());
        }
        self.0.store(AWAKE, Ordering::Relaxed);
    }
}

/// Sleeps until a reading waits in one of the rings, all are closed, or `timeout` has passed; may
/// return early. The rings have this bell.
pub fn wait_for_any(bell: &Doorbell, consumers: &[Consumer], timeout: Duration) {
    bell.wait(timeout, || {
        consumers.iter().all(Consumer::is_empty) && !consumers.iter().all(Consumer::is_closed)
    });
}

/// Makes a ring that holds `capacity` readings, at least one.
pub fn ring(capacity: usize) -> (Producer, Consumer) {
    ring_with(capacity, Doorbell::default())
}

/// Makes a ring whose consumer has other rings with the same bell.
pub fn ring_with(capacity: usize, bell: Doorbell) -> (Producer, Consumer) {
    let shared = Arc::new(Shared {
        queue: ArrayQueue::new(capacity.max(1)),
        pushed: AtomicU64::new(0),
        dropped: AtomicU64::new(0),
        high_water: AtomicUsize::new(0),
        closed: AtomicBool::new(false),
        bell,
    });
    (Producer { shared: Arc::clone(&shared) }, Consumer { shared })
}

/// The driver's end; closes the ring when dropped.
#[derive(Debug)]
pub struct Producer {
    shared: Arc<Shared>,
}

impl Producer {
    /// A view of the counters.
    pub fn monitor(&self) -> RingMonitor {
        RingMonitor(Arc::clone(&self.shared))
    }
}

impl Sink for Producer {
    fn push(&mut self, reading: Reading) {
        let shared = &*self.shared;
        let displaced = shared.queue.force_push((reading, HostTime::now())).is_some();
        // One writer: load and store need not be one step.
        shared.pushed.store(shared.pushed.load(Ordering::Relaxed) + 1, Ordering::Relaxed);
        if displaced {
            shared.dropped.store(shared.dropped.load(Ordering::Relaxed) + 1, Ordering::Relaxed);
        }
        let waiting = shared.queue.len();
        if waiting > shared.high_water.load(Ordering::Relaxed) {
            shared.high_water.store(waiting, Ordering::Relaxed);
        }
        shared.bell.ring();
    }
}

impl Drop for Producer {
    fn drop(&mut self) {
        self.shared.closed.store(true, Ordering::Release);
        self.shared.bell.ring();
    }
}

/// The loop's end.
#[derive(Debug)]
pub struct Consumer {
    shared: Arc<Shared>,
}

impl Consumer {
    /// The oldest reading, if there is one.
    pub fn pop(&mut self) -> Option<Reading> {
        self.pop_stamped().map(|(reading, _)| reading)
    }

    /// The oldest reading, if there is one, and when the driver put it here.
    pub fn pop_stamped(&mut self) -> Option<(Reading, HostTime)> {
        self.shared.queue.pop()
    }

    /// Readings that wait.
    pub fn len(&self) -> usize {
        self.shared.queue.len()
    }

    /// Whether none waits.
    pub fn is_empty(&self) -> bool {
        self.shared.queue.is_empty()
    }

    /// Whether the producer is gone: what waits now is the last.
    pub fn is_closed(&self) -> bool {
        self.shared.closed.load(Ordering::Acquire)
    }

    /// Sleeps until a reading waits, the ring is closed, or `timeout` has passed; may return early.
    pub fn wait(&mut self, timeout: Duration) {
        self.shared.bell.wait(timeout, || self.is_empty() && !self.is_closed());
    }

    /// A view of the counters.
    pub fn monitor(&self) -> RingMonitor {
        RingMonitor(Arc::clone(&self.shared))
    }
}

#[cfg(test)]
mod tests {
    use std::thread;

    use glam::DVec3;
    use lodestone_fusion::{Accel, Gyro, SensorTime};
    use proptest::prelude::*;

    use super::*;
    use crate::reading::RecordedAiding;

    fn reading(sequence: u64) -> Reading {
        Reading {
            sensor_time: SensorTime::from_nanos(sequence.cast_signed()),
            arrival: HostTime::from_nanos(sequence.cast_signed()),
            gyro: Gyro::new(DVec3::splat(sequence as f64)),
            accel: Accel::new(DVec3::ZERO),
            mag: None,
            temperature_c: None,
            saturated: false,
            aiding: RecordedAiding::NONE,
            epoch: 0,
        }
    }

    /// The sequence number, after a look that the reading is of one piece.
    fn sequence(reading: &Reading) -> u64 {
        let sequence = reading.sensor_time.as_nanos().cast_unsigned();
        assert_eq!(*reading, self::reading(sequence), "torn reading");
        sequence
    }

    #[test]
    fn given_a_full_ring_then_the_oldest_is_dropped_and_counted() {
        let (mut producer, mut consumer) = ring(4);
        (0..10).for_each(|n| producer.push(reading(n)));
        let popped: Vec<u64> =
            std::iter::from_fn(|| consumer.pop()).map(|r| sequence(&r)).collect();
        assert_eq!(popped, [6, 7, 8, 9]);
        let expected = RingCounters { pushed: 10, dropped: 6, high_water: 4 };
        assert_eq!(consumer.monitor().counters(), expected);
    }

    #[test]
    fn a_capacity_of_zero_is_one() {
        let (mut producer, mut consumer) = ring(0);
        producer.push(reading(1));
        producer.push(reading(2));
        assert_eq!(producer.monitor().capacity(), 1);
        assert_eq!(consumer.pop().map(|r| sequence(&r)), Some(2));
    }

    #[test]
    fn waiting_ends_by_timeout_by_a_reading_and_by_the_producers_end() {
        let (mut producer, mut consumer) = ring(4);
        consumer.wait(Duration::from_millis(1));
        assert!(consumer.is_empty());
        producer.push(reading(0));
        consumer.wait(Duration::MAX);
        assert_eq!(consumer.len(), 1);
        consumer.pop();
        drop(producer);
        consumer.wait(Duration::MAX);
        assert!(consumer.is_closed());
    }

    #[test]
    fn one_bell_wakes_for_any_of_several_rings() {
        // Given a consumer of three rings that sleeps without a timeout, when any producer pushes, and
        // when all are gone, then it wakes: a lost wake-up hangs the test.
        let bell = Doorbell::default();
        let (producers, mut consumers): (Vec<_>, Vec<_>) =
            (0..3).map(|_| ring_with(64, bell.clone())).unzip();
        let threads: Vec<_> = producers
            .into_iter()
            .map(|mut producer| {
                thread::spawn(move || {
                    for n in 0..2000 {
                        producer.push(reading(n));
                        if n % 50 == 0 {
                            thread::yield_now();
                        }
                    }
                })
            })
            .collect();
        let mut last = [None; 3];
        loop {
            let closed = consumers.iter().all(Consumer::is_closed);
            for (consumer, last) in consumers.iter_mut().zip(&mut last) {
                while let Some(reading) = consumer.pop() {
                    *last = Some(sequence(&reading));
                }
            }
            if closed {
                break;
            }
            wait_for_any(&bell, &consumers, Duration::MAX);
        }
        assert_eq!(last, [Some(1999); 3]);
        for thread in threads {
            thread.join().unwrap();
        }
    }

    /// Everything the consumer gets until the ring is closed and empty.
    fn consume(mut consumer: Consumer, stall_every: u64) -> Vec<u64> {
        let mut popped = Vec::new();
        loop {
            let closed = consumer.is_closed();
            while let Some(reading) = consumer.pop() {
                popped.push(sequence(&reading));
                if (popped.len() as u64).is_multiple_of(stall_every) {
                    thread::yield_now();
                }
            }
            if closed {
                return popped;
            }
            // No timeout: a lost wake-up hangs the test.
            consumer.wait(Duration::MAX);
        }
    }

    fn stress(capacity: usize, count: u64, pause_every: u64) {
        let (mut producer, consumer) = ring(capacity);
        let monitor = producer.monitor();
        let loop_thread = thread::spawn(move || consume(consumer, 64));
        for n in 0..count {
            producer.push(reading(n));
            if n.is_multiple_of(pause_every) {
                thread::yield_now();
            }
        }
        drop(producer);
        let popped = loop_thread.join().unwrap();
        let counters = monitor.counters();
        assert_eq!(counters.pushed, count);
        assert_eq!(popped.len() as u64 + counters.dropped, count, "every reading has one fate");
        assert!(popped.is_sorted_by(|a, b| a < b), "order is kept");
        assert_eq!(popped.last(), Some(&(count - 1)), "the newest is never dropped");
        assert!(counters.high_water <= capacity);
    }

    #[test]
    fn two_threads_lose_nothing_uncounted() {
        stress(256, 200_000, 1_000_000);
        stress(4, 200_000, 50);
        stress(1, 50_000, 3);
        stress(64, 5_000, 1);
    }

    proptest! {
        #[test]
        fn every_reading_is_popped_in_order_or_counted(
            capacity in 1_usize..20,
            pushes in prop::collection::vec(any::<bool>(), 0..200),
        ) {
            let (mut producer, mut consumer) = ring(capacity);
            let (mut next, mut popped) = (0, Vec::new());
            for push in pushes {
                if push {
                    producer.push(reading(next));
                    next += 1;
                } else if let Some(reading) = consumer.pop() {
                    popped.push(sequence(&reading));
                }
            }
            while let Some(reading) = consumer.pop() {
                popped.push(sequence(&reading));
            }
            let counters = producer.monitor().counters();
            prop_assert!(popped.is_sorted_by(|a, b| a < b));
            prop_assert_eq!(counters.pushed, next);
            prop_assert_eq!(popped.len() as u64 + counters.dropped, next);
        }
    }
}
