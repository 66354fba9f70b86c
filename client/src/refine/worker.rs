//! The thread that remembers and registers.

use std::sync::mpsc::{Receiver, Sender};

use glam::DVec3;

use super::drift::Drift;
use super::memory::{Box3, Gathered, Memory};
use super::settings::RefineSettings;
use crate::frame::World;
use crate::merge::{PlacedCloud, VoxelMapError, VoxelMapSettings};
use crate::registration::{
    Correction, DepthNoise, PoseEstimate, PosePrior, RegistrationError, RegistrationStatistics,
    SourceCloud, SurfaceMap, register,
};
use crate::transform::Transform;

/// What came of a registration.
#[derive(Debug)]
pub(super) struct Outcome {
    pub(super) camera: usize,
    /// Time of the cloud, ns.
    pub(super) time_ns: i64,
    pub(super) result: Result<Accepted, RegistrationError>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Accepted {
    /// What this registration says.
    pub(super) fix: PoseEstimate,
    /// What it says together with those before.
    pub(super) correction: (DVec3, DVec3),
    pub(super) statistics: RegistrationStatistics,
}

/// What is known of one camera.
#[derive(Debug)]
struct Camera {
    memory: Memory,
    drift: Drift,
    /// The order in which cameras were accepted, the anchor first: each is registered against those before
    /// it, so that no two follow each other in a circle.
    rank: Option<u64>,
    last_try_ns: Option<i64>,
    reset_counter: u32,
    prior: Option<PosePrior>,
}

#[derive(Debug)]
pub(super) struct Worker {
    settings: RefineSettings,
    cameras: Vec<Camera>,
    world_epoch: u32,
    next_rank: u64,
}

/// Surfaces further than this from all points of a cloud have nothing to say to it, m.
const MARGIN_M: f64 = 1.0;

impl Worker {
    pub(super) fn new(cameras: usize, settings: RefineSettings) -> Result<Self, VoxelMapError> {
        let size = VoxelMapSettings { voxel_m: settings.voxel_m, max_voxels: settings.max_voxels };
        let camera = |_| {
            let memory = Memory::new(size, settings.memory)?;
            let (drift, rank, last_try_ns) = (Drift::default(), None, None);
            Ok(Camera { memory, drift, rank, last_try_ns, reset_counter: 0, prior: None })
        };
        let cameras = (0..cameras).map(camera).collect::<Result<_, _>>()?;
        Ok(Self { settings, cameras, world_epoch: 0, next_rank: 1 })
    }

    /// Works until nobody sends clouds or takes outcomes.
    pub(super) fn run(mut self, clouds: &Receiver<PlacedCloud>, outcomes: &Sender<Outcome>) {
        for cloud in clouds {
            let outcome = self.take(&cloud);
            if outcome.is_some_and(|outcome| outcomes.send(outcome).is_err()) {
                return;
            }
        }
    }

    /// Registers a cloud if its camera is due, and remembers it where it now is known to be.
    pub(super) fn take(&mut self, cloud: &PlacedCloud) -> Option<Outcome> {
        self.begin_anew_if_the_world_did(cloud);
        let (index, time_ns) = (cloud.camera(), cloud.info().time_ns());
        let prior = PosePrior::try_from(cloud.pose()).ok();
        self.cameras[index].prior = prior;
        if index == self.settings.anchor {
            self.cameras[index].rank = Some(0);
            self.cameras[index].memory.insert(cloud, Transform::IDENTITY);
            return None;
        }
        self.expire(index, time_ns);
        let outcome = self.is_due(index, time_ns).then(|| {
            let result = self.register(cloud, prior.as_ref());
            Outcome { camera: index, time_ns, result }
        });
        let camera = &mut self.cameras[index];
        if let (Some(error), Some(prior)) = (camera.drift.error(), prior) {
            let correction = Correction::about(prior.world_from_body.origin(), &error);
            camera.memory.insert(cloud, correction.transform());
        }
        outcome
    }

