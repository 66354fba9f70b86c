//! Every key of a configuration.

use super::Kind::{Axes, Choice, Number, SoftIron, Switch, Text, Vector, Whole};
use super::range::{above_zero_to, from_to, plus_minus};
use super::text::Text::{CalibrationFile, CameraName, Directory, Prefix, Recording};
use super::{Key, Schema, Section, Shape, key};

/// A thousand hours, s: longer than any run that is planned by the second.
const LONGEST_S: f64 = 3_600_000.0;

/// The configuration file.
pub(crate) static CONFIG: Schema = Schema {
    sections: &[
        Section { path: "", shape: Shape::Root, meaning: "", keys: &[] },
        Section {
            path: "world",
            shape: Shape::Table,
            meaning: "The world frame (x east, y north, z up) and the place that fixes the earth's \
                      field in it.",
            keys: WORLD,
        },
        Section {
            path: "shared_memory",
            shape: Shape::Table,
            meaning: "How poses lie in shared memory. Consumers need the same prefix and root.",
            keys: SHARED_MEMORY,
        },
        Section {
            path: "lane",
            shape: Shape::Table,
            meaning: "How each camera's lane runs, from driver to publisher.",
            keys: LANE,
        },
        Section {
            path: "estimator",
            shape: Shape::Table,
            meaning: "The filter, with the same parameters for all cameras.",
            keys: ESTIMATOR,
        },
        Section {
            path: "estimator.validity",
            shape: Shape::Table,
            meaning: "Bounds of standard deviations: a value above its bound is published without \
                      its validity flag.",
            keys: VALIDITY,
        },
        Section {
            path: "camera",
            shape: Shape::List,
            meaning: "One camera; at least one is needed.",
            keys: CAMERA,
        },
        Section {
            path: "camera.mounting",
            shape: Shape::Table,
            meaning: "Pose of the camera's body frame in the vehicle frame (x forward, y left, z \
                      up).",
            keys: MOUNTING,
        },
        Section {
            path: "camera.noise",
            shape: Shape::Optional,
            meaning: "Noise of the sensors, all keys or none. Without it the figures of \
                      camera.model hold, which are shown here as defaults.",
            keys: NOISE,
        },
        Section {
            path: "camera.synthetic",
            shape: Shape::Optional,
            meaning: "The simulated world of a camera with driver \"synthetic\".",
            keys: SYNTHETIC,
        },
        Section {
            path: "camera.synthetic.errors",
            shape: Shape::Table,
            meaning: "Errors of the simulated sensors. Noise and random walks are those of \
                      camera.noise.",
            keys: ERRORS,
        },
        Section {
            path: "camera.synthetic.distortion",
            shape: Shape::Table,
            meaning: "What steel and magnets that move with the sensor do to the field.",
            keys: DISTORTION,
        },
        Section {
            path: "camera.synthetic.disturbance",
            shape: Shape::List,
            meaning: "A field that is added to the earth's for a while.",
            keys: DISTURBANCE,
        },
        Section {
            path: "camera.synthetic.transport",
            shape: Shape::Table,
            meaning: "What happens to samples between sensor and lane.",
            keys: TRANSPORT,
        },
        Section {
            path: "camera.replay",
            shape: Shape::Optional,
            meaning: "The recording of a camera with driver \"replay\".",
            keys: REPLAY,
        },
        Section {
            path: "camera.fault",
            shape: Shape::List,
            meaning: "A fault to inject between driver and ring, to test what depends on the \
                      poses.",
            keys: FAULT,
        },
    ],
};

const WORLD: &[Key] = &[
    key(
        "north",
        Choice(&["magnetic", "true"]),
        "",
        "Which north the world's y axis points to; true north by the declination of the World \
         Magnetic Model at this place and date.",
    ),
    key("latitude_deg", Number(plus_minus(90.0)), "°", "Geodetic latitude, north positive."),
    key("longitude_deg", Number(plus_minus(180.0)), "°", "Longitude, east positive."),
    key(
        "altitude_m",
        Number(from_to(-1000.0, 20_000.0)),
        "m",
        "Height above the WGS 84 ellipsoid; 1 km changes the field by 0.05 %.",
    ),
    key(
        "year",
        Number(from_to(2020.0, 2030.0)),
        "a",
        "Decimal year for the World Magnetic Model (2026.5 is mid-2026); today if absent. Set it \
         where runs must repeat bit by bit.",
    ),
];

const SHARED_MEMORY: &[Key] = &[
    key("prefix", Text(Prefix), "", "First part of the name of every file that iceoryx2 makes."),
    key(
        "root",
        Text(Directory),
        "",
        "Directory of iceoryx2's service and node files. Not under /tmp: cleaners delete them \
         there, and running consumers are cut off.",
    ),
    key(
        "pose_history",
        Whole(1, 16_384),
        "poses",
        "Poses that a late or slow consumer still finds, and how far back a lookup reaches. \
         Small: an image that is processed late finds no pose. Large: memory, and joining \
         consumers cost the publisher time.",
    ),
    key(
        "max_subscribers",
        Whole(1, 64),
        "",
        "Most consumers of one camera's poses at a time. Each may hold a whole history, so \
         memory grows with it.",
    ),
    key(
        "wake_events",
        Switch,
        "",
        "Raise an iceoryx2 event with every pose, for consumers that want a wake-up. It costs \
         the lane tens of microseconds a step.",
    ),
    key("publish_samples", Switch, "", "Publish calibrated sensor samples beside the poses."),
];

