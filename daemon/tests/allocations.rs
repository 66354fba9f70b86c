//! What the lane's end allocates: exactly iceoryx2's one per message, and nothing of ours.
#![allow(unsafe_code)] // A global allocator is an unsafe trait.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use common::{in_child, own_domain, pose, sample, small};
use lodestone_daemon::publisher::LanePublisher;
use lodestone_daemon::status_board::{LaneBoard, LaneStatus, SensorStatus};
use lodestone_schema::{LaneState, Pose, ServiceKind};

struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
    static RELEASES: Cell<u64> = const { Cell::new(0) };
}

fn count(counter: &'static std::thread::LocalKey<Cell<u64>>) {
    // A thread that is ending has no counters left, and nothing to count.
    let _ = counter.try_with(|n| n.set(n.get() + 1));
}

// SAFETY: every call goes to the system's allocator with the arguments unchanged; counting in a
// constant-initialised thread-local without destructor does not allocate.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(&ALLOCATIONS);
        // SAFETY: the caller's promise, handed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(&RELEASES);
        // SAFETY: the caller's promise, handed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn counted(work: impl FnOnce()) -> (u64, u64) {
    let before = (ALLOCATIONS.get(), RELEASES.get());
    work();
    (ALLOCATIONS.get() - before.0, RELEASES.get() - before.1)
}

#[test]
fn a_message_costs_the_one_allocation_of_iceoryx2_and_reporting_costs_none() {
    in_child("a_message_costs_the_one_allocation_of_iceoryx2_and_reporting_costs_none", || {
        let (domain, _root) = own_domain("alloc");
        let mut publisher = LanePublisher::open(&domain, &small(), "front").unwrap();
        let node = domain.open_node("alloc").unwrap();
        let service = lodestone_schema::transport::open_for_reading::<Pose>(
            &node,
            ServiceKind::Pose,
            "front",
        );
        let _consumer = service.unwrap().subscriber_builder().create().unwrap();
        let board = LaneBoard::new();
        // The consumer joins at the first send.
        publisher.publish_pose(&pose(0)).unwrap();

        let poses = counted(|| {
            assert!((1..=1000).all(|n| publisher.publish_pose(&pose(n)).is_some()));
        });
        let samples = counted(|| (0..1000).for_each(|n| publisher.publish_sample(&sample(n))));
        let reports = counted(|| {
            for n in 0..1000 {
                board.counters.samples.add(1);
                board.latency.record(n);
                board.latest.report(&LaneStatus::of(&pose(n as u64), SensorStatus::default()));
                board.set_state(LaneState::Running);
            }
        });

        assert_eq!(poses, (1000, 1000));
        assert_eq!(samples, (1000, 1000));
        assert_eq!(reports, (0, 0));
        assert!(
            counted(|| drop(std::hint::black_box(Box::new(1)))) == (1, 1),
            "the counter counts"
        );
    });
}
