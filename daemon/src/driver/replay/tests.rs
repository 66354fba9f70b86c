#![allow(clippy::float_cmp, reason = "values that pass through unchanged")]

use std::fmt::Write as _;

use tempfile::TempDir;

use super::super::host_clock::OnHostClock;
use super::*;

const HEADER: &str = "t,gx,gy,gz,ax,ay,az,mx,my,mz";

/// A folder with one recording in it.
struct Folder(TempDir);

impl Folder {
    fn with(content: impl AsRef<[u8]>) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("walk.csv"), content).unwrap();
        Self(folder)
    }

    fn try_open(&self, speed: f64, repeat: bool) -> Result<ReplayDriver, ReplayError> {
        let settings = Replay { file: "walk.csv".into(), speed, repeat };
        ReplayDriver::open(&settings, self.0.path())
    }

    fn open(&self, speed: f64, repeat: bool) -> ReplayDriver {
        self.try_open(speed, repeat).unwrap()
    }
}

/// A recording whose rows are 1 ms apart and whose first value counts them.
fn numbered(rows: u32) -> String {
    let mut text = format!("{HEADER}\n");
    for row in 0..rows {
        let mag = if row % 8 == 0 { "1,2,3" } else { ",," };
        writeln!(text, "{:.3},{row},0,0,0,0,9.81,{mag}", 10.0 + f64::from(row) * 0.001).unwrap();
    }
    text
}

fn play(driver: &mut ReplayDriver) -> Vec<Reading> {
    let mut readings = Vec::new();
    while driver.poll(Duration::from_secs(1), &mut readings) != SourceState::Ended {}
    readings
}

fn numbers(readings: &[Reading]) -> Vec<f64> {
    readings.iter().map(|reading| reading.gyro.vector.x).collect()
}

#[test]
fn as_fast_as_it_goes_each_row_arrives_at_its_own_time() {
    let folder = Folder::with(numbered(1000));
    let mut driver = folder.open(0.0, false);
    let readings = play(&mut driver);
    assert_eq!(numbers(&readings), (0..1000).map(f64::from).collect::<Vec<_>>());
    assert!(readings.iter().all(|r| r.arrival.as_nanos() == r.sensor_time.as_nanos()));
    assert_eq!(readings.iter().filter(|r| r.mag.is_some()).count(), 125);
    assert_eq!(driver.counters(), DriverCounters::default());
    assert!((driver.info().nominal_rate_hz - 1000.0).abs() < 1e-6);
    assert!(driver.info().description.ends_with("walk.csv"));
    assert!(driver.failure().get().is_none());
    assert_eq!(driver.poll(Duration::ZERO, &mut Vec::new()), SourceState::Ended);
}

#[test]
fn beside_a_live_lane_each_row_arrives_when_the_host_reads_it() {
    let folder = Folder::with(numbered(100));
    let mut driver = OnHostClock(folder.open(0.0, false));
    let (mut readings, start) = (Vec::new(), HostTime::now());
    while driver.poll(Duration::ZERO, &mut readings) != SourceState::Ended {}
    assert_eq!(numbers(&readings), (0..100).map(f64::from).collect::<Vec<_>>());
    assert!(readings.is_sorted_by_key(|reading| reading.arrival));
    assert!(readings.iter().all(|r| r.arrival >= start && r.arrival <= HostTime::now()));
}

#[test]
fn one_poll_hands_on_a_bounded_batch() {
    let folder = Folder::with(numbered(1000));
    let mut readings = Vec::new();
    let state = folder.open(0.0, false).poll(Duration::ZERO, &mut readings);
    assert_eq!((state, readings.len()), (SourceState::Streaming, BATCH));
}

