//! The latest status of a lane, as words.

use lodestone_schema::{Pose, Status, Validity};

/// Number of 64-bit words of a [`LaneStatus`].
pub(super) const WORDS: usize = 22;

/// What the lane read from the sensors beside the pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorStatus {
    /// Temperature of the IMU, °C; `NaN` when unknown.
    pub temperature_c: f64,
    /// Norm of the last magnetometer reading, µT; `NaN` when unknown.
    pub magnetic_norm_ut: f64,
    /// Rate of the sensor clock against `CLOCK_MONOTONIC`, minus one; `NaN` when unknown.
    pub clock_drift: f64,
}

/// The latest pose, as far as health and display need it, and the latest sensor status.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaneStatus {
    /// Time of validity of the pose, `CLOCK_MONOTONIC`, ns; 0 before the first pose.
    pub time_ns: i64,
    /// Time of validity of the pose on the sensor's clock, ns.
    pub sensor_time_ns: i64,
    /// What the lane says about the pose.
    pub status: Status,
    /// Which fields hold usable values.
    pub validity: Validity,
    /// Code of [`lodestone_schema::HeadingSource`].
    pub heading_source: u8,
    /// Code of [`lodestone_schema::PositionSource`].
    pub position_source: u8,
    /// Bits of [`lodestone_schema::AidFlags`]: what corrected the pose lately.
    pub aids_used: u8,
    /// Bits of [`lodestone_schema::AidFlags`]: what was refused lately.
    pub aids_refused: u8,
    /// Epoch of the world; 0 while there is none.
    pub world_epoch: u32,
    /// Body origin in the world, m; `NaN` when unknown.
    pub position_m: [f64; 3],
    /// Variance of the position per axis, m²; `NaN` when unknown.
    pub position_variance_m2: [f64; 3],
    /// Rotation body to world, `x y z w`; `NaN` when unknown.
    pub orientation: [f64; 4],
    /// Variance of the orientation about the world's axes, rad²; `NaN` when unknown.
    pub orientation_variance_rad2: [f64; 3],
    /// The sensors.
    pub sensor: SensorStatus,
}

impl Default for SensorStatus {
    fn default() -> Self {
        Self { temperature_c: f64::NAN, magnetic_norm_ut: f64::NAN, clock_drift: f64::NAN }
    }
}

impl Default for LaneStatus {
    fn default() -> Self {
        Self {
            time_ns: 0,
            sensor_time_ns: 0,
            status: Status::empty(),
            validity: Validity::empty(),
            heading_source: 0,
            position_source: 0,
            aids_used: 0,
            aids_refused: 0,
            world_epoch: 0,
            position_m: [f64::NAN; 3],
            position_variance_m2: [f64::NAN; 3],
            orientation: [f64::NAN; 4],
            orientation_variance_rad2: [f64::NAN; 3],
            sensor: SensorStatus::default(),
        }
    }
}

impl LaneStatus {
    /// What a pose says, and the sensors beside it.
    pub const fn of(pose: &Pose, sensor: SensorStatus) -> Self {
        let p = &pose.position_covariance_m2;
        let q = &pose.orientation_covariance_rad2;
        Self {
            time_ns: pose.time_ns,
            sensor_time_ns: pose.sensor_time_ns,
            status: Status::from_bits_retain(pose.status),
            validity: Validity::from_bits_retain(pose.validity),
            heading_source: pose.heading_source,
            position_source: pose.position_source,
            aids_used: pose.aids_used,
            aids_refused: pose.aids_refused,
            world_epoch: pose.world_epoch,
            position_m: pose.position_m,
            // The diagonal of xx xy xz yy yz zz.
            position_variance_m2: [p[0], p[3], p[5]],
            orientation: pose.orientation,
            orientation_variance_rad2: [q[0], q[3], q[5]],
            sensor,
        }
    }

    /// Heading of the body's forward axis, rad clockwise from the world's north, 0 to 2π; `NaN`
    /// when unknown.
    pub fn heading_rad(&self) -> f64 {
        let [x, y, z, w] = self.orientation;
        // The first column of the rotation matrix: where the body's x axis points, east and north.
        let east = 1.0 - 2.0 * (y * y + z * z);
        let north = 2.0 * (x * y + w * z);
        east.atan2(north).rem_euclid(core::f64::consts::TAU)
    }

    /// Standard deviation of the heading, rad; `NaN` when unknown.
    pub fn heading_sigma_rad(&self) -> f64 {
        self.orientation_variance_rad2[2].sqrt()
    }

    /// Roll (about the forward axis) and pitch (about the left axis, nose down positive), rad.
    pub fn roll_pitch_rad(&self) -> (f64, f64) {
        let [x, y, z, w] = self.orientation;
        let roll = (2.0 * (w * x + y * z)).atan2(1.0 - 2.0 * (x * x + y * y));
        let pitch = (2.0 * (w * y - z * x)).clamp(-1.0, 1.0).asin();
        (roll, pitch)
    }

    /// Standard deviation of the position, the largest of the three axes, m; `NaN` when unknown.
    pub fn position_sigma_m(&self) -> f64 {
        let [x, y, z] = self.position_variance_m2;
        // f64::max would pass over an axis that is unknown.
        if (x + y + z).is_nan() { f64::NAN } else { x.max(y).max(z).sqrt() }
    }

    const fn codes(&self) -> [u8; 4] {
        [self.heading_source, self.position_source, self.aids_used, self.aids_refused]
    }

    pub(super) fn to_words(self) -> [u64; WORDS] {
        let [px, py, pz] = self.position_m.map(f64::to_bits);
        let [vx, vy, vz] = self.position_variance_m2.map(f64::to_bits);
        let [qx, qy, qz, qw] = self.orientation.map(f64::to_bits);
        let [rx, ry, rz] = self.orientation_variance_rad2.map(f64::to_bits);
        [
            self.time_ns.cast_unsigned(),
            self.status.bits().into(),
            self.validity.bits().into(),
            u32::from_le_bytes(self.codes()).into(),
            self.world_epoch.into(),
            px,
            py,
            pz,
            vx,
            vy,
            vz,
            qx,
            qy,
            qz,
            qw,
            rx,
            ry,
            rz,
            self.sensor.temperature_c.to_bits(),
            self.sensor.magnetic_norm_ut.to_bits(),
            self.sensor.clock_drift.to_bits(),
            self.sensor_time_ns.cast_unsigned(),
        ]
    }

    pub(super) fn from_words(words: &[u64; WORDS]) -> Self {
        let number = |at: usize| f64::from_bits(words[at]);
        let three = |at: usize| [number(at), number(at + 1), number(at + 2)];
        let [heading_source, position_source, aids_used, aids_refused] =
            (words[3] as u32).to_le_bytes();
        Self {
            time_ns: words[0].cast_signed(),
            sensor_time_ns: words[21].cast_signed(),
            status: Status::from_bits_retain(words[1] as u32),
            validity: Validity::from_bits_retain(words[2] as u32),
            heading_source,
            position_source,
            aids_used,
            aids_refused,
            world_epoch: words[4] as u32,
            position_m: three(5),
            position_variance_m2: three(8),
            orientation: [number(11), number(12), number(13), number(14)],
            orientation_variance_rad2: three(15),
            sensor: SensorStatus {
                temperature_c: number(18),
                magnetic_norm_ut: number(19),
                clock_drift: number(20),
            },
        }
    }
}
