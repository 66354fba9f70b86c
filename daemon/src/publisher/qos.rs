//! Qualities of service that follow from the configuration.

use lodestone_config::model::SharedMemory;
use lodestone_schema::transport::Qos;
use lodestone_schema::{
    CalibratedSample, Health, Pose, Relative, ServiceKind, StaticTransform, World,
};

/// Messages one consumer may hold at a time; the client copies out and holds one.
pub const MAX_BORROWED: usize = 4;

/// Truth is for displays and tests: two thirds of a second at 100 Hz.
const TRUTH_HISTORY: usize = 64;

/// Aiding measurements that a lane may be behind by: a quarter of a second of several sources.
const AIDING_HISTORY: usize = 64;

/// Requests that housekeeping may be behind by.
const REQUESTS: usize = 8;

/// Processes that aid one lane, or ask the daemon for something, at a time.
const MAX_WRITERS: usize = 16;

/// The late joiner gets this many pairs, or edges of the tree of frames: every pair of 11 cameras; what
/// is published again within a second.
const WORLD_HISTORY: usize = 64;

/// The qualities of a service.
pub fn qos_of(kind: ServiceKind, settings: &SharedMemory) -> Qos {
    let history = match kind {
        ServiceKind::Pose | ServiceKind::Sample => settings.pose_history,
        ServiceKind::Truth => TRUTH_HISTORY,
        ServiceKind::Health | ServiceKind::World | ServiceKind::Wake | ServiceKind::Cloud => 1,
        ServiceKind::Aiding => AIDING_HISTORY,
        ServiceKind::Relative | ServiceKind::Transforms => WORLD_HISTORY,
        ServiceKind::Request => REQUESTS,
    };
    let max_publishers = match kind {
        ServiceKind::Aiding | ServiceKind::Request => MAX_WRITERS,
        // A second publisher lets a bridge mirror the service from another host.
        _ => 2,
    };
    let max_subscribers = settings.max_subscribers;
    Qos { history, max_subscribers, max_publishers, max_borrowed: MAX_BORROWED }
}

/// Size of one message of this kind, bytes; 0 for events and for what others publish.
pub const fn sample_bytes(kind: ServiceKind) -> usize {
    match kind {
        ServiceKind::Pose | ServiceKind::Truth => size_of::<Pose>(),
        ServiceKind::Sample => size_of::<CalibratedSample>(),
        ServiceKind::Health => size_of::<Health>(),
        ServiceKind::World => size_of::<World>(),
        ServiceKind::Relative => size_of::<Relative>(),
        ServiceKind::Transforms => size_of::<StaticTransform>(),
        ServiceKind::Aiding | ServiceKind::Wake | ServiceKind::Request | ServiceKind::Cloud => 0,
    }
}