const LANE: &[Key] = &[
    key(
        "step_rate_hz",
        Number(from_to(10.0, 2000.0)),
        "Hz",
        "Steps per second of the time grid; the source's nominal rate if absent. Small: less \
         processor time, but fast turns are smoothed. Large: interpolated steps without news.",
    ),
    key(
        "ring_capacity",
        Whole(16, 65_536),
        "samples",
        "Samples the ring holds before the oldest is dropped. Small: a stall of the loop costs \
         samples. Large: after a stall the lane works through old samples first.",
    ),
    key(
        "threads",
        Choice(&["one", "two"]),
        "",
        "Driver and loop on one thread, without a hand-over to wait for, or on two, so that a \
         slow step never delays a read.",
    ),
    key(
        "bridge_limit_s",
        Number(above_zero_to(10.0)),
        "s",
        "Longest gap between samples that is bridged by interpolation. Small: short gaps already \
         degrade the pose. Large: poses over a gap are guesses.",
    ),
    key(
        "stale_after_s",
        Number(above_zero_to(10.0)),
        "s",
        "Silence of the source after which poses are marked stale.",
    ),
    key(
        "reset_after_s",
        Number(above_zero_to(60.0)),
        "s",
        "Gap after which the filter starts anew and the reset counter goes up.",
    ),
];

const ESTIMATOR: &[Key] = &[
    key(
        "heading",
        Choice(&["continuous", "adaptive", "initial-only"]),
        "",
        "How the magnetometer steers the heading: every reading counts; readings that do not fit \
         are refused until they fit again; or only the initial alignment uses it.",
    ),
    key(
        "alignment_rest_s",
        Number(from_to(0.1, 60.0)),
        "s",
        "Rest needed before the initial alignment. Small: starts sooner, with a worse gyroscope \
         bias. Large: waits longer for a vehicle that idles.",
    ),
];

const VALIDITY: &[Key] = &[
    key("tilt_sigma_deg", Number(above_zero_to(180.0)), "°", "Bound of roll and pitch."),
    key("heading_sigma_deg", Number(above_zero_to(180.0)), "°", "Bound of the heading."),
    key("velocity_sigma_m_s", Number(above_zero_to(1e3)), "m/s", "Bound of velocity, per axis."),
    key(
        "position_sigma_m",
        Number(above_zero_to(1e6)),
        "m",
        "Bound of position, per axis. Unaided position is lost within seconds to minutes; a \
         large bound keeps showing it.",
    ),
];

const CAMERA: &[Key] = &[
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
        "axis_map",
        Axes,
        "",
        "Sensor axes that point forward, left and up. To check it on a level camera: the \
         accelerometer reads +9.81 m/s² on the third, and tilting the nose down makes the first \
         negative.",
    ),
    key(
        "calibration",
        Text(CalibrationFile),
        "",
        "Calibration file, relative to this file's directory. Without one the magnetometer is \
         taken as it comes, which on a vehicle can turn the heading by tens of degrees.",
    ),
];

const MOUNTING: &[Key] = &[
    key("position_m", Vector(plus_minus(100.0)), "m", "Position of the camera's IMU."),
    key(
        "roll_pitch_yaw_deg",
        Vector(plus_minus(360.0)),
        "°",
        "Roll about x, pitch about y, yaw about z of the body in the vehicle, applied ZYX. \
         Positive pitch is nose down, positive yaw is to the left.",
    ),
];

const NOISE: &[Key] = &[
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

const SYNTHETIC: &[Key] = &[
    key(
        "trajectory",
        Choice(&["standing", "walk", "stairs", "model-vehicle", "car"]),
        "",
        "How the camera moves: not at all, by hand through a room, up and down a staircase, on a \
         model vehicle on the floor, or in a car through a town at up to 80 km/h.",
    ),
    key(
        "rest_s",
        Number(from_to(0.0, 3600.0)),
        "s",
        "Rest before the motion begins. Shorter than estimator.alignment_rest_s: the filter \
         cannot align until the camera rests again.",
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

const ERRORS: &[Key] = &[
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

const DISTORTION: &[Key] = &[
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

const DISTURBANCE: &[Key] = &[
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

const TRANSPORT: &[Key] = &[
    key(
        "rate_error",
        Number(plus_minus(0.2)),
        "",
        "Rate of the sensor against its nominal 400 Hz, minus one; 0.01 is 404 Hz.",
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

const REPLAY: &[Key] = &[
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

const FAULT: &[Key] = &[
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