#[test]
fn at_a_speed_no_row_arrives_before_it_is_due() {
    let folder = Folder::with(numbered(60));
    for speed in [1.0, 3.0] {
        let mut driver = folder.open(speed, false);
        let start = HostTime::now().as_nanos();
        let readings = play(&mut driver);
        assert_eq!(readings.len(), 60);
        for reading in &readings {
            let span = (reading.sensor_time - readings[0].sensor_time).as_secs_f64() / speed;
            let waited = (reading.arrival.as_nanos() - start) as f64 * 1e-9;
            assert!(waited > span - 1e-6, "{waited} s after the start, due after {span} s");
        }
        assert!(readings.is_sorted_by_key(|reading| reading.arrival));
    }
}

#[test]
fn a_poll_with_no_time_hands_on_nothing_that_is_not_due() {
    let folder = Folder::with(format!("{HEADER}\n0,0,0,0,0,0,0,,,\n9,0,0,0,0,0,0,,,\n"));
    let mut driver = folder.open(0.001, false);
    let mut readings = Vec::new();
    for _ in 0..3 {
        assert_eq!(driver.poll(Duration::ZERO, &mut readings), SourceState::Streaming);
    }
    assert_eq!(readings.len(), 1);
}

#[test]
fn repeating_counts_epochs_and_goes_on_in_time() {
    let folder = Folder::with(numbered(10));
    let mut driver = folder.open(0.0, true);
    let mut readings = Vec::new();
    while readings.len() < 30 {
        assert_eq!(driver.poll(Duration::ZERO, &mut readings), SourceState::Streaming);
    }
    for (at, reading) in (0_u32..).zip(&readings) {
        assert_eq!(reading.epoch, at / 10);
        assert_eq!(reading.gyro.vector.x, f64::from(at % 10));
        assert_eq!(reading.arrival.as_nanos(), 10_000_000_000 + i64::from(at) * 1_000_000);
    }
}

#[test]
fn given_the_recording_vanishes_between_rounds_then_the_source_ends_and_says_why() {
    let folder = Folder::with(numbered(10));
    let mut driver = folder.open(0.0, true);
    std::fs::remove_file(folder.0.path().join("walk.csv")).unwrap();
    assert_eq!(play(&mut driver).len(), 10);
    assert!(matches!(driver.failure().get(), Some(ReplayFailure::Reopen(_))));
}

#[test]
fn bad_rows_are_counted_and_values_that_are_not_finite_are_handed_on() {
    let text = format!(
        "{HEADER}\n0,0,0,0,0,0,0,,,\n0.1,oops,0,0,0,0,0,,,\n0.2,1,2\n0.3,nan,inf,0,0,0,0,,,\n"
    );
    let mut driver = Folder::with(text).open(0.0, false);
    let readings = play(&mut driver);
    assert_eq!(readings.len(), 2);
    assert!(readings[1].gyro.vector.x.is_nan());
    assert_eq!(driver.counters().malformed, 2);
}

#[test]
fn given_nothing_but_bad_rows_follow_then_polls_stay_bounded_and_the_source_ends() {
    let text = numbered(300) + &"nonsense\n".repeat(1000);
    let mut driver = Folder::with(text).open(0.0, false);
    assert_eq!(play(&mut driver).len(), 300);
    assert_eq!(driver.counters().malformed, 1000);
}

#[test]
fn given_truncated_data_then_the_source_ends_and_says_why() {
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};
    let whole = compress_to_vec(numbered(20_000).as_bytes(), CompressionLevel::Fastest);
    let mut driver = Folder::with(&whole[..whole.len() / 2]).open(0.0, false);
    assert!(play(&mut driver).len() > 1000);
    let failure = driver.failure();
    let reason = failure.get().unwrap().to_string();
    assert!(reason.contains("walk.csv: line ") && reason.contains("cut short"), "{reason}");
    assert_eq!(driver.counters().malformed, 0);
}

#[test]
fn speeds_that_make_no_sense_are_refused() {
    let folder = Folder::with(numbered(10));
    for speed in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(folder.try_open(speed, false), Err(ReplayError::Speed(_))));
    }
}
