//! One camera.

use serde::{Deserialize, Serialize};

use super::{Depth, Synthetic};

/// Where a camera's samples come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DriverKind {
    /// A ZED 2 or 2i on USB, found by its serial number.
    #[default]
    Zed2,
    /// A simulated world.
    Synthetic,
    /// A recording.
    Replay,
}

/// The camera's model, which fixes the nominal rate and the default noise figures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CameraModel {
    /// ZED 2.
    #[default]
    Zed2,
    /// ZED 2i.
    Zed2i,
}

/// One camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Camera {
    /// Name in service names and tables, see [`lodestone_schema::is_camera_name`]; unique.
    pub name: String,
    /// Serial number, the one printed on the camera; unique. 0 stands for none, which only the
    /// `synthetic` and `replay` drivers allow.
    #[serde(skip_serializing_if = "is_zero")]
    pub serial: u64,
    /// Where samples come from.
    pub driver: DriverKind,
    /// Which camera it is.
    pub model: CameraModel,
    /// The rigid body that carries the camera, by the body's name; none if absent.
    pub body: Option<String>,
    /// Where the camera sits on its body.
    pub mounting: Mounting,
    /// Processor that the threads of the camera's lane stay on; any if absent.
    pub cpu: Option<u16>,
    /// Where the camera stands in the world when it is first aligned, if that is known.
    pub start: Option<Start>,
    /// The magnetometer in the camera's body axes, from the IMU, m.
    pub magnetometer_position_m: [f64; 3],
    /// The left lens in the camera's body axes, from the IMU, m; not known if absent.
    pub lens_position_m: Option<[f64; 3]>,
    /// Cut-off of a low-pass on gyroscope and accelerometer, Hz; none if absent.
    pub low_pass_hz: Option<f64>,
    /// How sensor axes become body axes; see [`Camera::axes`] for what holds without it.
    pub axis_map: Option<AxisMap>,
    /// Noise of the sensors; the model's figures if absent.
    pub noise: Option<Noise>,
    /// Age of what gyroscope and accelerometer show at their time stamp, s.
    pub imu_delay_s: f64,
    /// Calibration file, relative to this configuration's directory.
    pub calibration: Option<String>,
    /// Settings of the `synthetic` driver.
    pub synthetic: Option<Synthetic>,
    /// The depth source of a camera with the `synthetic` driver; as [`Depth::default`] if absent.
    pub depth: Option<Depth>,
    /// Settings of the `replay` driver.
    pub replay: Option<Replay>,
    /// Faults to inject between driver and ring, for tests of what depends on this daemon.
    pub fault: Vec<Fault>,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            name: String::new(),
            serial: 0,
            driver: DriverKind::default(),
            model: CameraModel::default(),
            body: None,
            mounting: Mounting::default(),
            cpu: None,
            start: None,
            magnetometer_position_m: [0.0; 3],
            lens_position_m: None,
            low_pass_hz: None,
            axis_map: None,
            noise: None,
            imu_delay_s: IMU_DELAY_S,
            calibration: None,
            synthetic: None,
            depth: None,
            replay: None,
            fault: Vec::new(),
        }
    }
}

/// Group delay of the low-pass filter in an inertial sensor that gives a few hundred samples a second.
/// One of second order with a cut-off of 40 to 100 Hz delays by 5.6 to 2.3 ms (`√2 / 2πf`); the
/// recordings of BROAD show 4 ms, each of them.
const IMU_DELAY_S: f64 = 0.004;

impl Camera {
    /// How sensor axes become body axes: as configured, else as a ZED 2 is built; a recording is
    /// taken to be in body axes.
    pub fn axes(&self) -> AxisMap {
        self.axis_map.unwrap_or(match self.driver {
            DriverKind::Zed2 | DriverKind::Synthetic => AxisMap::default(),
            DriverKind::Replay => AxisMap::IDENTITY,
        })
    }
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde calls it so")]
const fn is_zero(serial: &u64) -> bool {
    *serial == 0
}

/// Pose of the camera's own axes in the frame of the rigid body that carries it (x forward, y left,
/// z up).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Mounting {
    /// Position of the IMU, m.
    pub position_m: [f64; 3],
    /// Roll, pitch, yaw of the camera on what carries it, degrees, applied ZYX.
    pub roll_pitch_yaw_deg: [f64; 3],
    /// How well the position is known, 1σ, m, per axis.
    pub position_sigma_m: f64,
    /// How well the rotation is known, 1σ, degrees, about each axis.
    pub rotation_sigma_deg: f64,
}

impl Default for Mounting {
    /// In the body's origin, measured with a ruler and a spirit level.
    fn default() -> Self {
        Self {
            position_m: [0.0; 3],
            roll_pitch_yaw_deg: [0.0; 3],
            position_sigma_m: 0.005,
            rotation_sigma_deg: 0.5,
        }
    }
}

/// Where a camera stands in the world when it is first aligned.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Start {
    /// Position of the camera's IMU in the world: east, north, up, m.
    pub position_m: [f64; 3],
    /// How well it is known, 1σ, m, per axis.
    pub sigma_m: f64,
}

impl Default for Start {
    /// The position has no default.
    fn default() -> Self {
        Self { position_m: [0.0; 3], sigma_m: 0.02 }
    }
}

