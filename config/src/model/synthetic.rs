//! The synthetic world.

use serde::{Deserialize, Serialize};

/// How the camera moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TrajectoryKind {
    /// It stands.
    Standing,
    /// It is carried through a room by hand.
    #[default]
    Walk,
    /// It is carried up a staircase and down again.
    Stairs,
    /// It rides on a model vehicle on the floor of a room.
    ModelVehicle,
    /// It rides in a car through a town, up to 80 km/h.
    Car,
    /// It is turned about the vertical and tilted to every side, for a calibration.
    Turns,
    /// It is turned through all attitudes, for a calibration.
    Tumble,
    /// It rides in a car that circles on sloping ground, for a calibration.
    Circles,
}

/// One synthetic camera. Its sensor axes are those of a ZED 2.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Synthetic {
    /// How the camera moves.
    pub trajectory: TrajectoryKind,
    /// Rest before the motion begins, s.
    pub rest_s: f64,
    /// Slope of the ground under trajectory `circles`, degrees.
    pub tilt_deg: f64,
    /// How far from the axis the camera is held in trajectories `turns` and `tumble`, m.
    pub arm_m: f64,
    /// Where the camera, or the body that it rides on, truly begins in the world, m; at
    /// [`super::Camera::start`] if absent, else at the origin.
    pub position_m: Option<[f64; 3]>,
    /// Which way it looks when it begins, clockwise from the world's y axis, degrees; drawn if absent.
    pub heading_deg: Option<f64>,
    /// Pitch of trajectory `standing`, nose down positive, degrees; drawn if absent.
    pub pitch_deg: Option<f64>,
    /// Roll of trajectory `standing`, right side down positive, degrees; drawn if absent.
    pub roll_deg: Option<f64>,
    /// How long the walker on trajectory `stairs` halts on each landing between two flights, s.
    pub halt_s: f64,
    /// Seed of everything random; the same seed gives the same samples.
    pub seed: u64,
    /// 1 is real speed; 0 as fast as it goes.
    pub speed: f64,
    /// Seconds until the source ends; 0 never.
    pub duration_s: f64,
    /// Errors of the sensors.
    pub errors: SensorErrors,
    /// What steel and magnets near the sensor do to the field.
    pub distortion: MagneticDistortion,
    /// Magnetic disturbances that come and go.
    pub disturbance: Vec<Disturbance>,
    /// Machines that turn near the camera, on the same vehicle.
    pub motor: Vec<Motor>,
    /// Devices that switch on and off near the camera, on the same vehicle.
    pub instrument: Vec<Instrument>,
    /// What happens to samples on their way.
    pub transport: Transport,
}

impl Default for Synthetic {
    /// A walk at real speed without end, after a rest that is long enough to align in.
    fn default() -> Self {
        Self {
            trajectory: TrajectoryKind::default(),
            rest_s: 3.0,
            tilt_deg: 5.0,
            arm_m: 0.3,
            position_m: None,
            heading_deg: None,
            pitch_deg: None,
            roll_deg: None,
            halt_s: 0.0,
            seed: 0,
            speed: 1.0,
            duration_s: 0.0,
            errors: SensorErrors::default(),
            distortion: MagneticDistortion::default(),
            disturbance: Vec::new(),
            motor: Vec::new(),
            instrument: Vec::new(),
            transport: Transport::default(),
        }
    }
}

/// Errors of the sensors; noise densities and random walks are the camera's noise figures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SensorErrors {
    /// Scales every noise figure; 0 is a perfect sensor, 1 the camera's.
    pub noise_scale: f64,
    /// Gyroscope bias at 25 °C in the sensor frame, rad/s; drawn from the noise figures if absent.
    pub gyro_bias_rad_s: Option<[f64; 3]>,
    /// Accelerometer bias at 25 °C in the sensor frame, m/s²; drawn if absent.
    pub accel_bias_m_s2: Option<[f64; 3]>,
    /// Gyroscope bias per kelvin, rad/s/K.
    pub gyro_temperature_rad_s_k: [f64; 3],
    /// 1/f noise of the magnetometer: its density at 1 Hz, µT/√Hz; it grows as 1/√f below.
    pub mag_flicker_ut_rthz: f64,
    /// Temperature at the start, °C.
    pub temperature_start_c: f64,
    /// Temperature it settles at, °C.
    pub temperature_end_c: f64,
    /// Time constant of the warm-up, s.
    pub temperature_time_constant_s: f64,
    /// Quantise and saturate as the ZED 2 does.
    pub quantise: bool,
}

