//! Every key of a camera.

use super::Kind::{Axes, Choice, Number, SoftIron, Switch, Text, Vector, Whole};
use super::range::{above_zero_to, from_to, plus_minus};
use super::realtime::CAMERA_CPU;
use super::text::Text::{CalibrationFile, CameraName, Recording};
use super::{Key, key};

/// A thousand hours, s: longer than any run that is planned by the second.
const LONGEST_S: f64 = 3_600_000.0;

pub(super) const CAMERA: &[Key] = &[
    key(
        "name",
        Text(CameraName),
        "",
        "Name in service names and tables, different for each camera.",
    )
    .required(),
    key(
        "serial",
        Whole(1, i64::MAX),
        "",
        "Serial number as printed on the camera, different for each; driver \"zed2\" finds the \
         camera by it, and a calibration file is bound to it.",
    ),
    key(
        "driver",
        Choice(&["zed2", "synthetic", "replay"]),
        "",
        "Where samples come from: a ZED 2 or 2i on USB, a simulated world, a recording.",
    ),
    key("model", Choice(&["zed2", "zed2i"]), "", "Which camera it is; fixes the default noise."),
    key(
        "body",
        Text(CameraName),
        "",
        "Name of the body (a table headed [[body]]) that carries the camera; without it the camera \
         moves for itself.",
    ),
    CAMERA_CPU,
    key(
        "magnetometer_position_m",
        Vector(plus_minus(1.0)),
        "m",
        "Position of the magnetometer, from the IMU in the camera's body axes (forward, left, up). \
         The world's origin is at that of the first camera, and on a rig it counts for the field's \
         gradient.",
    ),
    key(
        "lens_position_m",
        Vector(plus_minus(1.0)),
        "m",
        "Position of the left lens, from the IMU in the camera's body axes. Without it the \
         translation from body to optical frame is published as not known.",
    ),
    key(
        "low_pass_hz",
        Number(from_to(5.0, 500.0)),
        "Hz",
        "Cut-off of a low-pass of second order (Butterworth) on gyroscope and accelerometer, below \
         half the sample rate; none if absent. Small: less vibration, and poses are carried ahead \
         over a longer delay, 0.225 / low_pass_hz seconds. Large: hardly any effect.",
    ),
    key(
        "axis_map",
        Axes,
        "",
        "Sensor axes that point forward, left and up; default: those of a ZED 2, and \
         [\"x\", \"y\", \"z\"] for driver \"replay\". To check it on a level camera: the \
         accelerometer reads +9.81 m/s² on the third, and tilting the nose down makes the first \
         negative.",
    ),
    key(
        "imu_delay_s",
        Number(from_to(0.0, 0.05)),
        "s",
        "Age of what gyroscope and accelerometer show at their time stamp: the group delay of \
         their low-pass filter. Poses are carried ahead by it. Too small: poses lag while the \
         camera turns; too large: they lead.",
    ),
    key(
        "calibration",
        Text(CalibrationFile),
        "",
        "Calibration file, relative to this file's directory. Without one the magnetometer is \
         taken as it comes, which on a vehicle can turn the heading by tens of degrees.",
    ),
];

pub(super) const MOUNTING: &[Key] = &[
    key("position_m", Vector(plus_minus(100.0)), "m", "Position of the camera's IMU."),
    key(
        "roll_pitch_yaw_deg",
        Vector(plus_minus(360.0)),
        "°",
        "Roll about x, pitch about y, yaw about z of the body in the vehicle, applied ZYX. \
         Positive pitch is nose down, positive yaw is to the left.",
    ),
    key(
        "position_sigma_m",
        Number(from_to(0.0, 10.0)),
        "m",
        "How well the position is known, 1σ, per axis.",
    ),
    key(
        "rotation_sigma_deg",
        Number(from_to(0.0, 180.0)),
        "°",
        "How well the rotation is known, 1σ, about each axis.",
    ),
];

pub(super) const START: &[Key] = &[
    key(
        "position_m",
        Vector(plus_minus(1e5)),
        "m",
        "Position of the camera's IMU in the world (east, north, up) when it is first aligned.",
    )
    .required(),
    key("sigma_m", Number(from_to(0.0, 1e4)), "m", "How well it is known, 1σ, per axis."),
];

