#![expect(clippy::float_cmp, reason = "values are copied, never computed")]

use glam::DVec3;
use lodestone_fusion::{Accel, Gyro, Mag};

use super::*;
use crate::reading::{HostTime, RecordedAiding};

/// A source at 100 Hz that gives ten samples a poll; every value tells its sample's number.
struct Scripted {
    next: i64,
    end: i64,
    epoch: u32,
}

impl Scripted {
    fn lasting(samples: i64) -> Self {
        Self { next: 0, end: samples, epoch: 0 }
    }

    fn sample(&self, i: i64) -> Reading {
        let value = DVec3::splat(i as f64);
        let nanos = i * 10_000_000;
        Reading {
            epoch: self.epoch,
            // Neither clock begins at zero.
            sensor_time: SensorTime::from_nanos(7_000_000_000 + nanos),
            arrival: HostTime::from_nanos(90_000_000_000 + nanos),
            gyro: Gyro::new(value),
            accel: Accel::new(value),
            mag: (i % 2 == 0).then_some(Mag::new(value)),
            temperature_c: Some(i as f32),
            saturated: false,
            aiding: RecordedAiding::NONE,
        }
    }
}

impl Driver for Scripted {
    fn info(&self) -> DriverInfo {
        DriverInfo { description: "scripted".into(), serial: None, nominal_rate_hz: 100.0 }
    }

    fn poll(&mut self, _: Duration, sink: &mut dyn Sink) -> SourceState {
        let batch_end = (self.next + 10).min(self.end);
        (self.next..batch_end).for_each(|i| sink.push(self.sample(i)));
        self.next = batch_end;
        if self.next == self.end { SourceState::Ended } else { SourceState::Streaming }
    }

    fn counters(&self) -> DriverCounters {
        DriverCounters { reconnects: 3, ..DriverCounters::default() }
    }
}

/// A fault of `kind` from sample 20 up to sample 40 (0.2 s to 0.4 s).
fn fault(kind: FaultKind) -> Fault {
    Fault { kind, at_s: 0.195, duration_s: 0.2 }
}

/// Sixty samples under faults: what arrives, and the state after each poll.
fn played(faults: &[Fault]) -> (Vec<Reading>, Vec<SourceState>) {
    let mut driver = FaultyDriver::new(Scripted::lasting(60), faults);
    let (mut readings, mut states) = (Vec::new(), Vec::new());
    while states.last() != Some(&SourceState::Ended) {
        states.push(driver.poll(Duration::ZERO, &mut readings));
    }
    (readings, states)
}

/// The number of a sample by its time stamp.
fn number(reading: &Reading) -> i64 {
    (reading.sensor_time.as_nanos() - 7_000_000_000) / 10_000_000
}

fn numbers(readings: &[Reading]) -> Vec<i64> {
    readings.iter().map(number).collect()
}

#[test]
fn given_no_fault_then_the_stream_is_untouched() {
    let (readings, _) = played(&[]);
    let inner = Scripted::lasting(60);
    assert_eq!(readings, (0..60).map(|i| inner.sample(i)).collect::<Vec<_>>());
}

#[test]
fn given_a_drop_then_its_samples_are_missing_and_no_others() {
    let (readings, states) = played(&[fault(FaultKind::Drop)]);
    assert_eq!(numbers(&readings), (0..20).chain(40..60).collect::<Vec<_>>());
    assert!(!states.contains(&SourceState::Lost), "samples vanish while the source is open");
}

#[test]
fn given_duplication_then_each_sample_comes_twice_in_a_row() {
    let (readings, _) = played(&[fault(FaultKind::Duplicate)]);
    assert_eq!(numbers(&readings)[18..26], [18, 19, 20, 20, 21, 21, 22, 22]);
    assert_eq!(readings.len(), 80);
    assert_eq!(readings[20], readings[21]);
}

