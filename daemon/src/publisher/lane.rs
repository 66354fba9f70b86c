//! What one lane publishes: poses, calibrated samples, wake-ups.

use iceoryx2::node::Node;
use iceoryx2::prelude::ipc;
use lodestone_config::model::SharedMemory;
use lodestone_schema::transport::Domain;
use lodestone_schema::{CalibratedSample, Pose, ServiceKind};

use super::port::{Port, PublisherError};
use super::wake::Waker;
use crate::lane::Publish;
use crate::reading::HostTime;
use crate::service::prefault::prefault;

/// Publishes one lane's messages; made on the lane's own thread, where it stays (it is not
/// `Send`).
///
/// ```compile_fail
/// fn needs_send<T: Send>() {}
/// needs_send::<lodestone_daemon::publisher::LanePublisher>();
/// ```
pub struct LanePublisher {
    pose: Port<Pose>,
    sample: Option<Port<CalibratedSample>>,
    waker: Option<Waker>,
    // Stays listed, under this lane's name, as long as its ports.
    _node: Node<ipc::Service>,
}

impl LanePublisher {
    /// Opens the lane's services, reserves and maps their memory, loans the first samples, and
    /// starts the wake-up thread if the configuration asks for wake-ups.
    ///
    /// # Errors
    /// [`PublisherError`]; a full `/dev/shm` is [`PublisherError::Prefault`].
    pub fn open(
        domain: &Domain,
        settings: &SharedMemory,
        camera: &str,
    ) -> Result<Self, PublisherError> {
        let node = domain.open_node(&format!("lodestoned-{camera}"))?;
        let pose = Port::open(&node, ServiceKind::Pose, camera, settings, blank_pose())?;
        let sample = settings
            .publish_samples
            .then(|| Port::open(&node, ServiceKind::Sample, camera, settings, blank_sample()))
            .transpose()?;
        let waker = settings
            .wake_events
            .then(|| Waker::start(domain, camera, settings.max_subscribers))
            .transpose()?;
        prefault(&domain.prefix)?;
        Ok(Self { pose, sample, waker, _node: node })
    }

    /// Publishes a pose with `published_time_ns` taken just before it is sent; returns that
    /// time, or `None` if it could not be sent, which is counted (see [`LanePublisher::errors`]).
    ///
    /// One copy, into shared memory.
    pub fn publish_pose(&mut self, pose: &Pose) -> Option<HostTime> {
        let mut published = HostTime::default();
        let sent = self.pose.send(pose, |slot| {
            published = HostTime::now();
            slot.published_time_ns = published.as_nanos();
        });
        if let Some(waker) = &self.waker {
            waker.poke();
        }
        sent.then_some(published)
    }

    /// Publishes a calibrated sample, where the configuration asks for them.
    pub fn publish_sample(&mut self, sample: &CalibratedSample) {
        if let Some(port) = &mut self.sample {
            port.send(sample, |_| {});
        }
    }

    /// Messages that could not be loaned, sent or notified since the start.
    pub fn errors(&self) -> u64 {
        let samples = self.sample.as_ref().map_or(0, Port::errors);
        let wakes = self.waker.as_ref().map_or(0, Waker::errors);
        self.pose.errors() + samples + wakes
    }
}

impl Publish for LanePublisher {
    fn pose(&mut self, pose: &Pose) -> Option<HostTime> {
        self.publish_pose(pose)
    }

    fn sample(&mut self, sample: &CalibratedSample) {
        self.publish_sample(sample);
    }

    fn errors(&self) -> u64 {
        self.errors()
    }
}

/// A pose of which nothing is known.
pub(crate) const fn blank_pose() -> Pose {
    Pose {
        sequence: 0,
        camera_id: 0,
        reset_counter: 0,
        status: 0,
        validity: 0,
        heading_source: 0,
        position_source: 0,
        aids_used: 0,
        aids_refused: 0,
        world_epoch: 0,
        sensor_time_ns: 0,
        time_ns: 0,
        arrival_time_ns: 0,
        ring_time_ns: 0,
        step_start_time_ns: 0,
        step_end_time_ns: 0,
        published_time_ns: 0,
        unix_offset_ns: 0,
        position_m: [f64::NAN; 3],
        velocity_m_s: [f64::NAN; 3],
        orientation: [f64::NAN; 4],
        angular_rate_rad_s: [f64::NAN; 3],
        specific_force_m_s2: [f64::NAN; 3],
        position_covariance_m2: [f64::NAN; 6],
        velocity_covariance_m2_s2: [f64::NAN; 6],
        orientation_covariance_rad2: [f64::NAN; 6],
    }
}

const fn blank_sample() -> CalibratedSample {
    CalibratedSample {
        sequence: 0,
        camera_id: 0,
        flags: 0,
        sensor_time_ns: 0,
        time_ns: 0,
        arrival_time_ns: 0,
        angular_rate_rad_s: [f64::NAN; 3],
        specific_force_m_s2: [f64::NAN; 3],
        magnetic_field_ut: [f64::NAN; 3],
        temperature_c: f64::NAN,
    }
}