pub(super) const NOISE: &[Key] = &[
    key(
        "gyro_density_rad_s_rthz",
        Number(above_zero_to(0.1)),
        "rad/s/√Hz",
        "Gyroscope noise density. Small: attitude trusts the gyroscope and follows gravity \
         slowly.",
    )
    .required(),
    key(
        "gyro_bias_walk_rad_s2_rthz",
        Number(above_zero_to(0.01)),
        "rad/s²/√Hz",
        "Random walk of the gyroscope's bias. Large: the bias follows temperature faster, and \
         noise too.",
    )
    .required(),
    key(
        "gyro_bias_sigma_rad_s",
        Number(above_zero_to(1.0)),
        "rad/s",
        "Gyroscope bias at switch-on, 1σ.",
    )
    .required(),
    key(
        "accel_density_m_s2_rthz",
        Number(above_zero_to(1.0)),
        "m/s²/√Hz",
        "Accelerometer noise density.",
    )
    .required(),
    key(
        "accel_bias_walk_m_s3_rthz",
        Number(above_zero_to(0.1)),
        "m/s³/√Hz",
        "Random walk of the accelerometer's bias.",
    )
    .required(),
    key(
        "accel_bias_sigma_m_s2",
        Number(above_zero_to(10.0)),
        "m/s²",
        "Accelerometer bias at switch-on, 1σ.",
    )
    .required(),
    key(
        "mag_sigma_ut",
        Number(above_zero_to(100.0)),
        "µT",
        "Noise of one magnetometer reading, 1σ. Small: the heading follows every reading. \
         Large: it leans on the gyroscope.",
    )
    .required(),
];

pub(super) const SYNTHETIC: &[Key] = &[
    key(
        "trajectory",
        Choice(&[
            "standing",
            "walk",
            "stairs",
            "model-vehicle",
            "car",
            "turns",
            "tumble",
            "circles",
        ]),
        "",
        "How the camera moves: not at all, by hand through a room, up and down a staircase, on a \
         model vehicle on the floor, in a car through a town at up to 80 km/h; or turned for a \
         calibration: tilted about the vertical, through all attitudes, or in a car that \
         circles on sloping ground.",
    ),
    key(
        "rest_s",
        Number(from_to(0.0, 3600.0)),
        "s",
        "Rest before the motion begins. Shorter than estimator.alignment_rest_s: the filter \
         cannot align until the camera rests again.",
    ),
    key(
        "tilt_deg",
        Number(from_to(0.0, 45.0)),
        "°",
        "Slope of the ground under trajectory \"circles\". Below some 2° a calibration is \
         refused; streets have up to 7°, ramps up to 9°.",
    ),
    key(
        "arm_m",
        Number(from_to(0.0, 10.0)),
        "m",
        "How far from the axis the camera is held in trajectories \"turns\" and \"tumble\". Long: \
         what presses it outward passes for a bias of the accelerometer.",
    ),
    key(
        "position_m",
        Vector(plus_minus(1e4)),
        "m",
        "Where it truly begins in the world (east, north, up), or the body that it rides on; at \
         camera.start if absent, else at the origin. The daemon does not know it: that is camera.start. \
         The first camera begins at the origin.",
    ),
    key(
        "heading_deg",
        Number(plus_minus(360.0)),
        "°",
        "Which way it looks when it begins, clockwise from the world's y axis; its way turns along. \
         Drawn from the seed if absent.",
    ),
    key(
        "pitch_deg",
        Number(plus_minus(89.0)),
        "°",
        "Pitch of a camera with trajectory \"standing\", nose down positive; some degrees, drawn from \
         the seed, if absent.",
    ),
    key(
        "roll_deg",
        Number(plus_minus(180.0)),
        "°",
        "Roll of a camera with trajectory \"standing\", right side down positive; some degrees, drawn \
         from the seed, if absent.",
    ),
    key(
        "halt_s",
        Number(from_to(0.0, 3600.0)),
        "s",
        "How long the walker on trajectory \"stairs\" halts on each landing between two flights; 0 walks \
         on. The filter learns its velocity anew at each halt of a second or so.",
    ),
    key(
        "seed",
        Whole(0, i64::MAX),
        "",
        "Seed of everything random; the same seed gives the same samples.",
    ),
    key("speed", Number(from_to(0.0, 1000.0)), "", "1 is real speed; 0 as fast as it goes."),
    key("duration_s", Number(from_to(0.0, LONGEST_S)), "s", "When the source ends; 0 never."),
];

pub(super) const ERRORS: &[Key] = &[
    key(
        "noise_scale",
        Number(from_to(0.0, 100.0)),
        "",
        "Scales every noise figure: 0 a perfect sensor, 1 the camera's.",
    ),
    key(
        "gyro_bias_rad_s",
        Vector(plus_minus(1.0)),
        "rad/s",
        "Gyroscope bias at 25 °C in the sensor frame; drawn from the noise figures if absent.",
    ),
    key(
        "accel_bias_m_s2",
        Vector(plus_minus(10.0)),
        "m/s²",
        "Accelerometer bias at 25 °C in the sensor frame; drawn from the noise figures if absent.",
    ),
    key(
        "gyro_temperature_rad_s_k",
        Vector(plus_minus(0.1)),
        "rad/s/K",
        "Gyroscope bias per kelvin, in the sensor frame.",
    ),
    key(
        "mag_flicker_ut_rthz",
        Number(from_to(0.0, 100.0)),
        "µT/√Hz",
        "1/f noise of the magnetometer: its density at 1 Hz, which grows as 1/√f below. Comes on \
         top of camera.noise.mag_sigma_ut.",
    ),
    key(
        "temperature_start_c",
        Number(from_to(-40.0, 85.0)),
        "°C",
        "Temperature of the sensor at the start.",
    ),
    key("temperature_end_c", Number(from_to(-40.0, 85.0)), "°C", "Temperature it settles at."),
    key(
        "temperature_time_constant_s",
        Number(above_zero_to(LONGEST_S)),
        "s",
        "Time constant of the warm-up.",
    ),
    key("quantise", Switch, "", "Quantise and saturate as a ZED 2 does."),
];

