//! What a driver hands on.

use lodestone_fusion::{Accel, Gyro, Mag, Sensor, SensorTime};

/// An instant on `CLOCK_MONOTONIC`, ns (for a recording: on the recording's own clock).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct HostTime(i64);

impl HostTime {
    /// Takes nanoseconds.
    pub const fn from_nanos(nanos: i64) -> Self {
        Self(nanos)
    }

    /// Nanoseconds.
    pub const fn as_nanos(self) -> i64 {
        self.0
    }

    /// The clock now.
    pub fn now() -> Self {
        let t = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
        Self(t.tv_sec * 1_000_000_000 + t.tv_nsec)
    }
}

/// One sample in sensor axes and physical units, not calibrated, on the sensor's clock.
///
/// A driver hands on what the device said, in the device's order: a value that is not finite or
/// a time stamp that runs backwards is for the lane to refuse and count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Which run of the sensor's clock `sensor_time` belongs to.
    ///
    /// It starts at 0 and is raised each time the device was opened again or its clock started
    /// anew. Sensor times of different epochs cannot be compared: the lane maps the clock afresh.
    /// A source that is opened once (synthetic, replay) leaves it at 0.
    pub epoch: u32,
    /// When the sensor took the sample.
    pub sensor_time: SensorTime,
    /// When the sample reached this computer.
    pub arrival: HostTime,
    /// Angular rate.
    pub gyro: Gyro<Sensor>,
    /// Specific force.
    pub accel: Accel<Sensor>,
    /// Magnetic field, only where this sample brings a new reading.
    pub mag: Option<Mag<Sensor>>,
    /// Temperature of the IMU, °C, where the sample brings one.
    pub temperature_c: Option<f32>,
    /// At least one axis reads the end of its range.
    pub saturated: bool,
    /// What others measured, where a recording holds it; a device knows nothing of it.
    pub aiding: RecordedAiding,
}

/// What others measured, as a row of a recording holds it: smaller than the measurements it makes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RecordedAiding {
    /// Speed of the vehicle.
    pub speed: Option<RecordedSpeed>,
    /// Position in the world.
    pub fix: Option<RecordedFix>,
}

impl RecordedAiding {
    /// Nothing.
    pub const NONE: Self = Self { speed: None, fix: None };
}

/// Forward speed of the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordedSpeed {
    /// m/s, backwards negative.
    pub speed_m_s: f64,
    /// 1σ, m/s, where the row says so.
    pub sigma_m_s: Option<f32>,
    /// How old it is, s.
    pub age_s: f32,
}

/// Position, and perhaps orientation, in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordedFix {
    /// m.
    pub position_m: [f64; 3],
    /// 1σ per axis, m.
    pub sigma_m: f32,
    /// How old it is, s.
    pub age_s: f32,
    /// Body to world, `x y z w`, with its 1σ per axis, rad.
    pub orientation: Option<([f32; 4], f32)>,
}
