//! Publishers and consumers in real shared memory, each test in a process and domain of its own.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod common;

use std::io::Write;
use std::os::unix::process::ExitStatusExt;
use std::time::Duration;

use common::{
    child_on_small_shm, in_child, is_child, own_domain, pose, said, sample, shared_memory_taken,
    small,
};
use iceoryx2::node::Node;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::ipc;
use lodestone_config::model::{Camera, Config, DriverKind, SharedMemory};
use lodestone_daemon::publisher::{
    HealthPublisher, LanePublisher, PublisherError, Requests, TruthPublisher, WorldPublisher,
    qos_of,
};
use lodestone_daemon::reading::HostTime;
use lodestone_daemon::service::prefault::PrefaultError;
use lodestone_daemon::service::space::needed_bytes;
use lodestone_schema::transport::{
    Domain, open_event_for_reading, open_for_reading, open_for_writing,
};
use lodestone_schema::{CalibratedSample, Pose, ServiceKind};

type Poses = Subscriber<ipc::Service, Pose, ()>;

fn subscribe(node: &Node<ipc::Service>) -> Poses {
    let service = open_for_reading::<Pose>(node, ServiceKind::Pose, "front").unwrap();
    service.subscriber_builder().create().unwrap()
}

fn sequences(subscriber: &Poses) -> Vec<u64> {
    std::iter::from_fn(|| subscriber.receive().unwrap()).map(|pose| pose.sequence).collect()
}

#[test]
fn a_late_subscriber_still_gets_the_history() {
    in_child("a_late_subscriber_still_gets_the_history", || {
        let (domain, _root) = own_domain("late");
        let mut publisher = LanePublisher::open(&domain, &small(), "front").unwrap();
        for n in 0..20 {
            publisher.publish_pose(&pose(n)).unwrap();
        }

        let subscriber = subscribe(&domain.open_node("late").unwrap());
        publisher.publish_pose(&pose(20)).unwrap();

        assert_eq!(sequences(&subscriber), (5..=20).collect::<Vec<_>>());
        assert_eq!(publisher.errors(), 0);
    });
}

#[test]
fn a_consumer_that_does_not_read_loses_the_oldest_and_stops_nobody() {
    in_child("a_consumer_that_does_not_read_loses_the_oldest_and_stops_nobody", || {
        let (domain, _root) = own_domain("slow");
        let mut publisher = LanePublisher::open(&domain, &small(), "front").unwrap();
        let node = domain.open_node("consumers").unwrap();
        let (slow, quick) = (subscribe(&node), subscribe(&node));
        for n in 0..1000 {
            publisher.publish_pose(&pose(n)).unwrap();
            assert_eq!(sequences(&quick), [n]);
        }
        assert_eq!(sequences(&slow), (984..1000).collect::<Vec<_>>());
        assert_eq!(publisher.errors(), 0);
    });
}

#[test]
fn a_consumer_that_holds_all_it_may_costs_no_loan() {
    in_child("a_consumer_that_holds_all_it_may_costs_no_loan", || {
        let (domain, _root) = own_domain("hold");
        let mut publisher = LanePublisher::open(&domain, &small(), "front").unwrap();
        let node = domain.open_node("holders").unwrap();
        let holders: Vec<_> = (0..3).map(|_| subscribe(&node)).collect();
        for n in 0..4 {
            publisher.publish_pose(&pose(n)).unwrap();
        }
        let held: Vec<_> = holders
            .iter()
            .flat_map(|holder| std::iter::from_fn(|| holder.receive().ok().flatten()))
            .collect();
        assert_eq!(held.len(), 12);
        for n in 4..500 {
            assert!(publisher.publish_pose(&pose(n)).is_some(), "pose {n}");
        }
        assert_eq!(publisher.errors(), 0);
    });
}

#[test]
fn the_time_of_publication_is_taken_just_before_the_send() {
    in_child("the_time_of_publication_is_taken_just_before_the_send", || {
        let (domain, _root) = own_domain("stamp");
        let mut publisher = LanePublisher::open(&domain, &small(), "front").unwrap();
        let subscriber = subscribe(&domain.open_node("stamp").unwrap());
        let before = HostTime::now();
        let published = publisher.publish_pose(&pose(7)).unwrap();
        let after = HostTime::now();
        let received = *subscriber.receive().unwrap().unwrap();
        assert!(before <= published && published <= after);
        let expected = Pose { published_time_ns: published.as_nanos(), ..pose(7) };
        assert_eq!(received, expected);
    });
}

#[test]
fn samples_are_published_where_they_are_asked_for() {
    in_child("samples_are_published_where_they_are_asked_for", || {
        let (domain, _root) = own_domain("samples");
        let mut with = LanePublisher::open(&domain, &small(), "front").unwrap();
        let without = SharedMemory { publish_samples: false, ..small() };
        let mut without = LanePublisher::open(&domain, &without, "rear").unwrap();
        without.publish_sample(&sample(1));

        let node = domain.open_node("samples").unwrap();
        let open =
            |camera| open_for_reading::<CalibratedSample>(&node, ServiceKind::Sample, camera);
        let subscriber = open("front").unwrap().subscriber_builder().create().unwrap();
        with.publish_sample(&sample(1));
        assert_eq!(subscriber.receive().unwrap().unwrap().sequence, 1);
        assert!(open("rear").is_err());
    });
}

