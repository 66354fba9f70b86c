//! Qualities of service that follow from the configuration.

use lodestone_config::model::SharedMemory;
use lodestone_schema::transport::Qos;
use lodestone_schema::{CalibratedSample, Health, Pose, ServiceKind};

/// Messages one consumer may hold at a time; the client copies out and holds one.
pub const MAX_BORROWED: usize = 4;

/// Truth is for displays and tests: two thirds of a second at 100 Hz.
const TRUTH_HISTORY: usize = 64;

/// The qualities of a service.
pub fn qos_of(kind: ServiceKind, settings: &SharedMemory) -> Qos {
    let history = match kind {
        ServiceKind::Pose | ServiceKind::Sample => settings.pose_history,
        ServiceKind::Truth => TRUTH_HISTORY,
        ServiceKind::Health | ServiceKind::Aiding | ServiceKind::Wake => 1,
    };
    Qos { history, max_subscribers: settings.max_subscribers, max_borrowed: MAX_BORROWED }
}

/// Size of one message of this kind, bytes; 0 for events and for what others publish.
pub const fn sample_bytes(kind: ServiceKind) -> usize {
    match kind {
        ServiceKind::Pose | ServiceKind::Truth => size_of::<Pose>(),
        ServiceKind::Sample => size_of::<CalibratedSample>(),
        ServiceKind::Health => size_of::<Health>(),
        ServiceKind::Aiding | ServiceKind::Wake => 0,
    }
}
