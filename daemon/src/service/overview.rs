//! The state of all lanes as housekeeping last saw it, for the console and the log.

use std::sync::{Arc, Mutex, PoisonError};

use lodestone_config::model::{Camera, Config, DriverKind};
use lodestone_schema::{AlignmentWait, Health, LaneState};

use crate::lane::low_pass_of;
use crate::publisher::blank_health;
use crate::reading::HostTime;
use crate::realtime::Roster;
use crate::status_board::{LaneBoard, LaneStatus};

/// One lane: its name, its board, and the intervals over which rates are taken.
#[derive(Debug)]
pub struct LaneMonitor {
    name: String,
    board: Arc<LaneBoard>,
    health: Health,
    since: HostTime,
}

/// One lane at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct LaneView {
    /// The camera's name.
    pub name: String,
    /// What the lane is doing now.
    pub state: LaneState,
    /// Why it has no pose yet.
    pub alignment_wait: AlignmentWait,
    /// Rates, latencies and counters of the last whole interval.
    pub health: Health,
    /// The latest pose.
    pub status: LaneStatus,
}

/// The lanes' latest views; shared by cloning. Lanes never touch it.
#[derive(Clone, Debug, Default)]
pub struct Overview(Arc<Mutex<Vec<LaneView>>>);

impl Overview {
    /// The latest views, in the order of the configuration.
    pub fn views(&self) -> Vec<LaneView> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Replaces the views.
    pub fn set(&self, views: Vec<LaneView>) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = views;
    }
}

/// Of the camera's low-pass, s; `NaN` for a recording, whose rate tells it only in the lane.
fn group_delay_s(camera: &Camera) -> f64 {
    match (camera.low_pass_hz, camera.driver) {
        (None, _) => 0.0,
        (Some(_), DriverKind::Replay) => f64::NAN,
        (Some(_), _) => low_pass_of(camera, camera.model.nominal_rate_hz())
            .map_or(f64::NAN, |filter| filter.map_or(0.0, |f| f.group_delay_s())),
    }
}

/// Cameras of the body that is published under an index; 0 for a camera.
fn member_count(config: &Config, published: usize) -> u8 {
    let rigs = config.rigs();
    let rig = rigs.iter().find(|rig| config.camera.len() + rig.body == published);
    rig.map_or(0, |rig| rig.members.len() as u8)
}

impl LaneMonitor {
    /// Begins to watch the lane of one camera of the configuration.
    pub fn new(config: &Config, camera: usize, board: Arc<LaneBoard>, start: HostTime) -> Self {
        let (name, serial) = config.published_as(camera);
        let health = Health {
            camera_id: camera as u32,
            camera_count: config.camera.len() as u32,
            serial,
            daemon_start_time_ns: start.as_nanos(),
            daemon_pid: std::process::id(),
            member_count: member_count(config, camera),
            group_delay_s: config.camera.get(camera).map_or(f64::NAN, group_delay_s),
            ..blank_health()
        };
        Self { name: name.to_owned(), board, health, since: start }
    }

    /// Ends an interval: takes rates, latencies and counters, and returns the message to publish.
    ///
    /// `side_errors` are failures of the services that housekeeping publishes for this lane.
    pub fn end_interval(&mut self, now: HostTime, side_errors: u64) -> Health {
        let seconds = (now.as_nanos() - self.since.as_nanos()) as f64 * 1e-9;
        let latency = self.board.latency.take();
        let counted = self.board.counter_values();
        let rate = |new: u64, old: u64| {
            if seconds > 0.0 { new.saturating_sub(old) as f64 / seconds } else { f64::NAN }
        };
        let health = &mut self.health;
        // A body has no samples of its own.
        let has_samples = health.member_count == 0;
        let sample_rate_hz = rate(counted.samples, health.samples);
        health.sample_rate_hz = if has_samples { sample_rate_hz } else { f64::NAN };
        health.pose_rate_hz = rate(counted.poses, health.poses);
        counted.fill(health);
        health.publish_errors += side_errors;
        health.latency_p50_s = latency.p50_s;
        health.latency_p99_s = latency.p99_s;
        self.since = now;
        self.fill_latest(now);
        let message = self.health;
        self.health.sequence += 1;
        message
    }

    /// The lane now, with rates and latencies of the last whole interval.
    pub fn view(&self) -> LaneView {
        LaneView {
            name: self.name.clone(),
            state: self.state(),
            alignment_wait: self.board.alignment_wait(),
            health: self.health,
            status: self.board.latest.read(),
        }
    }

    /// Poses without what the configuration asks of the system may be late, so they are degraded.
    fn state(&self) -> LaneState {
        match self.board.state() {
            LaneState::Running if !self.board.roster.refused().is_empty() => LaneState::Degraded,
            state => state,
        }
    }

    /// The lane's threads, for housekeeping.
    pub(super) fn roster(&self) -> &Roster {
        &self.board.roster
    }

    fn fill_latest(&mut self, now: HostTime) {
        let (latest, state) = (self.board.latest.read(), self.state());
        let health = &mut self.health;
        health.time_ns = now.as_nanos();
        health.real_time_refused = self.board.roster.refused().bits();
        health.state = state.code();
        health.alignment_wait = self.board.alignment_wait().code();
        health.anchor_refusal = self.board.anchor_refusal().code();
        health.members_in_use = self.board.members_in_use();
        health.status = latest.status.bits();
        health.validity = latest.validity.bits();
        health.heading_source = latest.heading_source;
        health.position_source = latest.position_source;
        health.aids_used = latest.aids_used;
        health.aids_refused = latest.aids_refused;
        health.world_epoch = latest.world_epoch;
        health.temperature_c = latest.sensor.temperature_c;
        health.magnetic_norm_ut = latest.sensor.magnetic_norm_ut;
        health.clock_drift = latest.sensor.clock_drift;
        health.heading_sigma_rad = latest.heading_sigma_rad();
    }
}

#[cfg(test)]
mod tests {
    use lodestone_config::model::Camera;

    use super::*;

    fn at(seconds: f64) -> HostTime {
        HostTime::from_nanos((seconds * 1e9) as i64)
    }

    #[test]
    fn rates_and_latencies_are_those_of_the_interval_and_counters_those_since_the_start() {
        let camera = Camera { name: "front".into(), serial: 42, ..Camera::default() };
        let config = Config { camera: vec![camera], ..Config::default() };
        let board = Arc::new(LaneBoard::new());
        let mut monitor = LaneMonitor::new(&config, 0, Arc::clone(&board), at(10.0));

        board.counters.samples.add(800);
        board.counters.poses.add(400);
        (0..400).for_each(|_| board.latency.record(20_000));
        let first = monitor.end_interval(at(12.0), 3);
        board.counters.samples.add(100);
        let second = monitor.end_interval(at(13.0), 3);

        assert_eq!((first.sequence, second.sequence), (0, 1));
        assert_eq!((first.serial, first.camera_count), (42, 1));
        assert!((first.sample_rate_hz - 400.0).abs() < 1e-9);
        assert!((first.pose_rate_hz - 200.0).abs() < 1e-9);
        assert!((first.latency_p50_s - 20e-6).abs() < 0.1e-6);
        assert_eq!(first.publish_errors, 3);
        assert!((second.sample_rate_hz - 100.0).abs() < 1e-9);
        assert!(second.latency_p50_s.is_nan());
        assert_eq!((second.samples, second.poses), (900, 400));
    }
}
