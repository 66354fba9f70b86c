//! What is known of one camera's lane, from its health and its latest pose.

use lodestone_client::{
    CameraNameError, CameraPose, Client, HealthStream, LaneHealth, PoseStream, Status,
};
use serde::Serialize;

use super::describe::{bits, code, problems};
use super::relative::RelativeLine;

/// Follows one camera.
pub(super) struct Monitor {
    pub(super) camera: String,
    poses: PoseStream,
    health: HealthStream,
}

/// One camera at one moment; `null` stands for what is unknown.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    pub(super) camera: String,
    /// `running`, ..., or `silent` if nothing is published.
    pub(super) state: String,
    pub(super) serial: Option<u64>,
    pub(super) age_s: Option<f64>,
    pub(super) sample_rate_hz: Option<f64>,
    pub(super) pose_rate_hz: Option<f64>,
    pub(super) latency_p50_s: Option<f64>,
    pub(super) latency_p99_s: Option<f64>,
    pub(super) heading_deg: Option<f64>,
    pub(super) heading_sigma_deg: Option<f64>,
    pub(super) heading_source: Option<String>,
    pub(super) position_m: Option<[f64; 3]>,
    pub(super) position_sigma_m: Option<f64>,
    pub(super) position_source: Option<String>,
    pub(super) aids_used: Vec<String>,
    pub(super) aids_refused: Vec<String>,
    /// Epoch of the world the position is in.
    pub(super) world_epoch: Option<u32>,
    pub(super) group_delay_s: Option<f64>,
    /// Whether each member of a rigid body is in use.
    pub(super) members_in_use: Option<Vec<bool>>,
    pub(super) temperature_c: Option<f64>,
    pub(super) magnetic_norm_ut: Option<f64>,
    pub(super) status: Vec<String>,
    /// What the configuration asks of the system and the system refused.
    pub(super) real_time_refused: Option<Vec<String>>,
    pub(super) problems: Vec<String>,
    /// Samples missing from the sensor, dropped by the ring, and bridged.
    pub(super) samples_lost: Option<u64>,
    pub(super) ring_dropped: Option<u64>,
    pub(super) steps_bridged: Option<u64>,
    pub(super) reconnects: Option<u64>,
    pub(super) resets: Option<u64>,
    pub(super) publish_errors: Option<u64>,
    /// Aiding measurements used, refused by their gate, and not understood.
    pub(super) aiding_used: Option<u64>,
    pub(super) aiding_refused: Option<u64>,
    pub(super) aiding_invalid: Option<u64>,
    /// Other cameras as this one has them, those after it in the configuration.
    pub(super) relative: Vec<RelativeLine>,
    pub(super) daemon_pid: Option<u32>,
    /// Poses that this process lost, and restarts of the daemon that it saw.
    pub(super) poses_lost_here: u64,
    pub(super) restarts_seen: u64,
}

impl Monitor {
    pub(super) fn new(client: &Client, camera: &str) -> Result<Self, CameraNameError> {
        let (poses, health) = (client.poses(camera)?, client.health(camera)?);
        Ok(Self { camera: camera.into(), poses, health })
    }

    /// Whether both a pose and a health message have come.
    pub(super) fn is_complete(&mut self) -> bool {
        let pose = self.poses.latest().is_ok();
        self.health.latest().is_ok() && pose
    }

    /// Whether anything has come.
    pub(super) fn has_anything(&mut self) -> bool {
        self.poses.latest().is_ok() || self.health.latest().is_ok()
    }

    pub(super) fn report(&mut self) -> Report {
        let health = self.health.latest().ok();
        let pose = self.poses.latest().ok();
        // A lane that looks for its device publishes health but no poses.
        let alive = self.health.age().is_some_and(|age| age.as_secs() < 3);
        let fresh = !self.poses.is_stale();
        let state = match &health {
            Some(health) if alive => code(health.state()),
            _ if fresh => "running".into(),
            _ => "silent".into(),
        };
        let known = health.as_ref().filter(|_| alive);
        self.assemble(state, known, pose.as_ref(), fresh)
    }

