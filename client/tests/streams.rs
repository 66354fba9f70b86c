//! Streams against a publisher in another process, through real shared memory.

mod support;

use std::path::Path;
use std::time::Duration;

use lodestone_client::{
    CameraPose, ConnectError, LaneState, LookupError, LookupLimits, OpenError, StreamError, Time,
    Validity, monotonic_now_ns,
};
use lodestone_schema::SCHEMA_VERSION;
use support::publisher::{Publisher, UNIX_OFFSET_NS, publish_as_ordered};
use support::{TestDomain, eventually};

const PATIENCE: Duration = Duration::from_secs(20);

#[test]
#[ignore = "the publisher's side of the other tests, which start it themselves"]
fn publisher_process() {
    publish_as_ordered();
}

#[test]
fn poses_come_in_order_and_none_is_lost() {
    // Given a consumer that listens before the first pose
    let domain = TestDomain::shared();
    let mut publisher = Publisher::start(&domain, "ordered", 64);
    let mut poses = domain.client().poses("ordered").unwrap();
    assert!(matches!(poses.latest(), Err(StreamError::NothingYet { .. })));
    // When poses come in bursts that fit the buffer
    let mut sequences = Vec::new();
    for _ in 0..10 {
        publisher.burst(50);
        let batch = poses.all();
        assert_eq!((batch.lost, batch.restarts, batch.invalid), (0, 0, 0));
        sequences.extend(batch.into_iter().map(CameraPose::sequence));
    }
    // Then each is there once
    assert_eq!(sequences, (0..500).collect::<Vec<_>>());
    assert_eq!(poses.all().into_iter().len(), 0);
}

#[test]
fn who_joins_late_still_gets_the_history() {
    let domain = TestDomain::shared();
    let mut publisher = Publisher::start(&domain, "late", 16);
    publisher.burst(40);
    let mut poses = domain.client().poses("late").unwrap();
    assert!(poses.latest().is_err());
    publisher.burst(1);
    let sequences: Vec<u64> = poses.all().into_iter().map(CameraPose::sequence).collect();
    assert_eq!(sequences, (25..=40).collect::<Vec<_>>());
    assert_eq!(poses.counts().lost, 0, "what was before joining is not lost");
    // And the past can be looked up, in both clocks.
    let asked_ns = poses.history().oldest().unwrap().time_ns() + 20_000_001;
    let found = poses.lookup(Time::Unix(asked_ns + UNIX_OFFSET_NS)).unwrap();
    assert_eq!(found.time_ns(), asked_ns);
    assert!((found.position_m().unwrap().x - asked_ns as f64 * 1e-9).abs() < 1e-6);
}

#[test]
fn a_slow_consumer_loses_the_oldest_and_knows_how_many() {
    let domain = TestDomain::shared();
    let mut publisher = Publisher::start(&domain, "slow", 8);
    let mut poses = domain.client().poses("slow").unwrap();
    assert!(poses.latest().is_err());
    publisher.burst(4);
    assert_eq!(poses.all().lost, 0);
    // When 100 poses come while the consumer does something else
    publisher.burst(100);
    // Then it has the newest 8, and knows of the 92 others
    let batch = poses.all();
    assert_eq!(batch.lost, 92);
    let sequences: Vec<u64> = batch.into_iter().map(CameraPose::sequence).collect();
    assert_eq!(sequences, (96..104).collect::<Vec<_>>());
    assert_eq!(poses.counts().lost, 92);
    assert_eq!(poses.all().lost, 0, "told once");
}

#[test]
fn what_the_own_history_pushes_out_unread_is_counted_too() {
    let domain = TestDomain::shared();
    let mut publisher = Publisher::start(&domain, "narrow", 64);
    let client = domain.client();
    let mut poses = client.pose_stream("narrow").unwrap().capacity(10).open();
    assert!(poses.latest().is_err());
    publisher.burst(30);
    let batch = poses.all();
    assert_eq!(batch.lost, 20);
    assert_eq!(batch.into_iter().len(), 10);
}

