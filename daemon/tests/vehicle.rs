//! A camera in the simulated car, from its samples to its poses: with the car's speed and without.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod common;

use std::time::Duration;

use glam::DVec3;
use lodestone_config::{Config, Loaded};
use lodestone_daemon::driver::synthetic::{SyntheticDriver, Truth};
use lodestone_daemon::driver::{Driver, Sink};
use lodestone_daemon::lane::{Core, LaneSettings};
use lodestone_daemon::reading::{Reading, RecordedAiding, RecordedSpeed};
use lodestone_daemon::rig::{RigCore, RigSettings, RigStep};
use lodestone_fusion::{Estimate, SensorTime};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const SEEDS: u64 = 10;

/// Every so many samples the car tells its speed: 50 Hz.
const SAMPLES_PER_SPEED: usize = 8;
const SPEED_SIGMA_M_S: f64 = 0.05;

fn configuration(seed: u64, body: &str) -> Config {
    let text = format!(
        "{body}\n[world]\nyear = 2026.0\n[[camera]]\nname = \"front\"\ndriver = \"synthetic\"\n\
         {on}\n[camera.synthetic]\ntrajectory = \"car\"\nrest_s = 4.0\nspeed = 0.0\nseed = {seed}\n",
        on = if body.is_empty() { "" } else { "body = \"car\"" }
    );
    Config::from_toml("car.toml", &text).unwrap()
}

const CAR: &str = "[[body]]\nname = \"car\"\nvehicle = true";

/// What a source pushes.
struct Batch(Vec<Reading>);

impl Sink for Batch {
    fn push(&mut self, reading: Reading) {
        self.0.push(reading);
    }
}

/// A camera in a car, and the lane that follows it.
struct Ride {
    driver: SyntheticDriver,
    core: Core,
    readings: std::collections::VecDeque<Reading>,
    random: ChaCha8Rng,
    taken: usize,
    with_speed: bool,
    distance_m: f64,
    truth: Truth,
    stood_s: f64,
    worst_creep_m: f64,
    halted_at: Option<DVec3>,
}

impl Ride {
    fn new(seed: u64, with_speed: bool) -> Self {
        let config = configuration(seed, if with_speed { CAR } else { "" });
        let camera = &config.camera[0];
        let driver = SyntheticDriver::new(camera, &config.world).unwrap();
        let settings = LaneSettings::new(&config, 0, camera, None, 400.0).unwrap();
        let truth = driver.truth_at(driver.truth_source().start());
        Self {
            driver,
            core: Core::new(&settings),
            readings: std::collections::VecDeque::new(),
            random: ChaCha8Rng::seed_from_u64(seed),
            taken: 0,
            with_speed,
            distance_m: 0.0,
            truth,
            stood_s: 0.0,
            worst_creep_m: 0.0,
            halted_at: None,
        }
    }

    fn drive(&mut self, seconds: f64) {
        for _ in 0..(seconds * 400.0) as usize {
            self.step();
        }
    }

    fn step(&mut self) {
        while self.readings.is_empty() {
            let mut batch = Batch(Vec::new());
            self.driver.poll(Duration::ZERO, &mut batch);
            self.readings.extend(batch.0);
        }
        let mut reading = self.readings.pop_front().unwrap();
        self.truth = self.driver.truth_at(reading.sensor_time);
        self.distance_m += self.truth.velocity_m_s.length() / 400.0;
        if self.with_speed && self.taken.is_multiple_of(SAMPLES_PER_SPEED) {
            reading.aiding = RecordedAiding { speed: Some(self.speed()), fix: None };
        }
        self.taken += 1;
        self.core.take(&reading, |_| {});
        self.watch_creep();
    }

    fn speed(&mut self) -> RecordedSpeed {
        let forward = self.truth.orientation.inverse().apply(self.truth.velocity_m_s).x;
        let noise: f64 = StandardNormal.sample(&mut self.random);
        RecordedSpeed {
            speed_m_s: forward + SPEED_SIGMA_M_S * noise,
            sigma_m_s: Some(SPEED_SIGMA_M_S as f32),
            age_s: 0.0,
        }
    }

    /// How far the position moves from four seconds into a stop on.
    fn watch_creep(&mut self) {
        let standing = self.truth.velocity_m_s.length() < 1e-9;
        self.stood_s = if standing { self.stood_s + 1.0 / 400.0 } else { 0.0 };
        if self.stood_s < 4.0 {
            self.halted_at = None;
            return;
        }
        let Some(estimate) = self.core.at_last_reading() else { return };
        let halt = *self.halted_at.get_or_insert(estimate.position);
        let crept = (estimate.position - halt).length();
        self.worst_creep_m = self.worst_creep_m.max(crept);
    }

