#![allow(clippy::float_cmp, reason = "values that pass through unchanged")]

use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Exp};

use super::*;

const SECOND: i64 = 1_000_000_000;

/// Host time of sensor time 0 in the simulations, ns.
const START: i64 = 5_000 * SECOND;

fn sensor(nanos: i64) -> SensorTime {
    SensorTime::from_nanos(nanos)
}

fn host(nanos: i64) -> HostTime {
    HostTime::from_nanos(nanos)
}

/// A sensor at 400 Hz behind a line with exponential delays, and the clock that watches it.
struct Story {
    clock: SensorClock,
    random: ChaCha8Rng,
    rate: f64,
    mean_delay_s: f64,
    /// Least delay, ns.
    base_ns: i64,
    /// Samples wait until then, ns of host time.
    stalled_until: i64,
    sensor_ns: i64,
    arrival_ns: i64,
    epoch: u32,
}

impl Story {
    fn new(drift: f64, mean_delay_s: f64, seed: u64) -> Self {
        Self {
            clock: SensorClock::default(),
            random: ChaCha8Rng::seed_from_u64(seed),
            rate: 1.0 + drift,
            mean_delay_s,
            base_ns: 0,
            stalled_until: i64::MIN,
            sensor_ns: 0,
            arrival_ns: i64::MIN,
            epoch: 0,
        }
    }

    /// When the sample of now was taken, ns of host time.
    fn truth_ns(&self) -> i64 {
        START + (self.sensor_ns as f64 * self.rate).round() as i64
    }

    /// One sample; the mapped time minus the earliest possible arrival, s.
    fn step(&mut self) -> f64 {
        self.sensor_ns += 2_500_000;
        let delay_s = Exp::new(1.0 / self.mean_delay_s).unwrap().sample(&mut self.random);
        let ready = self.truth_ns() + self.base_ns + (delay_s * 1e9) as i64;
        self.arrival_ns = self.arrival_ns.max(ready).max(self.stalled_until);
        let taken = sensor(self.sensor_ns);
        self.clock.observe(taken, host(self.arrival_ns), self.epoch);
        let mapped = self.clock.host_time(taken).unwrap();
        assert!(mapped <= host(self.arrival_ns), "later than its arrival");
        (mapped.as_nanos() - self.truth_ns() - self.base_ns) as f64 * 1e-9
    }

    /// Runs for a while; the smallest and the largest error, s.
    fn run(&mut self, seconds: f64) -> (f64, f64) {
        (0..(seconds * 400.0) as usize)
            .map(|_| self.step())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), error| {
                (least.min(error), most.max(error))
            })
    }

    /// Runs for a while; the largest error, s.
    fn worst(&mut self, seconds: f64) -> f64 {
        let (least, most) = self.run(seconds);
        most.max(-least)
    }
}

#[test]
fn nothing_is_known_before_the_first_arrival_and_the_first_maps_to_its_arrival() {
    let mut clock = SensorClock::default();
    assert_eq!(clock.host_time(sensor(7)), None);
    clock.observe(sensor(7), host(1_000), 0);
    assert_eq!(clock.host_time(sensor(7)), Some(host(1_000)));
    assert_eq!(clock.host_time(sensor(107)), Some(host(1_100)));
    assert_eq!(clock.drift(), 0.0);
}

#[test]
fn a_recordings_own_clock_is_mapped_exactly() {
    let mut clock = SensorClock::default();
    for row in 0..50_000 {
        let t = 1_700_000_000 * SECOND + row * 3_500_017;
        clock.observe(sensor(t), host(t), 0);
        assert_eq!(clock.host_time(sensor(t - 1_000)), Some(host(t - 1_000)));
        assert_eq!(clock.host_time(sensor(t)), Some(host(t)));
    }
}

#[test]
fn given_a_stall_of_a_second_when_it_ends_then_the_line_has_not_bent() {
    for drift in [-0.02, 0.0, 0.0001, 0.02] {
        let mut story = Story::new(drift, 0.000_5, 3);
        story.run(12.0);
        story.stalled_until = story.truth_ns() + SECOND;
        let during = story.worst(1.0);
        let after = story.worst(5.0);
        assert!(during < 50e-6, "{drift}: {during} during the stall");
        assert!(after < 50e-6, "{drift}: {after} after the stall");
    }
}

#[test]
fn given_a_stall_right_at_the_start_then_the_clock_recovers() {
    for (before_s, drift) in [(0.0, 0.02), (0.05, -0.02), (0.2, 0.01), (0.2, -0.01)] {
        let mut story = Story::new(drift, 0.000_5, 4);
        story.run(before_s);
        story.stalled_until = story.truth_ns() + SECOND;
        story.run(1.2);
        story.run(8.0);
        let after = story.worst(2.0);
        assert!(after < 50e-6, "{before_s} s, {drift}: {after}");
    }
}

#[test]
fn given_the_least_delay_steps_then_mapped_times_follow_and_never_err_by_more_than_the_step() {
    for step_ns in [2_000_000, -2_000_000] {
        let mut story = Story::new(0.003, 0.000_2, 5);
        story.base_ns = 5_000_000;
        story.run(30.0);
        story.base_ns += step_ns;
        let (least, most) = story.run(25.0);
        assert!(least > -2.2e-3 && most < 2.2e-3, "{step_ns}: {least} {most}");
        let settled = story.worst(10.0);
        assert!(settled < 50e-6, "{step_ns}: {settled}");
    }
}

