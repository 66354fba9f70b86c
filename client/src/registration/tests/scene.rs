//! Two cameras, one map, one prior: the pieces of each test's story.

use glam::{DMat3, DQuat, DVec3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::room::{NOISE_PER_M, Room, normal3, voxels};
use crate::frame::{Body, Rotation, World};
use crate::registration::{
    Alignment, DepthNoise, PoseCovariance, PosePrior, RegistrationError, RegistrationSettings,
    SourceCloud, SurfaceMap, SurfaceSettings, register,
};
use crate::transform::{Transform, body_from_optical_axes};

pub(super) type Pose = Transform<World, Body>;

/// Standard deviations of a prior.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sigma {
    pub(super) turn_deg: f64,
    pub(super) shift_m: f64,
}

impl Sigma {
    pub(super) fn covariance(self) -> PoseCovariance {
        let square = |sigma: f64| DMat3::IDENTITY * (sigma * sigma);
        PoseCovariance::independent(square(self.turn_deg.to_radians()), square(self.shift_m))
    }

    /// An error as likely as the covariance says.
    pub(super) fn draw(self, rng: &mut ChaCha8Rng) -> (DVec3, DVec3) {
        (normal3(rng) * self.turn_deg.to_radians(), normal3(rng) * self.shift_m)
    }
}

/// A pose that is wrong by a turn about the world's axes, rad, and a shift, m.
pub(super) fn wrong(pose: Pose, (turn, shift): (DVec3, DVec3)) -> Pose {
    let turned = DQuat::from_scaled_axis(turn) * pose.rotation().quaternion();
    Transform::new(Rotation::from_quaternion(turned).unwrap(), pose.origin() + shift)
}

/// How wrong a pose is: turn about the world's axes, rad, and shift, m.
pub(super) fn error(found: Pose, truth: Pose) -> (DVec3, DVec3) {
    let turn = found.rotation().quaternion() * truth.rotation().quaternion().conjugate();
    let turn = if turn.w < 0.0 { -turn } else { turn };
    (turn.to_scaled_axis(), found.origin() - truth.origin())
}

pub(super) struct Scene {
    /// All that was mapped, in the world, m.
    pub(super) map_points: Vec<DVec3>,
    pub(super) target: SurfaceMap,
    pub(super) source_in_body: Vec<DVec3>,
    pub(super) truth: Pose,
    pub(super) rng: ChaCha8Rng,
}

impl Scene {
    /// One camera scans several times into a map of 5 cm voxels; another one scans once.
    pub(super) fn new(room: &Room, mapped_from: &[Pose], truth: Pose, seed: u64) -> Self {
        Self::sized(room, mapped_from, truth, ((160, 96), (80, 48), seed))
    }

    /// The same with so many columns and rows of the map's scans and of the source's.
    pub(super) fn sized(
        room: &Room,
        mapped_from: &[Pose],
        truth: Pose,
        (of_map, of_source, seed): ((u32, u32), (u32, u32), u64),
    ) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut map_points = Vec::new();
        for from in mapped_from {
            let scan = room.scan(*from, of_map, NOISE_PER_M, &mut rng);
            map_points.extend(scan.iter().map(|point| from.apply(*point)));
        }
        let voxels = voxels(&map_points, 0.05);
        let target = SurfaceMap::new(voxels, &SurfaceSettings::default()).unwrap();
        let source_in_body = room.scan(truth, of_source, NOISE_PER_M, &mut rng);
        Self { map_points, target, source_in_body, truth, rng }
    }

    pub(super) fn source(&self, prior: Pose) -> SourceCloud {
        let points = self.source_in_body.iter().map(|point| prior.apply(*point));
        let noise = DepthNoise::from_header(NOISE_PER_M as f32);
        SourceCloud::new(prior * body_from_optical_axes(), points, noise)
    }

    /// Lays the source over the target, beginning with a pose that is wrong.
    pub(super) fn register(
        &self,
        away: (DVec3, DVec3),
        sigma: Sigma,
    ) -> Result<Alignment, RegistrationError> {
        let world_from_body = wrong(self.truth, away);
        let prior = PosePrior { world_from_body, covariance: sigma.covariance() };
        let source = self.source(world_from_body);
        register(&self.target, &source, &prior, &RegistrationSettings::default())
    }
}