    fn position_error(&self) -> DVec3 {
        self.truth.position_m - self.core.at_last_reading().unwrap().position
    }

    /// NEES per number of position and velocity.
    fn nees(&self) -> [f64; 2] {
        let estimate = self.core.at_last_reading().unwrap();
        let velocity = self.truth.velocity_m_s - estimate.velocity;
        [
            (self.position_error(), estimate.position_covariance),
            (velocity, estimate.velocity_covariance),
        ]
        .map(|(error, covariance)| error.dot(covariance.inverse() * error) / 3.0)
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) }
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

/// Median error as a part of the way, and mean NEES of position and velocity.
fn score(what: &str, rides: &[Ride]) -> (f64, [f64; 2]) {
    let off = rides.iter().map(|ride| ride.position_error().length() / ride.distance_m);
    let off = median(off.collect());
    let nees = [0, 1].map(|k| mean(rides.iter().map(|ride| ride.nees()[k])));
    println!("{what}: {:.2} % of the way, NEES {:.2} {:.2}", 100.0 * off, nees[0], nees[1]);
    (off, nees)
}

#[test]
fn with_its_speed_a_car_is_off_by_less_than_a_hundredth_of_its_way() {
    let mut rides: Vec<Ride> = (0..SEEDS).map(|seed| Ride::new(seed, true)).collect();
    // After a minute most of it is the accelerometer: off by 0.05 m/s² it tilts the car by 0.3° and turns its
    // compass by twice that, which is a hundredth of the way. Only turns tell them apart.
    for (seconds, what, most) in [(64.0, "a minute", 0.01), (540.0, "ten minutes", 0.01)] {
        for ride in &mut rides {
            ride.drive(seconds);
        }
        let (off, nees) = score(what, &rides);
        assert!(off < most, "{what}: {off}");
        assert!(nees.iter().all(|n| *n < 1.57), "{what}: {nees:?}");
    }
    for ride in &rides {
        let counts = ride.core.counts();
        assert_eq!((counts.aiding_invalid, counts.resets), (0, 0));
        let refused = counts.aiding_refused as f64 / counts.aiding_used as f64;
        assert!(refused < 0.05, "{counts:?}");
        assert!(ride.worst_creep_m < 1e-3, "crept by {} m", ride.worst_creep_m);
    }
}

#[test]
fn unaided_a_car_knows_how_lost_it_is() {
    let mut rides: Vec<Ride> = (0..SEEDS).map(|seed| Ride::new(seed, false)).collect();
    for (seconds, what) in [(14.0, "14 s"), (10.0, "24 s"), (20.0, "44 s"), (20.0, "64 s")] {
        for ride in &mut rides {
            ride.drive(seconds);
        }
        let (_, nees) = score(what, &rides);
        assert!(nees.iter().all(|n| (0.02..1.57).contains(n)), "{what}: {nees:?}");
    }
}

/// Two cameras on a car, as in the shipped configuration of a vehicle; its speed is told to the front one.
const TWO_ON_A_CAR: &str = r#"
[world]
year = 2026.0
[[body]]
name = "car"
vehicle = true
[[camera]]
name = "front"
driver = "synthetic"
body = "car"
imu_delay_s = 0.0
mounting = { position_m = [2.1, 0.0, 0.9], roll_pitch_yaw_deg = [0.0, 10.0, 0.0] }
synthetic = { trajectory = "car", rest_s = 4.0, speed = 0.0, seed = 0 }
[[camera]]
name = "rear"
driver = "synthetic"
body = "car"
imu_delay_s = 0.0
mounting = { position_m = [-0.6, 0.0, 1.1], roll_pitch_yaw_deg = [0.0, 0.0, 180.0] }
synthetic = { trajectory = "car", rest_s = 4.0, speed = 0.0, seed = 1000 }
"#;

/// A car with two cameras, and the rig's lane that follows it.
struct RideOfTwo {
    drivers: [SyntheticDriver; 2],
    core: RigCore,
    readings: [std::collections::VecDeque<Reading>; 2],
    random: ChaCha8Rng,
    start: Truth,
    truth: Truth,
    latest: Option<Estimate>,
    distance_m: f64,
}