/// A sensor axis with its sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the names say it: +x is x")]
pub enum SignedAxis {
    #[serde(rename = "x")]
    PlusX,
    #[serde(rename = "-x")]
    MinusX,
    #[serde(rename = "y")]
    PlusY,
    #[serde(rename = "-y")]
    MinusY,
    #[serde(rename = "z")]
    PlusZ,
    #[serde(rename = "-z")]
    MinusZ,
}

/// Which sensor axis each body axis (forward, left, up) is; a right-handed map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct AxisMap(pub [SignedAxis; 3]);

impl AxisMap {
    /// The sensor's axes are the body's.
    pub const IDENTITY: Self = Self([SignedAxis::PlusX, SignedAxis::PlusY, SignedAxis::PlusZ]);

    /// Unit vectors that point forward, left and up, in sensor axes: the rows of the matrix that
    /// turns sensor coordinates into body coordinates.
    pub fn directions(self) -> [[f64; 3]; 3] {
        self.0.map(SignedAxis::direction)
    }
}

impl SignedAxis {
    /// The unit vector along this axis.
    pub const fn direction(self) -> [f64; 3] {
        match self {
            Self::PlusX => [1.0, 0.0, 0.0],
            Self::MinusX => [-1.0, 0.0, 0.0],
            Self::PlusY => [0.0, 1.0, 0.0],
            Self::MinusY => [0.0, -1.0, 0.0],
            Self::PlusZ => [0.0, 0.0, 1.0],
            Self::MinusZ => [0.0, 0.0, -1.0],
        }
    }
}

impl Default for AxisMap {
    /// The ZED 2: sensor x down, y left, z forward.
    fn default() -> Self {
        Self([SignedAxis::PlusZ, SignedAxis::PlusY, SignedAxis::MinusX])
    }
}

/// Noise of one camera's sensors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Noise {
    /// Gyroscope noise density, rad/s/√Hz.
    pub gyro_density_rad_s_rthz: f64,
    /// Gyroscope bias random walk, rad/s²/√Hz.
    pub gyro_bias_walk_rad_s2_rthz: f64,
    /// Gyroscope bias at switch-on, 1σ, rad/s.
    pub gyro_bias_sigma_rad_s: f64,
    /// Accelerometer noise density, m/s²/√Hz.
    pub accel_density_m_s2_rthz: f64,
    /// Accelerometer bias random walk, m/s³/√Hz.
    pub accel_bias_walk_m_s3_rthz: f64,
    /// Accelerometer bias at switch-on, 1σ, m/s².
    pub accel_bias_sigma_m_s2: f64,
    /// Magnetometer noise of one reading, 1σ, µT.
    pub mag_sigma_ut: f64,
}

impl CameraModel {
    /// Samples per second the IMU means to deliver. Real cameras were seen at 358 to 412 Hz, so a
    /// lane measures the rate and takes this one only as the first guess.
    pub const fn nominal_rate_hz(self) -> f64 {
        match self {
            Self::Zed2 | Self::Zed2i => 400.0,
        }
    }

    /// The default noise figures of the model.
    pub const fn noise(self) -> Noise {
        match self {
            // Stereolabs' published Allan figures of the ZED 2 family; the 2i has the same IMU. The
            // biases at switch-on are those that a factory calibration leaves.
            Self::Zed2 | Self::Zed2i => Noise {
                gyro_density_rad_s_rthz: 1.22e-4,
                gyro_bias_walk_rad_s2_rthz: 1.0e-5,
                gyro_bias_sigma_rad_s: 5.0e-3,
                accel_density_m_s2_rthz: 1.6e-3,
                accel_bias_walk_m_s3_rthz: 2.5e-4,
                accel_bias_sigma_m_s2: 0.05,
                mag_sigma_ut: 0.5,
            },
        }
    }
}

/// Settings of the `replay` driver.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Replay {
    /// The recording, `.csv` or `.csv.zst`, relative to this configuration's directory.
    pub file: String,
    /// 1 is real speed, 2 twice as fast; 0 as fast as it goes.
    pub speed: f64,
    /// Begin again at the end.
    pub repeat: bool,
}

impl Default for Replay {
    /// Real speed, once; the file has no default.
    fn default() -> Self {
        Self { file: String::new(), speed: 1.0, repeat: false }
    }
}

/// What a fault does to the stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FaultKind {
    /// Samples vanish.
    Drop,
    /// Every sample comes twice.
    Duplicate,
    /// Time stamps run backwards.
    TimeBackwards,
    /// Every value repeats the first one.
    Stuck,
    /// Values are not a number.
    NotANumber,
    /// Values are infinite.
    Infinite,
    /// Values are at the end of the range.
    Saturated,
    /// Values are huge but finite.
    Huge,
    /// The source is lost and comes back.
    Unplug,
    /// Samples come late, in one burst.
    Stall,
    /// The magnetometer is silent.
    NoMagnetometer,
    /// Neighbouring samples change places.
    Reorder,
}

/// One fault, by the stream's own time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// What happens.
    pub kind: FaultKind,
    /// When it begins, s after the first sample.
    pub at_s: f64,
    /// How long it lasts, s.
    pub duration_s: f64,
}
