//! The health message.

use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::flags::code;
use crate::layout::assert_layout;

code! {
    /// What a lane is doing.
    LaneState {
        /// Looking for the device.
        Searching = 0,
        /// Samples arrive; the initial alignment waits for rest.
        Aligning = 1,
        /// Poses are published.
        Running = 2,
        /// Poses are published, something is wrong (see the flags and counters).
        Degraded = 3,
        /// The device is gone or silent; the lane waits for it.
        Lost = 4,
        /// The source ended (a recording) or the lane was stopped.
        Ended = 5,
    }
}

code! {
    /// Why the initial alignment is not done.
    AlignmentWait {
        /// It is done, or there are no samples.
        None = 0,
        /// Not enough samples at rest yet.
        Collecting = 1,
        /// The camera turns.
        Turning = 2,
        /// The camera shakes.
        Shaking = 3,
        /// The specific force is not gravity.
        NotGravity = 4,
        /// The camera turns steadily, or the gyroscope's bias is beyond belief.
        SteadyTurn = 5,
    }
}

impl AlignmentWait {
    /// What a person should know or do.
    pub const fn advice(self) -> &'static str {
        match self {
            Self::None => "",
            Self::Collecting => "collecting samples at rest",
            Self::Turning => "the camera turns: hold it still",
            Self::Shaking => "the camera shakes: hold it still",
            Self::NotGravity => {
                "the specific force is not gravity: check accelerometer and axis map"
            }
            Self::SteadyTurn => "the camera turns steadily: hold it still",
        }
    }
}

code! {
    /// Why the last measurement against another camera, its anchor, was not used.
    AnchorRefusal {
        /// It was used, or there was none.
        None = 0,
        /// There is no camera of that index.
        Unknown = 1,
        /// It is the camera itself.
        Itself = 2,
        /// The anchor publishes no pose.
        Silent = 3,
        /// The anchor is in another world, or the world is not fixed yet.
        OtherWorld = 4,
        /// The anchor's heading or position is not known.
        NotKnown = 5,
        /// The anchor was itself measured against this camera, directly or through others.
        Loop = 6,
        /// The camera is one of a rig's.
        OfRig = 7,
        /// Only a pose can be measured against a camera.
        NoPose = 8,
    }
}

impl AnchorRefusal {
    /// What a person should know or do.
    pub const fn advice(self) -> &'static str {
        match self {
            Self::None => "",
            Self::Unknown => "there is no camera of the index that is named as anchor",
            Self::Itself => "a camera is no anchor of its own",
            Self::Silent => "the anchor publishes no pose",
            Self::OtherWorld => "the anchor is in another world, or the world is not fixed yet",
            Self::NotKnown => "the anchor's heading or position is not known",
            Self::Loop => {
                "the anchor was itself measured against this camera: let one of the two be the anchor"
            }
            Self::OfRig => "the camera is one of a rig's, whose place on it is configured",
            Self::NoPose => "only a pose can be measured against a camera",
        }
    }
}