#[test]
fn a_stream_made_before_the_daemon_connects_by_itself() {
    let domain = TestDomain::shared();
    let mut poses = domain.client().poses("early").unwrap();
    let error = poses.latest().unwrap_err();
    assert!(matches!(error, StreamError::NotConnected(_)), "{error}");
    assert!(matches!(poses.lookup(Time::Monotonic(1)), Err(LookupError::NotConnected(_))));
    assert!(poses.is_stale());
    let mut publisher = Publisher::start(&domain, "early", 8);
    publisher.run();
    let pose = poses.wait(PATIENCE).unwrap();
    assert!(pose.position_m().is_some());
    assert_eq!(poses.counts().connections, 1);
}

#[test]
fn the_stream_goes_on_after_the_publisher_was_killed_and_restarted() {
    // Given a consumer that follows a running publisher
    let domain = TestDomain::shared();
    let mut first = Publisher::start(&domain, "killed", 64);
    first.run();
    let mut poses = domain.client().poses("killed").unwrap();
    let before = poses.wait(PATIENCE).unwrap();
    // When the publisher is killed
    first.kill();
    eventually("the stream turns stale", || {
        let _ = poses.latest();
        poses.is_stale().then_some(())
    });
    assert!(poses.latest().unwrap().time_ns() >= before.time_ns(), "the last pose stays");
    let last_ns = poses.latest().unwrap().time_ns();
    // And another one starts
    let mut second = Publisher::start(&domain, "killed", 64);
    second.run();
    // Then poses come again, as a new history
    let after = poses.wait(PATIENCE).unwrap();
    assert!(after.time_ns() > last_ns);
    assert_eq!(poses.counts().restarts, 1);
    assert_eq!(poses.all().restarts, 1);
    let across = poses.lookup(Time::Monotonic(last_ns));
    assert!(matches!(across, Err(LookupError::TooOld { .. })), "{across:?}");
    assert!(!poses.is_stale());
}

#[test]
fn a_daemon_may_come_back_with_other_settings() {
    // Given a consumer that keeps the service of a killed daemon in existence
    let domain = TestDomain::shared();
    let mut first = Publisher::start(&domain, "resized", 8);
    first.run();
    let mut poses = domain.client().poses("resized").unwrap();
    poses.wait(PATIENCE).unwrap();
    first.kill();
    // When a daemon wants a longer history, and is started again until it gets it
    let mut second = eventually("it starts", || {
        let _ = poses.latest();
        Publisher::try_start(&domain, "resized", 200)
    });
    // Then the consumer finds the new service
    second.run();
    poses.wait(PATIENCE).unwrap();
    assert!(poses.counts().connections > 1);
    assert_eq!(poses.counts().restarts, 1);
}

#[test]
fn a_long_pause_of_the_publisher_is_neither_restart_nor_loss() {
    // Given a camera that is lost for longer than a stream waits before it opens its service anew
    let domain = TestDomain::shared();
    let mut publisher = Publisher::start(&domain, "paused", 32);
    let mut poses = domain.client().poses("paused").unwrap();
    assert!(poses.latest().is_err());
    publisher.burst(20);
    assert_eq!(poses.all().into_iter().len(), 20);
    eventually("the service is opened anew", || {
        let _ = poses.latest();
        (poses.counts().connections > 1).then_some(())
    });
    // When it comes back, and history is delivered again
    publisher.burst(5);
    // Then only the new poses count
    let batch = poses.all();
    assert_eq!((batch.lost, batch.restarts), (0, 0));
    let sequences: Vec<u64> = batch.into_iter().map(CameraPose::sequence).collect();
    assert_eq!(sequences, (20..25).collect::<Vec<_>>());
}