impl Default for SensorErrors {
    fn default() -> Self {
        Self {
            noise_scale: 1.0,
            gyro_bias_rad_s: None,
            accel_bias_m_s2: None,
            gyro_temperature_rad_s_k: [0.0; 3],
            mag_flicker_ut_rthz: 0.0,
            temperature_start_c: 30.0,
            temperature_end_c: 38.0,
            temperature_time_constant_s: 300.0,
            quantise: true,
        }
    }
}

/// Constant distortion of the magnetometer: it reads `S B + h + k (T - 25 °C)`, where `B` is the
/// earth's field in the sensor frame. A calibration that undoes it has `C = S⁻¹` and `b0 = h`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MagneticDistortion {
    /// Hard iron `h` in the sensor frame, µT.
    pub hard_iron_ut: [f64; 3],
    /// Soft iron `S` in the sensor frame, row by row; identity is none.
    pub soft_iron: [[f64; 3]; 3],
    /// Hard iron `k` per kelvin away from 25 °C, µT/K.
    pub temperature_ut_k: [f64; 3],
}

impl Default for MagneticDistortion {
    fn default() -> Self {
        Self {
            hard_iron_ut: [0.0; 3],
            soft_iron: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            temperature_ut_k: [0.0; 3],
        }
    }
}

/// A field added to the earth's for a while.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Disturbance {
    /// When it begins, s after the first sample.
    pub at_s: f64,
    /// How long it lasts, s.
    pub duration_s: f64,
    /// The added field in the world frame, µT.
    pub field_ut: [f64; 3],
    /// Frequency, Hz; 0 is constant, 50 is mains hum.
    #[serde(default)]
    pub frequency_hz: f64,
}

/// The alternating field of a turning machine that moves with the camera: a vehicle's engine with
/// its alternator, or an electric motor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motor {
    /// Amplitude of the field in the body frame, µT.
    pub field_ut: [f64; 3],
    /// Frequency at standstill, Hz; an engine that idles at 800 rpm turns with 13.3 Hz.
    pub idle_hz: f64,
    /// What the camera's speed adds to the frequency, Hz per m/s.
    #[serde(default)]
    pub hz_per_m_s: f64,
}

/// The field of a device that moves with the camera and switches on and off: a blower, a display,
/// a pump.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Instrument {
    /// The field while it is on, in the body frame, µT.
    pub field_ut: [f64; 3],
    /// How long it stays on, s.
    pub on_s: f64,
    /// How long it stays off, s; 0 is always on.
    pub off_s: f64,
}

/// What happens to samples between the sensor and the lane.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Transport {
    /// Rate of the sensor against its nominal 400 Hz, minus one.
    pub rate_error: f64,
    /// Rate of the sensor's clock, which stamps the samples, against true time, minus one.
    pub clock_error: f64,
    /// Samples between two magnetometer readings; the ZED 2 has 8 (50 Hz).
    pub mag_every: u32,
    /// Probability that a sample is lost.
    pub drop_probability: f64,
    /// Jitter of the sensor's sampling instants, 1σ, s.
    pub sampling_jitter_s: f64,
    /// Mean of the (one-sided, exponential) delay between sampling and arrival, s.
    pub arrival_delay_s: f64,
}

impl Default for Transport {
    fn default() -> Self {
        Self {
            rate_error: 0.0,
            clock_error: 0.0,
            mag_every: 8,
            drop_probability: 0.0,
            sampling_jitter_s: 0.0,
            arrival_delay_s: 0.0,
        }
    }
}