#[test]
fn a_listener_is_woken_by_a_pose_if_wake_ups_are_configured() {
    in_child("a_listener_is_woken_by_a_pose_if_wake_ups_are_configured", || {
        let (domain, _root) = own_domain("wake");
        let settings = SharedMemory { wake_events: true, ..small() };
        let mut publisher = LanePublisher::open(&domain, &settings, "front").unwrap();
        let node = domain.open_node("wake").unwrap();
        let events = open_event_for_reading(&node, ServiceKind::Wake, "front").unwrap();
        let listener = events.listener_builder().create().unwrap();
        publisher.publish_pose(&pose(0)).unwrap();
        let mut woken = 0;
        listener.timed_wait(|_| woken += 1, Duration::from_secs(20)).unwrap();
        assert!(woken > 0);
        assert_eq!(publisher.errors(), 0);
    });
}

fn one_synthetic_camera(shared_memory: SharedMemory) -> Config {
    let camera =
        Camera { name: "front".into(), driver: DriverKind::Synthetic, ..Camera::default() };
    Config { camera: vec![camera], shared_memory, ..Config::default() }
}

/// History, consumers: small, the default, and a long history.
fn covers(test: &str, history: usize, consumers: usize) {
    in_child(test, || {
        let settings = SharedMemory {
            pose_history: history,
            max_subscribers: consumers,
            ..SharedMemory::default()
        };
        let needed = needed_bytes(&one_synthetic_camera(settings.clone()));
        let (domain, _root) = own_domain("need");
        let taken = take_everything(&domain, &settings);
        assert!(taken <= needed, "takes {taken}, checked for {needed}");
        assert!(2 * taken > needed, "takes only {taken}, checked for {needed}");
    });
}

#[test]
fn the_need_that_is_checked_covers_a_small_lane() {
    covers("the_need_that_is_checked_covers_a_small_lane", 16, 3);
}

#[test]
fn the_need_that_is_checked_covers_the_default_lane() {
    covers("the_need_that_is_checked_covers_the_default_lane", 512, 16);
}

#[test]
fn the_need_that_is_checked_covers_a_long_history() {
    covers("the_need_that_is_checked_covers_a_long_history", 4096, 2);
}

/// All publishers of one lane, as many consumers as may be; returns the bytes taken.
fn take_everything(domain: &Domain, settings: &SharedMemory) -> u64 {
    let mut lane = LanePublisher::open(domain, settings, "front").unwrap();
    let node = domain.open_node("all").unwrap();
    let mut health = HealthPublisher::open(&node, settings, "front").unwrap();
    let mut truth = TruthPublisher::open(&node, settings, "front").unwrap();
    let _world = WorldPublisher::open(&node, settings).unwrap();
    let _requests = Requests::open(&node, settings).unwrap();
    let _consumers: Vec<_> = (0..settings.max_subscribers).map(|_| subscribe(&node)).collect();
    lane.publish_pose(&pose(0)).unwrap();
    lane.publish_sample(&sample(0));
    truth.publish(&pose(0));
    let _ = &mut health;
    lodestone_daemon::service::prefault::prefault(&domain.prefix).unwrap();
    shared_memory_taken(&domain.prefix)
}

/// Takes every page that is left.
fn fill_shared_memory() {
    let mut filler = std::fs::File::create("/dev/shm/filler").unwrap();
    let error = std::iter::repeat_with(|| filler.write_all(&[1; 4096])).find_map(Result::err);
    assert_eq!(error.unwrap().kind(), std::io::ErrorKind::StorageFull);
}

/// A history long enough that publishing reaches pages that nothing has touched before.
fn long() -> SharedMemory {
    SharedMemory { pose_history: 512, max_subscribers: 3, ..SharedMemory::default() }
}

const ROOM: u64 = 8 << 20;

#[test]
fn poses_go_on_when_shared_memory_fills_up_later() {
    const NAME: &str = "poses_go_on_when_shared_memory_fills_up_later";
    if is_child(NAME) {
        let (domain, _root) = own_domain("full");
        let mut publisher = LanePublisher::open(&domain, &long(), "front").unwrap();
        fill_shared_memory();
        for n in 0..5000 {
            publisher.publish_pose(&pose(n)).unwrap();
            publisher.publish_sample(&sample(n));
        }
        return;
    }
    let Some(mut child) = child_on_small_shm(NAME, ROOM) else { return };
    let output = child.output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
}

/// Shows that the test above can fail: iceoryx2 alone reserves nothing.
#[test]
fn without_reserving_the_same_ends_in_sigbus() {
    const NAME: &str = "without_reserving_the_same_ends_in_sigbus";
    if is_child(NAME) {
        let (domain, _root) = own_domain("bus");
        let node = domain.open_node("bus").unwrap();
        let qos = qos_of(ServiceKind::Pose, &long());
        let service = open_for_writing::<Pose>(&node, ServiceKind::Pose, "front", qos).unwrap();
        let publisher = service.publisher_builder().create().unwrap();
        fill_shared_memory();
        for n in 0..5000 {
            publisher.send_copy(pose(n)).unwrap();
        }
        return;
    }
    let Some(mut child) = child_on_small_shm(NAME, ROOM) else { return };
    let output = child.output().unwrap();
    assert_eq!(output.status.signal(), Some(7), "{}", said(&output));
}

#[test]
fn a_publisher_that_finds_too_little_memory_is_an_error_and_no_signal() {
    const NAME: &str = "a_publisher_that_finds_too_little_memory_is_an_error_and_no_signal";
    if is_child(NAME) {
        let (domain, _root) = own_domain("little");
        let refused = LanePublisher::open(&domain, &long(), "front").err().unwrap();
        assert!(
            matches!(refused, PublisherError::Prefault(PrefaultError::Full { .. })),
            "{refused}"
        );
        return;
    }
    // Room for what iceoryx2 itself writes at once, not for the poses.
    let Some(mut child) = child_on_small_shm(NAME, 256 << 10) else { return };
    let output = child.output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
}