#[test]
fn given_a_gap_of_an_hour_then_the_drift_carries_across() {
    let mut story = Story::new(0.015, 0.000_2, 6);
    story.run(30.0);
    story.sensor_ns += 3_600 * SECOND;
    story.run(2.0);
    assert!((story.clock.drift() - 0.015).abs() < 1e-4);
    assert!(story.worst(10.0) < 50e-6);
}

#[test]
fn given_the_host_slept_and_its_clock_stood_then_the_clock_starts_anew_at_once() {
    let mut story = Story::new(0.001, 0.000_2, 7);
    story.run(30.0);
    // The sensor went on for a minute that CLOCK_MONOTONIC does not count.
    let before = story.truth_ns();
    story.sensor_ns += 60 * SECOND;
    let gained = story.truth_ns() - before;
    story.base_ns -= gained;
    assert!(story.worst(1.0) < 1e-3);
    assert!(story.worst(5.0) < 50e-6);
}

#[test]
fn given_the_sensors_clock_starts_at_zero_again_then_mapped_times_go_on() {
    for new_epoch in [true, false] {
        let mut story = Story::new(0.01, 0.000_2, 8);
        story.run(20.0);
        let until_now = story.truth_ns() - START;
        story.base_ns += until_now + SECOND / 2;
        story.sensor_ns = 0;
        story.epoch += u32::from(new_epoch);
        story.run(2.0);
        assert!(story.worst(5.0) < 50e-6, "new epoch: {new_epoch}");
    }
}

#[test]
fn a_recording_played_faster_has_its_nominal_rate() {
    let mut clock = SensorClock::new(0.1);
    let mut worst = 0;
    for n in 0..20_000 {
        let taken = n * 2_500_000;
        let arrival = START + taken / 10 + (n % 7) * 10_000;
        clock.observe(sensor(taken), host(arrival), 0);
        let mapped = clock.host_time(sensor(taken)).unwrap().as_nanos();
        worst = worst.max((mapped - START - taken / 10).abs());
    }
    assert!(worst < 20_000, "{worst} ns");
    assert!(clock.drift().abs() < 1e-4);
    assert!(clock.pending_correction_s().abs() < 1e-6);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// A bucket of 0.32 s holds 128 samples, so its least delay is 1/128 of the mean on average;
    /// the envelope rests on the lowest of 30 such. Extrapolated from the middle of the window to
    /// its end, a tenth of the mean delay leaves a factor of about ten.
    #[test]
    fn drift_and_offset_are_found_within_ten_seconds(
        drift in -0.02..0.02,
        mean_delay_s in 0.000_05..0.005,
        seed in any::<u64>(),
    ) {
        let mut story = Story::new(drift, mean_delay_s, seed);
        story.run(10.0);
        let worst = story.worst(20.0);
        prop_assert!(worst < 0.1 * mean_delay_s, "{} of the mean delay", worst / mean_delay_s);
        prop_assert!((story.clock.drift() - drift).abs() < 0.02 * mean_delay_s);
    }

    #[test]
    fn mapped_times_never_decrease_and_never_lie_behind_the_arrival(
        rate in prop::sample::select(vec![1.0, 0.5, 3.0]),
        steps in prop::collection::vec((-5_000_000_i64..50_000_000, 0_i64..60_000_000), 1..2000),
    ) {
        let mut clock = SensorClock::new(rate);
        let (mut taken, mut arrival, mut last) = (0, 0, i64::MIN);
        for (sensor_step, host_step) in steps {
            (taken, arrival) = (taken + sensor_step, arrival + host_step);
            clock.observe(sensor(taken), host(arrival), 0);
            let mapped = clock.host_time(sensor(taken)).unwrap().as_nanos();
            prop_assert!(mapped >= last);
            prop_assert!(mapped <= arrival);
            last = mapped;
        }
    }

    #[test]
    fn any_numbers_whatever_are_survived(
        steps in prop::collection::vec((any::<i64>(), any::<i64>(), 0_u32..3), 1..300),
    ) {
        let mut clock = SensorClock::default();
        let mut last = None;
        for (taken, arrival, epoch) in steps {
            clock.observe(sensor(taken), host(arrival), epoch);
            let mapped = clock.host_time(sensor(taken));
            prop_assert!(mapped.is_some() && mapped >= last);
            prop_assert!(clock.drift().abs() <= MAX_DRIFT);
            last = mapped;
        }
    }
}

#[test]
fn a_host_time_leads_back_to_its_sensor_time() {
    // Given a sensor that runs two percent fast, when the clock has learnt it, then times of the last
    // seconds, and of those to come, lead there and back within a microsecond.
    let mut clock = SensorClock::default();
    assert_eq!(clock.sensor_time(host(START)), None);
    for k in 0..8_000_i64 {
        let taken = k * 2_500_000;
        let arrival = START + (taken as f64 * 0.98).round() as i64;
        clock.observe(sensor(taken), host(arrival), 0);
    }
    for ago_s in [2.0, 0.5, 0.0, -0.5] {
        let taken = sensor(19_997_500_000 - (ago_s * 1e9) as i64);
        let at = clock.state.as_ref().map(|s| s.line(taken, 1.0)).map(host);
        let back = at.and_then(|at| clock.sensor_time(at)).expect("known by now");
        assert!((back - taken).as_nanos().abs() < 1_000, "{back:?} for {taken:?}");
    }
}