#[test]
fn lookups_near_now_are_predicted_up_to_the_cap() {
    let domain = TestDomain::shared();
    let mut publisher = Publisher::start(&domain, "ahead", 8);
    let limits = LookupLimits { prediction: Duration::from_mins(10), ..LookupLimits::default() };
    let client = domain.client();
    let mut patient = client.pose_stream("ahead").unwrap().limits(limits).open();
    let mut usual = client.poses("ahead").unwrap();
    let _ = (patient.latest(), usual.latest());
    publisher.burst(8);
    let newest_ns = usual.latest().unwrap().time_ns();
    let soon = usual.lookup_with(Time::Monotonic(newest_ns + 40_000_000), Validity::POSITION);
    let expected = (newest_ns + 40_000_000) as f64 * 1e-9;
    assert!((soon.unwrap().position_m().unwrap().x - expected).abs() < 1e-6);
    let far = usual.lookup(Time::Monotonic(newest_ns + 60_000_000));
    assert!(matches!(far, Err(LookupError::TooNew { .. })), "{far:?}");
    assert!(patient.lookup(Time::Monotonic(monotonic_now_ns())).is_ok());
}

#[test]
fn wait_gives_each_time_a_newer_pose_and_ends_in_time_without_one() {
    let domain = TestDomain::shared();
    let mut publisher = Publisher::start(&domain, "waited", 64);
    let mut poses = domain.client().poses("waited").unwrap();
    publisher.run();
    let mut last = None;
    for _ in 0..50 {
        let pose = poses.wait(PATIENCE).unwrap();
        assert!(last.is_none_or(|last| pose.sequence() > last));
        last = Some(pose.sequence());
    }
    publisher.kill();
    eventually("the wait ends empty", || {
        let ended = poses.wait(Duration::from_millis(30)).err()?;
        matches!(ended, StreamError::TimedOut { waited_ms: 30, .. }).then_some(())
    });
}

#[test]
fn health_is_followed_too() {
    let domain = TestDomain::shared();
    let mut publisher = Publisher::start(&domain, "healthy", 8);
    publisher.run();
    let mut stream = domain.client().health("healthy").unwrap();
    let health = eventually("health comes", || stream.latest().ok());
    assert_eq!(health.state(), LaneState::Running);
    assert_eq!(health.temperature_c(), None);
    assert_eq!(health.message().serial, 4711);
}

#[test]
fn another_schema_version_is_named() {
    let domain = TestDomain::shared();
    let other = SCHEMA_VERSION + 1;
    let _publisher = Publisher::start_version(&domain, "foreign", other);
    let mut poses = domain.client().poses("foreign").unwrap();
    let Err(StreamError::NotConnected(error)) = poses.latest() else { panic!("connected") };
    assert!(
        matches!(&*error, ConnectError::Open(OpenError::OtherVersion { found, .. }) if *found == other),
        "{error}"
    );
    assert!(error.to_string().contains(&format!("schema version {other}")), "{error}");
}

#[test]
fn one_consumer_too_many_is_told_so() {
    let domain = TestDomain::shared();
    let _publisher = Publisher::start(&domain, "crowded", 8);
    let client = domain.client();
    let mut streams: Vec<_> = (0..9).map(|_| client.poses("crowded").unwrap()).collect();
    let errors: Vec<_> = streams.iter_mut().map(|s| s.latest().unwrap_err()).collect();
    assert!(errors[..8].iter().all(|e| matches!(e, StreamError::NothingYet { .. })), "{errors:?}");
    let StreamError::NotConnected(error) = &errors[8] else { panic!("{:?}", errors[8]) };
    assert!(matches!(&**error, ConnectError::TooManyConsumers { .. }), "{error}");
}

#[test]
fn clients_of_several_threads_each_get_everything() {
    let domain = TestDomain::shared();
    let mut publisher = Publisher::start(&domain, "threads", 64);
    publisher.run();
    let client = domain.client();
    let threads: Vec<_> = (0..3)
        .map(|_| {
            let client = client.clone();
            std::thread::spawn(move || client.poses("threads").unwrap().wait(PATIENCE).is_ok())
        })
        .collect();
    assert!(threads.into_iter().all(|thread| thread.join().unwrap()));
}

#[test]
fn the_cameras_can_be_listed() {
    let domain = TestDomain::shared();
    let _publisher = Publisher::start(&domain, "listed", 8);
    let found = domain.client().cameras().unwrap();
    assert!(found.iter().any(|f| f.camera == "listed" && f.version == SCHEMA_VERSION), "{found:?}");
    assert!(Path::new(&domain.root).is_dir());
}
