//! Laying the second camera's clouds over the first one's: ICP with the published pose as prior.

use glam::DVec3;
use lodestone_client::registration::{
    DepthNoise, PosePrior, RegistrationError, RegistrationSettings, SourceCloud, SurfaceMap,
    SurfaceSettings, register,
};
use lodestone_client::{PlacedCloud, Transform, VoxelMap, World, body_from_optical_axes};

use crate::demo::result::Refinement;

/// Clouds of the first camera before its surfaces are found, and again each time as many more have come.
const CLOUDS_OF_SURFACE: [u64; 3] = [10, 30, 90];
/// Between two registrations of one camera, ns: what a pose lacks changes slowly, and each takes its time.
const EVERY_NS: i64 = 500_000_000;
/// How long what was found holds, ns.
const HOLDS_NS: i64 = 5_000_000_000;
/// Points that a voxel of the surface has at least: fewer are stray.
const SOLID: u32 = 5;

/// What a registration found, and when one was tried last.
#[derive(Clone, Copy, Debug, Default)]
struct Held {
    tried_ns: Option<i64>,
    found: Option<(i64, Transform<World, World>)>,
}

/// The first camera's surfaces, and the clouds of others laid over them.
#[derive(Debug, Default)]
pub(super) struct Refiner {
    surface: Option<SurfaceMap>,
    /// Surfaces found so far.
    found: usize,
    /// By the camera's index.
    held: Vec<Held>,
    report: Refinement,
}

impl Refiner {
    /// Looks at the first camera's map after so many of its clouds.
    pub(super) fn look(&mut self, map: &VoxelMap, clouds: u64) {
        if CLOUDS_OF_SURFACE.get(self.found).is_none_or(|due| clouds < *due) {
            return;
        }
        self.found += 1;
        let solid = map.voxels().filter(|voxel| voxel.points >= SOLID);
        let points = solid.map(|voxel| (voxel.position_m, f64::from(voxel.points)));
        match SurfaceMap::new(points, &SurfaceSettings::default()) {
            Ok(surface) => self.surface = Some(surface),
            Err(error) => self.refuse(&error),
        }
    }

    /// Where a cloud of another camera must be moved to; `None` while no registration is accepted.
    pub(super) fn correction(&mut self, cloud: &PlacedCloud) -> Option<Transform<World, World>> {
        let (camera, now_ns) = (cloud.camera(), cloud.info().time_ns());
        self.held.resize(self.held.len().max(camera + 1), Held::default());
        if self.held[camera].tried_ns.is_none_or(|tried| now_ns - tried >= EVERY_NS) {
            let surface = self.surface.as_ref()?;
            self.held[camera].tried_ns = Some(now_ns);
            match registered(surface, cloud) {
                Ok(correction) => {
                    self.report.accepted += 1;
                    self.held[camera].found = Some((now_ns, correction));
                }
                Err(error) => self.refuse(&error),
            }
        }
        let held = self.held[camera].found.filter(|(found, _)| now_ns - found <= HOLDS_NS);
        held.map(|(_, correction)| correction)
    }

    /// How it went.
    pub(super) fn report(&self) -> Refinement {
        self.report.clone()
    }

    fn refuse(&mut self, error: &RegistrationError) {
        self.report.refused += 1;
        self.report.last_refusal = Some(error.to_string());
    }
}

fn registered(
    surface: &SurfaceMap,
    cloud: &PlacedCloud,
) -> Result<Transform<World, World>, RegistrationError> {
    let (prior, settings) = (prior(cloud)?, RegistrationSettings::default());
    let alignment = register(surface, &source(cloud, &prior), &prior, &settings)?;
    // Refused where the geometry leaves a movement open or contradicts the pose.
    alignment.fix()?;
    Ok(alignment.posterior.correction.transform())
}

fn prior(cloud: &PlacedCloud) -> Result<PosePrior, RegistrationError> {
    PosePrior::try_from(cloud.pose()).map_err(|_| RegistrationError::UnusablePrior)
}

fn source(cloud: &PlacedCloud, prior: &PosePrior) -> SourceCloud {
    let rotation = prior.world_from_body.rotation() * body_from_optical_axes().rotation();
    let world_from_optical = Transform::new(rotation, cloud.origin_m());
    let sigma = cloud.info().depth_sigma_per_m().unwrap_or(f32::NAN);
    let points = cloud.positions_m().collect::<Vec<DVec3>>();
    SourceCloud::new(world_from_optical, points, DepthNoise::from_header(sigma))
}
