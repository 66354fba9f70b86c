//! Recordings made from the synthetic world, with what really happened beside them.

use std::fmt::Write;
use std::path::Path;
use std::time::Duration;

use glam::{DQuat, DVec3};
use lodestone_config::model::{AxisMap, Camera, DriverKind, Synthetic, TrajectoryKind, World};
use lodestone_daemon::driver::synthetic::SyntheticDriver;
use lodestone_daemon::driver::{Driver, SourceState};
use lodestone_daemon::reading::Reading;

/// One row in body axes; values are written as they stand, whatever they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorRow {
    /// Sensor time, ns.
    pub time_ns: i64,
    /// Angular rate, rad/s.
    pub gyro: DVec3,
    /// Specific force, m/s².
    pub accel: DVec3,
    /// Magnetic field where there is a new reading, µT.
    pub mag: Option<DVec3>,
}

/// A recording and the truth at each of its rows.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// What the sensors read.
    pub rows: Vec<SensorRow>,
    /// Body to world.
    pub truth: Vec<DQuat>,
}

/// A synthetic camera with sensors along the body's axes that gives its samples at once.
pub fn synthetic_camera(trajectory: TrajectoryKind, seed: u64, duration_s: f64) -> Camera {
    Camera {
        name: "front".into(),
        driver: DriverKind::Synthetic,
        axis_map: Some(AxisMap::IDENTITY),
        synthetic: Some(Synthetic {
            trajectory,
            seed,
            duration_s,
            speed: 0.0,
            rest_s: 3.0,
            ..Synthetic::default()
        }),
        ..Camera::default()
    }
}

impl Recorded {
    /// Records a synthetic camera.
    pub fn of(trajectory: TrajectoryKind, seed: u64, duration_s: f64) -> Self {
        let world = World { year: Some(2026.5), ..World::default() };
        let camera = synthetic_camera(trajectory, seed, duration_s);
        let mut driver = SyntheticDriver::new(&camera, &world).expect("a simple world");
        let mut readings: Vec<Reading> = Vec::new();
        while driver.poll(Duration::ZERO, &mut readings) != SourceState::Ended {}
        let truth =
            readings.iter().map(|r| driver.truth_at(r.sensor_time).orientation.quaternion());
        Self { truth: truth.collect(), rows: readings.iter().map(row).collect() }
    }

    /// The text of the recording, with a reading of the magnetometer wherever there is one.
    pub fn csv(&self) -> String {
        let mut text = String::from("t,gx,gy,gz,ax,ay,az,mx,my,mz\n");
        self.rows.iter().for_each(|row| row.append(&mut text));
        text
    }

    /// The same without columns for a magnetometer.
    pub fn csv_without_magnetometer(&self) -> String {
        let cut = |line: &str| line.split(',').take(7).collect::<Vec<_>>().join(",");
        self.csv().lines().map(|line| cut(line) + "\n").collect()
    }

    /// Writes the recording.
    pub fn write(&self, path: &Path) {
        std::fs::write(path, self.csv()).expect("writes");
    }
}

/// A text as Zstandard data.
pub fn compressed(text: &[u8]) -> Vec<u8> {
    ruzstd::encoding::compress_to_vec(text, ruzstd::encoding::CompressionLevel::Fastest)
}

fn row(reading: &Reading) -> SensorRow {
    SensorRow {
        time_ns: reading.sensor_time.as_nanos(),
        gyro: reading.gyro.vector,
        accel: reading.accel.vector,
        mag: reading.mag.map(|mag| mag.vector),
    }
}

impl SensorRow {
    fn append(&self, text: &mut String) {
        let (whole, rest) = (self.time_ns / 1_000_000_000, self.time_ns % 1_000_000_000);
        let sign = if self.time_ns < 0 { "-" } else { "" };
        write!(text, "{sign}{}.{:09}", whole.abs(), rest.abs()).expect("a string takes all");
        for value in self.gyro.to_array().into_iter().chain(self.accel.to_array()) {
            write!(text, ",{value}").expect("a string takes all");
        }
        match self.mag {
            Some(mag) => write!(text, ",{},{},{}", mag.x, mag.y, mag.z),
            None => write!(text, ",,,"),
        }
        .expect("a string takes all");
        text.push('\n');
    }
}