    fn begin_anew_if_the_world_did(&mut self, cloud: &PlacedCloud) {
        let pose = cloud.pose();
        if pose.world_epoch() != self.world_epoch {
            self.world_epoch = pose.world_epoch();
            self.cameras.iter_mut().for_each(Camera::forget);
        }
        let camera = &mut self.cameras[cloud.camera()];
        if pose.reset_counter() != camera.reset_counter {
            camera.reset_counter = pose.reset_counter();
            camera.forget();
        }
    }

    fn expire(&mut self, index: usize, now_ns: i64) {
        let camera = &mut self.cameras[index];
        let age_ns = camera.drift.measured_ns().map(|then| now_ns.saturating_sub(then));
        if age_ns.is_some_and(|age| {
            u128::from(age.max(0).cast_unsigned()) > self.settings.expiry.as_nanos()
        }) {
            camera.forget();
        }
    }

    fn is_due(&mut self, index: usize, now_ns: i64) -> bool {
        let period_ns = i64::try_from(self.settings.period.as_nanos()).unwrap_or(i64::MAX);
        let has_target = self.cameras.iter().any(|c| c.rank.is_some() && c.memory.is_solid());
        let camera = &mut self.cameras[index];
        let is_due = camera.last_try_ns.is_none_or(|then| now_ns.saturating_sub(then) >= period_ns);
        if is_due && has_target {
            camera.last_try_ns = Some(now_ns);
        }
        is_due && has_target
    }

    fn register(
        &mut self,
        cloud: &PlacedCloud,
        prior: Option<&PosePrior>,
    ) -> Result<Accepted, RegistrationError> {
        let own = prior.ok_or(RegistrationError::UnusablePrior)?;
        let prior = self.against_the_anchor(own);
        let target = SurfaceMap::new(self.surface(cloud), &self.settings.surface)?;
        let sigma = cloud.info().depth_sigma_per_m().unwrap_or(f32::NAN);
        let seen_from = (cloud.origin_m(), cloud.axis());
        let noise = DepthNoise::from_header(sigma);
        let source = SourceCloud::seen_from(seen_from, cloud.positions_m(), noise);
        let alignment = register(&target, &source, &prior, &self.settings.registration)?;
        let fix = alignment.fix()?;
        let (time_ns, rank) = (cloud.info().time_ns(), self.next_rank);
        let camera = &mut self.cameras[cloud.camera()];
        if camera.rank.is_none() {
            camera.rank = Some(rank);
            self.next_rank += 1;
        }
        if self.settings.aids {
            // The daemon follows the fixes itself; what it publishes does not walk on from the last error.
            camera.drift.forget();
        }
        let error = camera.drift.measure(time_ns, fix.correction.vector(), &fix.covariance);
        let about = Correction::about(own.world_from_body.origin(), &error);
        let correction = (about.rotation_rad(), about.translation_m());
        Ok(Accepted { fix, correction, statistics: alignment.statistics })
    }

    /// What the pose says relative to the anchor's: the anchor's own error counts as well, for its map is
    /// where its poses have put it.
    fn against_the_anchor(&self, own: &PosePrior) -> PosePrior {
        let Some(anchor) = self.cameras[self.settings.anchor].prior else { return *own };
        let arm = own.world_from_body.origin() - anchor.world_from_body.origin();
        let covariance = own.covariance.plus(&anchor.covariance.at_arm(arm));
        PosePrior { covariance, ..*own }
    }

    /// What cameras that were accepted before this one have seen around its cloud.
    fn surface(&self, cloud: &PlacedCloud) -> Vec<(DVec3, f64)> {
        let within = Box3::around(cloud.positions_m(), MARGIN_M);
        let mut gathered = Gathered::new(self.settings.voxel_m);
        let own = self.cameras[cloud.camera()].rank.unwrap_or(u64::MAX);
        for camera in self.cameras.iter().filter(|camera| camera.rank.is_some_and(|r| r < own)) {
            camera.memory.collect(&within, &mut gathered);
        }
        gathered.points()
    }
}

impl Camera {
    fn forget(&mut self) {
        self.memory.clear();
        self.drift.forget();
        self.rank = None;
    }
}

/// The movement of a cloud of the world for an error of its camera's pose.
pub(super) fn movement(body_m: DVec3, (turn, shift): (DVec3, DVec3)) -> Transform<World, World> {
    Correction::new(body_m, turn, shift).transform()
}