impl RideOfTwo {
    fn new(seed: u64) -> Self {
        let mut config = Config::from_toml("two.toml", TWO_ON_A_CAR).unwrap();
        for (k, camera) in (0..).zip(&mut config.camera) {
            camera.synthetic.as_mut().unwrap().seed = seed + 1000 * k;
        }
        let leader = &config.camera[0];
        let driver = |k: usize| SyntheticDriver::riding(&config.camera[k], leader, &config.world);
        let drivers = [driver(0).unwrap(), driver(1).unwrap()];
        let rig = config.rigs().remove(0);
        let start = drivers[0].truth_at(drivers[0].truth_source().start());
        let loaded = Loaded { config, path: "two.toml".into() };
        let settings = RigSettings::new(&loaded, &rig, &[400.0; 2]).unwrap();
        Self {
            drivers,
            core: RigCore::new(&settings),
            readings: Default::default(),
            random: ChaCha8Rng::seed_from_u64(seed),
            start,
            truth: start,
            latest: None,
            distance_m: 0.0,
        }
    }

    fn drive(&mut self, seconds: f64) {
        for step in 0..(seconds * 400.0) as usize {
            for member in 0..2 {
                let reading = self.reading(member, step);
                let time = SensorTime::from_nanos(reading.arrival.as_nanos());
                let latest = &mut self.latest;
                self.core.take(member, &reading, time, |step: &RigStep<'_>| {
                    *latest = step.member(0).estimate;
                });
            }
        }
    }

    fn reading(&mut self, member: usize, step: usize) -> Reading {
        while self.readings[member].is_empty() {
            let mut batch = Batch(Vec::new());
            self.drivers[member].poll(Duration::ZERO, &mut batch);
            self.readings[member].extend(batch.0);
        }
        let mut reading = self.readings[member].pop_front().unwrap();
        if member == 0 {
            self.truth = self.drivers[0].truth_at(reading.sensor_time);
            self.distance_m += self.truth.velocity_m_s.length() / 400.0;
            if step.is_multiple_of(SAMPLES_PER_SPEED) {
                reading.aiding = RecordedAiding { speed: Some(self.speed()), fix: None };
            }
        }
        reading
    }

    /// Of the car: along its x axis, which the front camera looks down from.
    fn speed(&mut self) -> RecordedSpeed {
        let forward = glam::DQuat::from_rotation_y(10_f64.to_radians()).inverse() * DVec3::X;
        let seen = self.truth.orientation.inverse().apply(self.truth.velocity_m_s);
        let noise: f64 = StandardNormal.sample(&mut self.random);
        RecordedSpeed {
            speed_m_s: seen.dot(forward) + SPEED_SIGMA_M_S * noise,
            sigma_m_s: Some(SPEED_SIGMA_M_S as f32),
            age_s: 0.0,
        }
    }

    /// Of the front camera, which began in the origin.
    fn position_error(&self) -> DVec3 {
        let way = self.truth.position_m - self.start.position_m;
        way - self.latest.unwrap().position
    }

    fn nees(&self) -> f64 {
        let error = self.position_error();
        error.dot(self.latest.unwrap().position_covariance.inverse() * error) / 3.0
    }
}

#[test]
fn two_cameras_on_a_car_are_off_by_no_more_than_one() {
    let mut one: Vec<Ride> = (0..SEEDS).map(|seed| Ride::new(seed, true)).collect();
    let mut two: Vec<RideOfTwo> = (0..SEEDS).map(RideOfTwo::new).collect();
    for (one, two) in one.iter_mut().zip(&mut two) {
        one.drive(124.0);
        two.drive(124.0);
    }
    let (off_of_one, _) = score("one camera, two minutes", &one);
    let off = median(two.iter().map(|r| r.position_error().length() / r.distance_m).collect());
    let nees = mean(two.iter().map(RideOfTwo::nees));
    println!("two cameras, two minutes: {:.2} % of the way, NEES {nees:.2}", 100.0 * off);
    assert!(off < 0.01 && off < 1.2 * off_of_one, "{off} of the way, one camera {off_of_one}");
    assert!(nees < 1.57, "{nees}");
    for ride in &two {
        let counts = ride.core.counts(0);
        assert_eq!((counts.aiding_invalid, ride.core.resets()), (0, 0));
        assert!(counts.aiding_refused * 20 < counts.aiding_used, "{counts:?}");
        assert!((0..2).all(|k| ride.core.status(k).exclusion.is_none()));
    }
}
