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
/// Points that a voxel of the surface has at least: fewer are stray.
const SOLID: u32 = 5;

/// The first camera's surfaces, and the clouds of others laid over them.
#[derive(Debug, Default)]
pub(super) struct Refiner {
    surface: Option<SurfaceMap>,
    /// Surfaces found so far.
    found: usize,
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

    /// Where a cloud of another camera must be moved to; `None` while there is no surface, or where the
    /// registration is refused.
    pub(super) fn correction(&mut self, cloud: &PlacedCloud) -> Option<Transform<World, World>> {
        let surface = self.surface.as_ref()?;
        let aligned = prior(cloud).and_then(|prior| {
            let settings = RegistrationSettings::default();
            let alignment = register(surface, &source(cloud, &prior), &prior, &settings)?;
            // Refused where the geometry leaves a movement open or contradicts the pose.
            alignment.fix()?;
            Ok(alignment.posterior.correction.transform())
        });
        match aligned {
            Ok(correction) => {
                self.report.accepted += 1;
                Some(correction)
            }
            Err(error) => {
                self.refuse(&error);
                None
            }
        }
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
