//! The tables of a configuration, and every key that is not a camera's.

use super::Kind::{Choice, Number, Switch, Text, Vector, Whole};
use super::body::BODY;
use super::camera::{
    CAMERA, DISTORTION, DISTURBANCE, ERRORS, FAULT, INSTRUMENT, MOTOR, MOUNTING, NOISE, REPLAY,
    START, SYNTHETIC, TRANSPORT,
};
use super::depth::DEPTH;
use super::range::{above_zero_to, from_to, plus_minus};
use super::realtime::REALTIME;
use super::scene::{BOX, CYLINDER, MOVER, ROOM};
use super::text::Text::{Directory, Prefix, WorldFile};
use super::{Key, Schema, Section, Shape, key};

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
            path: "world.steel",
            shape: Shape::List,
            meaning: "A piece of magnetised steel in the simulated world, as a dipole that stands still.",
            keys: STEEL,
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
            path: "realtime",
            shape: Shape::Table,
            meaning: "How the threads of the lanes run. What the system refuses is said in the log and in \
                      each camera's health, which then is degraded; the lanes run on without it.",
            keys: REALTIME,
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
        Section { path: "scene", shape: Shape::Optional, meaning: "", keys: &[] },
        Section {
            path: "scene.room",
            shape: Shape::Table,
            meaning: "The room that depth sources of synthetic cameras see (lodestoned depth), from inside. \
                      Places in the scene are in the world, x east, y north, z up, with its origin where \
                      the first camera begins. Without any table that begins with scene there is none.",
            keys: ROOM,
        },
        Section {
            path: "scene.box",
            shape: Shape::List,
            meaning: "A piece of furniture with flat sides, inside the room.",
            keys: BOX,
        },
        Section {
            path: "scene.cylinder",
            shape: Shape::List,
            meaning: "An upright cylinder inside the room: a column, a bin.",
            keys: CYLINDER,
        },
        Section {
            path: "scene.mover",
            shape: Shape::Optional,
            meaning: "Something that moves round an ellipse in the room; where it is depends on \
                      CLOCK_MONOTONIC alone, so that all depth sources see it in one place.",
            keys: MOVER,
        },
        Section {
            path: "body",
            shape: Shape::List,
            meaning: "A rigid body that carries cameras: a vehicle, or a rig. Cameras name it at \
                      camera.body; those with the same body never move against each other.",
            keys: BODY,
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
            meaning: "Pose of the camera's own axes (x forward, y left, z up) in the frame of the \
                      body that carries it (camera.body), or of the vehicle.",
            keys: MOUNTING,
        },
        Section {
            path: "camera.start",
            shape: Shape::Optional,
            meaning: "Where the camera stands in the world when it is first aligned. The first camera \
                      needs none: the world's origin is at its magnetometer. Without it the position \
                      of any other camera is not known until a fix tells.",
            keys: START,
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
            path: "camera.synthetic.motor",
            shape: Shape::List,
            meaning: "A machine that turns near the camera, on the same vehicle.",
            keys: MOTOR,
        },
        Section {
            path: "camera.synthetic.instrument",
            shape: Shape::List,
            meaning: "A device that switches on and off near the camera, on the same vehicle.",
            keys: INSTRUMENT,
        },
        Section {
            path: "camera.synthetic.transport",
            shape: Shape::Table,
            meaning: "What happens to samples between sensor and lane.",
            keys: TRANSPORT,
        },
        Section {
            path: "camera.depth",
            shape: Shape::Optional,
            meaning: "The depth source of a camera with driver \"synthetic\": what lodestoned depth \
                      publishes. Without it the defaults hold.",
            keys: DEPTH,
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
    key(
        "keep",
        Text(WorldFile),
        "",
        "File in which the world and the cameras' positions in it are kept from one run to the \
         next, relative to this file's directory. Without it each run has a world of its own.",
    ),
    key(
        "moved_sigma_m",
        Number(from_to(0.0, 1e5)),
        "m",
        "How far a camera may have been moved while the daemon did not run, 1σ, per axis: so \
         uncertain is the position with which it goes on.",
    ),
    key(
        "unseen_speed_m_s",
        Number(from_to(0.0, 100.0)),
        "m/s",
        "Speed with which a camera may have been moved while it was unplugged or its filter began \
         anew, 1σ, beside the speed it had. Large: its position is the less certain afterwards.",
    ),
    key(
        "patience_s",
        Number(from_to(0.0, 3600.0)),
        "s",
        "How long the first camera is waited for before the next one that is aligned fixes the \
         world in its stead.",
    ),
];

const STEEL: &[Key] = &[
    key(
        "position_m",
        Vector(plus_minus(10_000.0)),
        "m",
        "Where it stands in the world; where simulated cameras and bodies begin says \
         camera.synthetic.position_m.",
    )
    .required(),
    key(
        "moment_a_m2",
        Vector(plus_minus(1e6)),
        "A m²",
        "Its dipole moment. A steel door or pillar has some hundred, a car a thousand; two metres from \
         100 A m² the field is off by 2.5 µT and changes by 4 µT/m.",
    )
    .required(),
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
        "Raise an iceoryx2 event with every pose, for consumers that want a wake-up. A thread \
         beside the lanes raises it; the lane does not wait.",
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
        Choice(&["one", "two", "timed"]),
        "",
        "Driver and loop on one thread, without a hand-over to wait for, or on two, so that a \
         slow step never delays a read. The loop of \"two\" is woken by the driver; that of \
         \"timed\" sleeps until just before the next sample is due and then looks, which wants a \
         processor of its own. Rigs read each camera on a thread of its own, whatever this says.",
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
        "preset",
        Choice(&["carried", "foot"]),
        "",
        "What carries the sensor: a vehicle or a hand, or a foot. On a foot every stance counts as \
         standstill for the velocity; noise figures (unless camera.noise is given) and alignment are a \
         foot's, and alignment_rest_s and alignment_motion_s do not count.",
    ),
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
    key(
        "alignment_motion_s",
        Number(from_to(0.0, 60.0)),
        "s",
        "Time after which a camera that does not come to rest is aligned coarsely, to some degrees; \
         0 never. Small: a sudden start tilts it. Large: waits longer.",
    ),
    key(
        "hard_iron_refinement",
        Switch,
        "",
        "Whether a magnet that was mounted on the camera or moved since the calibration is learnt \
         while running, once the camera has turned: from 3.5 µT, up to 30 µT.",
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
