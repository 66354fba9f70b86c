//! What the housekeeping thread publishes: health, and the truth of synthetic worlds.

use iceoryx2::node::Node;
use iceoryx2::prelude::ipc;
use lodestone_config::model::SharedMemory;
use lodestone_schema::{AlignmentWait, Health, LaneState, Pose, ServiceKind};

use super::lane::blank_pose;
use super::port::{Port, PublisherError};
use crate::reading::HostTime;

/// Publishes one lane's health.
pub struct HealthPublisher(Port<Health>);

/// Publishes the true pose of one synthetic camera.
pub struct TruthPublisher(Port<Pose>);

impl HealthPublisher {
    /// Opens the service on a node of the calling thread.
    ///
    /// # Errors
    /// [`PublisherError`].
    pub fn open(
        node: &Node<ipc::Service>,
        settings: &SharedMemory,
        camera: &str,
    ) -> Result<Self, PublisherError> {
        Port::open(node, ServiceKind::Health, camera, settings, blank_health()).map(Self)
    }

    /// Publishes; a failure is counted.
    pub fn publish(&mut self, health: &Health) {
        self.0.send(health, |_| {});
    }

    /// Messages that could not be loaned or sent.
    pub const fn errors(&self) -> u64 {
        self.0.errors()
    }
}

impl TruthPublisher {
    /// Opens the service on a node of the calling thread.
    ///
    /// # Errors
    /// [`PublisherError`].
    pub fn open(
        node: &Node<ipc::Service>,
        settings: &SharedMemory,
        camera: &str,
    ) -> Result<Self, PublisherError> {
        Port::open(node, ServiceKind::Truth, camera, settings, blank_pose()).map(Self)
    }

    /// Publishes, with `published_time_ns` set; a failure is counted.
    pub fn publish(&mut self, truth: &Pose) {
        self.0.send(truth, |slot| slot.published_time_ns = HostTime::now().as_nanos());
    }

    /// Messages that could not be loaned or sent.
    pub const fn errors(&self) -> u64 {
        self.0.errors()
    }
}

/// The health of a lane of which nothing is known.
#[expect(clippy::too_many_lines, reason = "a line for each field")]
pub(crate) const fn blank_health() -> Health {
    Health {
        sequence: 0,
        camera_id: 0,
        camera_count: 0,
        serial: 0,
        time_ns: 0,
        daemon_start_time_ns: 0,
        daemon_pid: 0,
        status: 0,
        validity: 0,
        state: LaneState::Searching.code(),
        heading_source: 0,
        position_source: 0,
        alignment_wait: AlignmentWait::None.code(),
        aids_used: 0,
        aids_refused: 0,
        member_count: 0,
        anchor_refusal: 0,
        world_epoch: 0,
        sample_rate_hz: f64::NAN,
        pose_rate_hz: f64::NAN,
        latency_p50_s: f64::NAN,
        latency_p99_s: f64::NAN,
        temperature_c: f64::NAN,
        heading_sigma_rad: f64::NAN,
        magnetic_norm_ut: f64::NAN,
        clock_drift: f64::NAN,
        samples: 0,
        poses: 0,
        ring_dropped: 0,
        samples_lost: 0,
        steps_bridged: 0,
        duplicates: 0,
        out_of_order: 0,
        invalid: 0,
        reconnects: 0,
        resets: 0,
        publish_errors: 0,
        aiding_used: 0,
        aiding_refused: 0,
        aiding_invalid: 0,
        members_in_use: 0,
        real_time_refused: 0,
        reserved: [0; 3],
        group_delay_s: f64::NAN,
    }
}
