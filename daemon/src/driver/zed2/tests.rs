//! What the driver makes of reports. A datagram socket stands in for the hidraw descriptor: it,
//! too, gives one report a read. The real kernel interface is tested in `tests/`.

use std::ffi::CString;
use std::os::unix::net::UnixDatagram;

use super::discovery::Product;
use super::raw::RawReport;
use super::*;

const NOW: Duration = Duration::ZERO;

/// The camera's end of the socket, the opened stream, and what came of it.
struct Story {
    camera: UnixDatagram,
    stream: Stream,
    progress: Progress,
    readings: Vec<Reading>,
}

impl Story {
    fn new() -> Self {
        let (camera, host) = UnixDatagram::pair().unwrap();
        host.set_nonblocking(true).unwrap();
        let found = Found {
            product: Product::Zed2,
            serial: Some(21),
            firmware: None,
            path: CString::default(),
        };
        let link = Link { fd: host.into(), camera: found };
        Self {
            camera,
            stream: Stream::new(link),
            progress: Progress::default(),
            readings: Vec::new(),
        }
    }

    /// The camera sends the sample of one tick of 2.5 ms, changed by `change`.
    fn sends(&self, sample: u64, change: impl FnOnce(&mut RawReport)) {
        let mut raw = RawReport { struct_id: 1, ticks: sample * 64, ..RawReport::default() };
        change(&mut raw);
        self.camera.send(&raw.emit()).unwrap();
    }

    fn poll(&mut self, timeout: Duration) -> Outcome {
        self.stream.read(timeout, &mut self.progress, &mut self.readings)
    }

    fn counters(&self) -> DriverCounters {
        self.progress.counters
    }
}

#[test]
fn given_a_backlog_when_polled_once_then_all_of_it_comes_oldest_first_with_one_arrival() {
    let mut story = Story::new();
    (0..8).for_each(|i| story.sends(i, |_| ()));

    assert_eq!(story.poll(NOW), Outcome::Open);

    let times: Vec<i64> = story.readings.iter().map(|r| r.sensor_time.as_nanos()).collect();
    assert_eq!(times, (0..8).map(|i| i * 2_500_000).collect::<Vec<_>>());
    assert!(story.readings.iter().all(|r| r.arrival == story.readings[0].arrival));
    assert_eq!(story.counters(), DriverCounters::default());
}

#[test]
fn given_a_quiet_camera_when_polled_then_silence_grows_until_a_report_comes() {
    let mut story = Story::new();
    let wait = Duration::from_millis(1);
    assert_eq!(story.poll(wait), Outcome::Silent);
    assert!(story.stream.silence >= wait);

    story.stream.restarted = true;
    story.sends(0, |_| ());
    story.poll(wait);
    assert_eq!(story.stream.silence, Duration::ZERO);
    assert!(!story.stream.restarted, "the next silence may restart the stream again");
}

#[test]
fn given_a_process_that_was_stopped_then_the_time_it_did_not_run_is_no_silence() {
    let mut story = Story::new();
    let later = HostTime::from_nanos(story.stream.woken.as_nanos() + 60_000_000_000);
    story.stream.listen(later, Duration::from_millis(20));
    assert_eq!(story.stream.silence, LISTENED_AT_MOST);
    assert!(LISTENED_AT_MOST < RESTART_AFTER);
}

#[test]
fn given_polls_that_never_wait_then_silence_grows_all_the_same() {
    let mut story = Story::new();
    for _ in 0..100 {
        let next = HostTime::from_nanos(story.stream.woken.as_nanos() + 10_000_000);
        story.stream.listen(next, NOW);
    }
    assert_eq!(story.stream.silence, Duration::from_secs(1));
}

#[test]
fn given_garbage_between_reports_then_it_is_counted_and_the_reports_come_through() {
    let mut story = Story::new();
    story.sends(0, |_| ());
    story.camera.send(&[1; 61]).unwrap();
    story.camera.send(&[0xff; 64]).unwrap();
    story.sends(1, |_| ());

    assert_eq!(story.poll(NOW), Outcome::Open);

    assert_eq!(story.readings.len(), 2);
    assert_eq!(story.counters().malformed, 2);
    assert_eq!(story.counters().gaps, 0);
}

#[test]
fn given_nothing_but_garbage_then_the_camera_counts_as_not_heard() {
    let mut story = Story::new();
    story.stream.silence = RESTART_AFTER;
    story.camera.send(&[0xff; 64]).unwrap();
    assert_eq!(story.poll(NOW), Outcome::Open);
    assert!(story.stream.silence >= RESTART_AFTER);
}

#[test]
fn given_a_repeated_stamp_then_it_is_held_back_and_counted() {
    let mut story = Story::new();
    for i in [0, 1, 1, 2] {
        story.sends(i, |_| ());
    }
    story.poll(NOW);
    assert_eq!(story.readings.len(), 3);
    assert_eq!(story.counters().duplicates, 1);
}

#[test]
fn given_lost_samples_then_the_gap_and_their_number_are_counted() {
    let mut story = Story::new();
    for i in [0, 1, 5, 6, 8] {
        story.sends(i, |_| ());
    }
    story.poll(NOW);
    assert_eq!((story.counters().gaps, story.counters().samples_missing), (2, 4));
}

#[test]
fn given_a_sample_marked_invalid_then_it_is_counted_and_no_gap() {
    let mut story = Story::new();
    story.sends(0, |_| ());
    story.sends(1, |raw| raw.imu_not_valid = 1);
    story.sends(2, |_| ());
    story.poll(NOW);
    assert_eq!(story.readings.len(), 2);
    assert_eq!((story.counters().marked_invalid, story.counters().gaps), (1, 0));
}

#[test]
fn given_an_old_magnetometer_reading_then_it_is_not_passed_for_a_new_one() {
    let mut story = Story::new();
    for (sample, valid) in [(0, 2), (1, 1), (2, 0)] {
        story.sends(sample, |raw| (raw.mag_valid, raw.mag) = (valid, [160, 0, 0]));
    }
    story.poll(NOW);
    let fields: Vec<_> = story.readings.iter().map(|r| r.mag.map(|mag| mag.vector.x)).collect();
    assert_eq!(fields, [Some(10.0), None, None]);
}

#[test]
fn given_a_clock_that_starts_anew_then_the_epoch_is_raised_once() {
    let mut story = Story::new();
    story.sends(1_000_000, |_| ());
    (0..40).for_each(|i| story.sends(i, |_| ()));
    while story.poll(NOW) != Outcome::Silent {}

    let epochs: Vec<u32> = story.readings.iter().map(|r| r.epoch).collect();
    assert_eq!((epochs[0], epochs[19], epochs[20], epochs[40]), (0, 0, 1, 1));
    assert_eq!((story.counters().backwards, story.counters().clock_restarts), (19, 1));
}

#[test]
fn given_no_camera_then_open_says_what_there_is_and_a_waiting_driver_stops_cleanly() {
    // Serial number 0 belongs to no camera, whatever is plugged into this computer.
    let error = Zed2::open(0).err().expect("no camera has serial number 0");
    assert!(matches!(error, OpenError::NotFound { serial: 0, .. }), "{error}");

    let mut driver = Zed2::new(0).unwrap();
    let mut readings = Vec::new();
    assert_eq!(driver.poll(Duration::from_millis(1), &mut readings), SourceState::Lost);
    assert_eq!(driver.info().serial, Some(0));
    drop(driver);
}