#[test]
fn given_time_that_runs_backwards_then_stamps_mirror_and_values_go_on() {
    let (readings, _) = played(&[fault(FaultKind::TimeBackwards)]);
    assert_eq!(numbers(&readings)[18..24], [18, 19, 20, 19, 18, 17]);
    assert_eq!(numbers(&readings)[40], 40, "the true time is back after the fault");
    assert_eq!(readings[23].gyro.vector.x, 23.0);
}

#[test]
fn given_a_stuck_sensor_then_values_repeat_the_first_one_while_time_goes_on() {
    let (readings, _) = played(&[fault(FaultKind::Stuck)]);
    assert_eq!(numbers(&readings), (0..60).collect::<Vec<_>>());
    for reading in &readings[20..40] {
        assert_eq!((reading.gyro.vector.x, reading.accel.vector.y), (20.0, 20.0));
        assert_eq!(reading.temperature_c, Some(20.0));
        assert!(reading.mag.is_none_or(|mag| mag.vector.x == 20.0));
    }
    assert!(readings[21].mag.is_none() && readings[22].mag.is_some(), "its rhythm stays");
    assert_eq!(readings[40].gyro.vector.x, 40.0);
}

#[test]
fn given_values_that_are_no_measurements_then_exactly_those_samples_carry_them() {
    type Test = fn(f64) -> bool;
    let kinds: [(FaultKind, Test); 3] = [
        (FaultKind::NotANumber, f64::is_nan),
        (FaultKind::Infinite, f64::is_infinite),
        (FaultKind::Huge, |x| x.is_finite() && (x * x).is_infinite()),
    ];
    for (kind, is_meant) in kinds {
        let (readings, _) = played(&[fault(kind)]);
        for (i, reading) in readings.iter().enumerate() {
            let all = |v: DVec3| v.to_array().into_iter().all(is_meant);
            let hit = all(reading.gyro.vector)
                && all(reading.accel.vector)
                && reading.mag.is_none_or(|mag| all(mag.vector));
            assert_eq!(hit, (20..40).contains(&i), "{kind:?}, sample {i}");
        }
    }
}

#[test]
fn given_saturation_then_values_are_at_the_end_of_the_range_and_marked() {
    let (readings, _) = played(&[fault(FaultKind::Saturated)]);
    let marked: Vec<i64> = readings.iter().filter(|r| r.saturated).map(number).collect();
    assert_eq!(marked, (20..40).collect::<Vec<_>>());
    assert!((readings[20].gyro.vector.x.to_degrees() - 1000.0).abs() < 1e-9);
    assert!((readings[20].accel.vector.z - 78.5512).abs() < 1e-9);
}

#[test]
fn given_an_unplugging_then_the_source_is_lost_and_comes_back_in_a_new_epoch() {
    let mut driver = FaultyDriver::new(Scripted::lasting(60), &[fault(FaultKind::Unplug)]);
    let mut readings = Vec::new();
    let states: Vec<SourceState> =
        (0..5).map(|_| driver.poll(Duration::ZERO, &mut readings)).collect();

    let lost: Vec<bool> = states.iter().map(|state| *state == SourceState::Lost).collect();
    assert_eq!(lost, [false, false, true, true, false]);
    assert_eq!(numbers(&readings), (0..20).chain(40..50).collect::<Vec<_>>());
    assert_eq!((readings[19].epoch, readings[20].epoch), (0, 1));
    assert_eq!(driver.counters().reconnects, 3 + 1, "the inner driver's own count is kept");
}

#[test]
fn given_a_stall_then_its_samples_come_late_in_one_burst_in_their_order() {
    let mut driver = FaultyDriver::new(Scripted::lasting(60), &[fault(FaultKind::Stall)]);
    let mut readings = Vec::new();
    for _ in 0..4 {
        driver.poll(Duration::ZERO, &mut readings);
    }
    assert_eq!(readings.len(), 20, "nothing comes during the stall");

    driver.poll(Duration::ZERO, &mut readings);

    assert_eq!(numbers(&readings), (0..50).collect::<Vec<_>>());
    assert!(readings[20..41].iter().all(|r| r.arrival == readings[40].arrival));
}