/// State and counters of one lane, published about once a second by the housekeeping thread.
///
/// Counters start at 0 with the daemon and never decrease.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("lodestone.v2.Health")]
pub struct Health {
    /// Counts the health messages of this lane from 0.
    pub sequence: u64,
    /// Index of the camera in the daemon's configuration; bodies count on after the cameras.
    pub camera_id: u32,
    /// Number of cameras in the daemon's configuration.
    pub camera_count: u32,
    /// Serial number of the camera.
    pub serial: u64,
    /// When this message was made, `CLOCK_MONOTONIC`, ns.
    pub time_ns: i64,
    /// When the daemon started, `CLOCK_MONOTONIC`, ns.
    pub daemon_start_time_ns: i64,
    /// Process id of the daemon.
    pub daemon_pid: u32,
    /// Bits of [`crate::Status`] of the latest pose.
    pub status: u32,
    /// Bits of [`crate::Validity`] of the latest pose.
    pub validity: u32,
    /// Code of [`LaneState`].
    pub state: u8,
    /// Code of [`crate::HeadingSource`] of the latest pose.
    pub heading_source: u8,
    /// Code of [`crate::PositionSource`] of the latest pose.
    pub position_source: u8,
    /// Code of [`AlignmentWait`]: why a lane that aligns has no pose yet.
    pub alignment_wait: u8,
    /// Bits of [`crate::AidFlags`]: what corrected the latest pose within its last second.
    pub aids_used: u8,
    /// Bits of [`crate::AidFlags`]: what was refused by its gate within that second.
    pub aids_refused: u8,
    /// Cameras that a rigid body carries; 0 for a camera of its own.
    pub member_count: u8,
    /// Code of [`AnchorRefusal`].
    pub anchor_refusal: u8,
    /// Epoch of the world of the latest pose; 0 while there is none.
    pub world_epoch: u32,
    /// Samples per second over the last interval; `NaN` before the first.
    pub sample_rate_hz: f64,
    /// Poses per second over the last interval; `NaN` before the first.
    pub pose_rate_hz: f64,
    /// Median of arrival to published over the last interval, s; `NaN` without poses.
    pub latency_p50_s: f64,
    /// 99th percentile of arrival to published over the last interval, s; `NaN` without poses.
    pub latency_p99_s: f64,
    /// Temperature of the IMU, °C; `NaN` when unknown.
    pub temperature_c: f64,
    /// Standard deviation of the heading, rad; `NaN` before the alignment.
    pub heading_sigma_rad: f64,
    /// Norm of the last magnetometer reading, µT; `NaN` when unknown.
    pub magnetic_norm_ut: f64,
    /// Estimated rate of the sensor clock against `CLOCK_MONOTONIC`, minus one; `NaN` when unknown.
    pub clock_drift: f64,
    /// Samples taken from the driver.
    pub samples: u64,
    /// Poses published.
    pub poses: u64,
    /// Samples pushed out of the full ring, oldest first.
    pub ring_dropped: u64,
    /// Samples missing by the sensor's time stamps.
    pub samples_lost: u64,
    /// Grid steps bridged over lost samples.
    pub steps_bridged: u64,
    /// Samples with a time stamp already seen.
    pub duplicates: u64,
    /// Samples whose time stamp ran backwards.
    pub out_of_order: u64,
    /// Samples refused: not finite, out of range, or unreadable.
    pub invalid: u64,
    /// Times the device was lost and opened again.
    pub reconnects: u64,
    /// Re-initialisations of the filter.
    pub resets: u64,
    /// Messages the transport refused.
    pub publish_errors: u64,
    /// Aiding measurements that corrected the filter.
    pub aiding_used: u64,
    /// Aiding measurements refused by their gate, or too late.
    pub aiding_refused: u64,
    /// Aiding measurements that make no sense: not finite, unknown code, of the future.
    pub aiding_invalid: u64,
    /// One bit for each member of a rigid body in use, the first in bit 0; 0 for a camera of its own.
    pub members_in_use: u32,
    /// Bits of [`crate::RealTimeFlags`]: what the configuration asks for and the system refused.
    pub real_time_refused: u8,
    /// Zero.
    pub reserved: [u8; 3],
    /// Delay of the low-pass, which the pose has made up for, s; 0 without one, `NaN` when unknown.
    pub group_delay_s: f64,
}

assert_layout!(
    Health,
    size = 256,
    sequence = 0,
    camera_id = 8,
    camera_count = 12,
    serial = 16,
    time_ns = 24,
    daemon_start_time_ns = 32,
    daemon_pid = 40,
    status = 44,
    validity = 48,
    state = 52,
    heading_source = 53,
    position_source = 54,
    alignment_wait = 55,
    aids_used = 56,
    aids_refused = 57,
    member_count = 58,
    anchor_refusal = 59,
    world_epoch = 60,
    sample_rate_hz = 64,
    pose_rate_hz = 72,
    latency_p50_s = 80,
    latency_p99_s = 88,
    temperature_c = 96,
    heading_sigma_rad = 104,
    magnetic_norm_ut = 112,
    clock_drift = 120,
    samples = 128,
    poses = 136,
    ring_dropped = 144,
    samples_lost = 152,
    steps_bridged = 160,
    duplicates = 168,
    out_of_order = 176,
    invalid = 184,
    reconnects = 192,
    resets = 200,
    publish_errors = 208,
    aiding_used = 216,
    aiding_refused = 224,
    aiding_invalid = 232,
    members_in_use = 240,
    real_time_refused = 244,
    reserved = 245,
    group_delay_s = 248,
);