    fn assemble(
        &self,
        state: String,
        health: Option<&LaneHealth>,
        pose: Option<&CameraPose>,
        fresh: bool,
    ) -> Report {
        let counter = |of: fn(&LaneHealth) -> u64| health.map(of);
        let pose_rate_hz = if fresh { self.measured_rate_hz() } else { Some(0.0) };
        let status = pose.map_or(Status::empty(), CameraPose::status);
        let heading = pose.and_then(CameraPose::heading);
        let counts = self.poses.counts();
        Report {
            camera: self.camera.clone(),
            problems: self.all_problems(health, status, fresh),
            state,
            serial: counter(|h| h.message().serial),
            age_s: self.poses.age().map(|age| age.as_secs_f64()),
            sample_rate_hz: health.and_then(LaneHealth::sample_rate_hz),
            pose_rate_hz: pose_rate_hz.or_else(|| health.and_then(LaneHealth::pose_rate_hz)),
            latency_p50_s: health.and_then(LaneHealth::latency_p50_s),
            latency_p99_s: health.and_then(LaneHealth::latency_p99_s),
            heading_deg: heading.map(lodestone_client::Heading::compass_deg),
            heading_sigma_deg: heading.map(|h| h.sigma_rad.to_degrees()),
            heading_source: pose.map(|pose| code(pose.heading_source())),
            position_m: pose.and_then(CameraPose::position_m).map(|p| p.to_array()),
            position_sigma_m: pose.and_then(CameraPose::position_sigma_m),
            position_source: pose.map(|pose| code(pose.position_source())),
            aids_used: bits(pose.map(CameraPose::aids_used).unwrap_or_default()),
            aids_refused: bits(pose.map(CameraPose::aids_refused).unwrap_or_default()),
            world_epoch: pose.map(CameraPose::world_epoch).filter(|&epoch| epoch > 0),
            group_delay_s: health.and_then(LaneHealth::group_delay_s),
            members_in_use: health.and_then(members_in_use),
            temperature_c: health.and_then(LaneHealth::temperature_c),
            magnetic_norm_ut: health.and_then(LaneHealth::magnetic_norm_ut),
            status: bits(status),
            real_time_refused: health.map(|h| bits(h.real_time_refused())),
            samples_lost: counter(|h| h.message().samples_lost),
            ring_dropped: counter(|h| h.message().ring_dropped),
            steps_bridged: counter(|h| h.message().steps_bridged),
            reconnects: counter(|h| h.message().reconnects),
            resets: counter(|h| h.message().resets),
            publish_errors: counter(|h| h.message().publish_errors),
            aiding_used: counter(|h| h.message().aiding_used),
            aiding_refused: counter(|h| h.message().aiding_refused),
            aiding_invalid: counter(|h| h.message().aiding_invalid),
            relative: Vec::new(),
            daemon_pid: health.map(|h| h.message().daemon_pid),
            poses_lost_here: counts.lost,
            restarts_seen: counts.restarts,
        }
    }

    /// Poses per second over the poses kept (at most the last 2.5 s at 400 Hz), by the publisher's
    /// own count and times.
    fn measured_rate_hz(&self) -> Option<f64> {
        let (oldest, newest) = (self.poses.history().oldest()?, self.poses.history().newest()?);
        let span_s = newest.time_ns().saturating_sub(oldest.time_ns()) as f64 * 1e-9;
        let poses = newest.sequence().saturating_sub(oldest.sequence());
        (span_s > 0.0).then_some(poses as f64 / span_s)
    }

    fn all_problems(
        &self,
        health: Option<&LaneHealth>,
        status: Status,
        fresh: bool,
    ) -> Vec<String> {
        let mut found = problems(health, status);
        if let Some(error) = self.poses.connection_error() {
            found.insert(0, error.to_string());
        } else if health.is_none() && !fresh {
            found.insert(0, "nobody publishes: has the daemon stopped?".into());
        }
        found
    }
}

/// Which members of a body are in use; `None` for what is no body.
fn members_in_use(health: &LaneHealth) -> Option<Vec<bool>> {
    (health.message().member_count > 0).then(|| health.members_in_use().collect())
}