pub(super) const DISTORTION: &[Key] = &[
    key("hard_iron_ut", Vector(plus_minus(1000.0)), "µT", "Hard iron in the sensor frame."),
    key(
        "soft_iron",
        SoftIron(plus_minus(10.0)),
        "",
        "Soft iron in the sensor frame, row by row; identity is none.",
    ),
    key(
        "temperature_ut_k",
        Vector(plus_minus(10.0)),
        "µT/K",
        "Hard iron per kelvin away from 25 °C, in the sensor frame.",
    ),
];

pub(super) const DISTURBANCE: &[Key] = &[
    key("at_s", Number(from_to(0.0, LONGEST_S)), "s", "When it begins, after the first sample.")
        .required(),
    key("duration_s", Number(above_zero_to(LONGEST_S)), "s", "How long it lasts.").required(),
    key("field_ut", Vector(plus_minus(1000.0)), "µT", "The added field in the world frame.")
        .required(),
    key(
        "frequency_hz",
        Number(from_to(0.0, 1000.0)),
        "Hz",
        "Frequency of the added field: 0 is constant, 50 mains hum.",
    ),
];

pub(super) const MOTOR: &[Key] = &[
    key("field_ut", Vector(plus_minus(1000.0)), "µT", "Amplitude of the field, in the body frame.")
        .required(),
    key(
        "idle_hz",
        Number(from_to(0.0, 1000.0)),
        "Hz",
        "Frequency at standstill; an engine that idles at 800 rpm turns with 13.3 Hz.",
    )
    .required(),
    key(
        "hz_per_m_s",
        Number(from_to(0.0, 1000.0)),
        "Hz/(m/s)",
        "What the camera's speed adds to the frequency.",
    ),
];

pub(super) const INSTRUMENT: &[Key] = &[
    key(
        "field_ut",
        Vector(plus_minus(1000.0)),
        "µT",
        "The field while it is on, in the body frame.",
    )
    .required(),
    key("on_s", Number(above_zero_to(LONGEST_S)), "s", "How long it stays on.").required(),
    key("off_s", Number(from_to(0.0, LONGEST_S)), "s", "How long it stays off; 0: always on.")
        .required(),
];

pub(super) const TRANSPORT: &[Key] = &[
    key(
        "rate_error",
        Number(plus_minus(0.2)),
        "",
        "Rate of the sensor against its nominal 400 Hz, minus one; 0.01 is 404 Hz.",
    ),
    key(
        "clock_error",
        Number(plus_minus(0.03)),
        "",
        "Rate of the sensor's clock, which stamps the samples, against true time, minus one.",
    ),
    key(
        "mag_every",
        Whole(1, 4000),
        "samples",
        "Samples between two magnetometer readings; a ZED 2 has 8, which is 50 Hz.",
    ),
    key("drop_probability", Number(from_to(0.0, 0.99)), "", "Probability that a sample is lost."),
    key(
        "sampling_jitter_s",
        Number(from_to(0.0, 0.1)),
        "s",
        "Jitter of the sensor's sampling instants, 1σ.",
    ),
    key(
        "arrival_delay_s",
        Number(from_to(0.0, 1.0)),
        "s",
        "Mean of the one-sided, exponential delay between sampling and arrival.",
    ),
];

pub(super) const REPLAY: &[Key] = &[
    key("file", Text(Recording), "", "The recording, relative to this file's directory.")
        .required(),
    key(
        "speed",
        Number(from_to(0.0, 1000.0)),
        "",
        "1 is real speed, 2 twice as fast, 0 as fast as it goes.",
    ),
    key("repeat", Switch, "", "Begin again at the end."),
];

pub(super) const FAULT: &[Key] = &[
    key(
        "kind",
        Choice(&[
            "drop",
            "duplicate",
            "time-backwards",
            "stuck",
            "not-a-number",
            "infinite",
            "saturated",
            "huge",
            "unplug",
            "stall",
            "no-magnetometer",
            "reorder",
        ]),
        "",
        "What happens to the samples: they vanish, come twice, carry time stamps that run \
         backwards, repeat one value, are not a number, infinite, at the end of the range, or \
         huge; the source is lost and comes back; they come late in one burst, without \
         magnetometer, or in swapped order.",
    )
    .required(),
    key("at_s", Number(from_to(0.0, LONGEST_S)), "s", "When it begins, after the first sample.")
        .required(),
    key("duration_s", Number(above_zero_to(LONGEST_S)), "s", "How long it lasts.").required(),
];
