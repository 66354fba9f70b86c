//! The side of whoever merges.

use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::thread::{self, JoinHandle};

use core::time::Duration;

use glam::DVec3;

use super::report::RefineReport;
use super::settings::RefineSettings;
use super::worker::{Accepted, Outcome, Worker, movement};
use crate::frame::World;
use crate::merge::{PlacedCloud, VoxelMapError};
use crate::pose::CameraPose;
use crate::registration::PoseEstimate;
use crate::transform::Transform;

/// Clouds that wait for the thread; when it is behind, others are not offered to it.
const WAITING: usize = 4;

/// Why there is no refinement.
#[derive(Debug, thiserror::Error)]
pub enum RefineError {
    /// The anchor is none of the cameras.
    #[error("the anchor has index {anchor}; there are {cameras} cameras")]
    NoAnchor {
        /// Its index.
        anchor: usize,
        /// How many cameras there are.
        cameras: usize,
    },
    /// The maps cannot be made.
    #[error(transparent)]
    Map(#[from] VoxelMapError),
    /// The thread cannot be started.
    #[error("cannot start the thread that registers clouds: {0}")]
    Thread(#[from] std::io::Error),
}

/// Where a cloud goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Placement {
    /// Into the map, moved by this.
    Insert(Transform<World, World>),
    /// Nowhere: its camera's first registration is waited for.
    Hold,
}

/// An accepted registration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CloudFix {
    /// Index of the camera.
    pub camera: usize,
    /// Time of the cloud, `CLOCK_MONOTONIC`, ns.
    pub time_ns: i64,
    /// Its camera's pose against the map of the anchor, by the geometry alone.
    pub estimate: PoseEstimate,
}

/// Decides for each cloud of a merger where it goes; see [the module](super).
#[derive(Debug)]
pub struct CloudRefiner {
    settings: RefineSettings,
    cameras: Vec<Camera>,
    clouds: Option<SyncSender<PlacedCloud>>,
    outcomes: Receiver<Outcome>,
    thread: Option<JoinHandle<()>>,
    fixes: Vec<CloudFix>,
}

#[derive(Clone, Debug, Default)]
struct Camera {
    report: RefineReport,
    /// Epoch of the world and re-initialisations of the lane that the rest is of.
    run: Option<(u32, u32)>,
    first_ns: Option<i64>,
    offered_ns: Option<i64>,
    accepted_ns: Option<i64>,
}

impl CloudRefiner {
    /// For so many cameras, as a merger counts them.
    ///
    /// # Errors
    /// [`RefineError`].
    pub fn new(cameras: usize, settings: RefineSettings) -> Result<Self, RefineError> {
        let anchor = settings.anchor;
        if anchor >= cameras {
            return Err(RefineError::NoAnchor { anchor, cameras });
        }
        let worker = Worker::new(cameras, settings)?;
        let (clouds, to_take) = sync_channel(WAITING);
        let (found, outcomes) = channel();
        let thread = thread::Builder::new()
            .name("registration".into())
            .spawn(move || worker.run(&to_take, &found))?;
        Ok(Self {
            settings,
            cameras: vec![Camera::default(); cameras],
            clouds: Some(clouds),
            outcomes,
            thread: Some(thread),
            fixes: Vec::new(),
        })
    }

    /// Where a cloud goes. Takes what the thread has found meanwhile, and offers it the cloud if it is time;
    /// never waits.
    ///
    /// # Panics
    /// If there is no such camera.
    pub fn place(&mut self, cloud: &PlacedCloud) -> Placement {
        while let Ok(outcome) = self.outcomes.try_recv() {
            self.learn(outcome);
        }
        self.cameras[cloud.camera()].follow(cloud.pose());
        self.offer(cloud);
        if cloud.camera() == self.settings.anchor {
            return Placement::Insert(Transform::IDENTITY);
        }
        let (settings, now_ns) = (self.settings, cloud.info().time_ns());
        let camera = &mut self.cameras[cloud.camera()];
        camera.drop_what_is_over(cloud.pose(), &settings, now_ns);
        camera.placement(cloud.pose(), &settings, now_ns)
    }

    /// What became of a camera's registrations.
    ///
    /// # Panics
    /// If there is no such camera.
    pub fn report(&self, camera: usize) -> &RefineReport {
        &self.cameras[camera].report
    }

    /// Registrations that were accepted since this was last asked.
    pub fn take_fixes(&mut self) -> Vec<CloudFix> {
        core::mem::take(&mut self.fixes)
    }

    fn learn(&mut self, Outcome { camera, time_ns, result }: Outcome) {
        let state = &mut self.cameras[camera];
        match result {
            Ok(Accepted { fix, correction, statistics }) => {
                state.report.accepted += 1;
                state.report.last = Some(statistics);
                state.report.correction = Some(correction);
                state.accepted_ns = Some(time_ns);
                self.fixes.push(CloudFix { camera, time_ns, estimate: fix });
            }
            Err(why) => {
                tracing::debug!(camera, %why, "registration refused");
                state.report.refused.count(&why);
                state.report.last_refusal = Some(why);
            }
        }
    }

    fn offer(&mut self, cloud: &PlacedCloud) {
        let camera = &mut self.cameras[cloud.camera()];
        let (every, now_ns) = (self.settings.remember_every, cloud.info().time_ns());
        let Some(clouds) = &self.clouds else { return };
        let is_due = camera.offered_ns.is_none_or(|then| is_past(then, now_ns, every));
        if is_due && clouds.try_send(cloud.thinned(self.settings.points)).is_ok() {
            camera.offered_ns = Some(now_ns);
        }
    }
}

impl Drop for CloudRefiner {
    fn drop(&mut self) {
        // Without a sender the thread ends after the clouds that wait.
        self.clouds = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Camera {
    /// Begins anew where the pose did.
    fn follow(&mut self, pose: &CameraPose) {
        let run = (pose.world_epoch(), pose.reset_counter());
        if self.run.replace(run).is_some_and(|before| before != run) {
            (self.report.correction, self.accepted_ns, self.first_ns) = (None, None, None);
        }
    }

    fn drop_what_is_over(&mut self, pose: &CameraPose, settings: &RefineSettings, now_ns: i64) {
        use lodestone_schema::AidFlags;
        if self.accepted_ns.is_some_and(|then| is_past(then, now_ns, settings.expiry)) {
            (self.report.correction, self.accepted_ns) = (None, None);
        }
        // The pose has taken the fix in: to apply it to the cloud as well would be once too often.
        let is_in_pose = settings.aids && pose.aids_used().contains(AidFlags::POSE_FIX);
        if is_in_pose && self.report.correction.is_some() {
            self.report.correction = Some((DVec3::ZERO, DVec3::ZERO));
        }
    }

    fn placement(
        &mut self,
        pose: &CameraPose,
        settings: &RefineSettings,
        now_ns: i64,
    ) -> Placement {
        if let (Some(correction), Some(body_m)) = (self.report.correction, pose.position_m()) {
            return Placement::Insert(movement(body_m, correction));
        }
        let first_ns = *self.first_ns.get_or_insert(now_ns);
        if is_past(first_ns, now_ns, settings.patience) {
            self.report.unrefined += 1;
            return Placement::Insert(Transform::IDENTITY);
        }
        self.report.held += 1;
        Placement::Hold
    }
}

fn is_past(then_ns: i64, now_ns: i64, after: Duration) -> bool {
    let passed = now_ns.saturating_sub(then_ns);
    u128::try_from(passed).is_ok_and(|passed| passed >= after.as_nanos())
}