#[test]
fn given_a_source_that_ends_during_a_stall_or_a_swap_then_nothing_is_lost() {
    let to_the_end = |kind| Fault { kind, at_s: 0.195, duration_s: 1e9 };
    for kind in [FaultKind::Stall, FaultKind::Reorder] {
        let (readings, _) = played(&[to_the_end(kind)]);
        let mut sorted = numbers(&readings);
        sorted.sort_unstable();
        assert_eq!(sorted, (0..60).collect::<Vec<_>>(), "{kind:?}");
    }
}

#[test]
fn given_a_silent_magnetometer_then_only_it_is_silent() {
    let (readings, _) = played(&[fault(FaultKind::NoMagnetometer)]);
    let heard = readings.iter().filter(|r| r.mag.is_some()).map(number);
    assert!(heard.eq((0..20).chain(40..60).filter(|i| i % 2 == 0)));
    assert_eq!(readings.len(), 60);
}

#[test]
fn given_reordering_then_neighbours_change_places_and_arrivals_stay_in_order() {
    let (readings, _) = played(&[fault(FaultKind::Reorder)]);
    assert_eq!(numbers(&readings)[18..26], [18, 19, 21, 20, 23, 22, 25, 24]);
    assert_eq!(numbers(&readings)[38..42], [39, 38, 40, 41]);
    assert!(readings.windows(2).all(|pair| pair[0].arrival <= pair[1].arrival));
}

#[test]
fn given_several_faults_at_once_then_all_of_them_act() {
    let faults = [FaultKind::Duplicate, FaultKind::Stuck, FaultKind::NoMagnetometer].map(fault);
    let (readings, _) = played(&faults);
    assert_eq!(readings.len(), 80);
    assert!(readings[20..60].iter().all(|r| r.gyro.vector.x == 20.0 && r.mag.is_none()));
}

#[test]
fn given_a_sensor_clock_that_starts_anew_then_the_streams_time_goes_on() {
    let mut time = StreamTime::default();
    let source = Scripted::lasting(0);
    assert_eq!(time.of(&source.sample(0)), 0.0);
    assert_eq!(time.of(&source.sample(500)), 5.0);

    let anew = Reading { epoch: 1, ..source.sample(3) };
    assert_eq!(time.of(&anew), 5.0);
    assert_eq!(time.of(&Reading { epoch: 1, ..source.sample(103) }), 6.0);
}

#[test]
fn given_the_same_faults_then_the_same_stream_comes_out_again() {
    let faults = [FaultKind::Reorder, FaultKind::Stall, FaultKind::Huge].map(fault);
    assert_eq!(played(&faults), played(&faults));
}

#[test]
fn given_an_endless_stall_then_the_memory_it_takes_is_bounded() {
    let endless = Fault { kind: FaultKind::Stall, at_s: 0.0, duration_s: f64::INFINITY };
    assert_eq!(stall_capacity(&[endless], 400.0), MOST_SAMPLES);
    assert_eq!(stall_capacity(&[fault(FaultKind::Drop)], 400.0), 0);
}

#[test]
fn given_a_stall_longer_than_its_memory_then_the_newest_are_lost_and_nothing_is_allocated() {
    let mut flow = Flow::with_capacity(8);
    flow.stall = true;
    let (source, mut readings) = (Scripted::lasting(0), Vec::new());
    (0..30).for_each(|i| flow.take(source.sample(i), &mut readings));
    assert_eq!((readings.len(), flow.capacity()), (0, 8));

    flow.stall = false;
    flow.take(source.sample(30), &mut readings);

    assert_eq!(numbers(&readings), [0, 1, 2, 3, 4, 5, 6, 7, 30]);
    assert_eq!(flow.capacity(), 8);
}

const MOST_SAMPLES: usize = 262_144;
