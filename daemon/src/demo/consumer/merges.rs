//! The same clouds, merged several times, each time by other poses.

use std::time::Duration;

use lodestone_client::{
    CloudRefiner, PlacedCloud, Placement, RefineSettings, Transform, VoxelMap, VoxelMapSettings,
    World,
};

use super::ConsumerError;
use super::poses::{OtherPoses, Place, PoseMean};
use crate::demo::result::{Merge, Refinement, SeenCamera, Variant};

/// Edge of a voxel, about the noise of depth at 3.5 m, m.
const VOXEL_M: f64 = 0.04;
/// Room for each merge; a furnished room with all its noise takes a third.
const MOST_VOXELS: usize = 1 << 20;

/// Between two registrations of a camera.
const REFINED_EVERY: Duration = Duration::from_secs(1);

/// One merge.
#[derive(Debug)]
pub(super) struct Merged {
    pub(super) variant: Variant,
    pub(super) map: VoxelMap,
    clouds: u64,
    without_pose: u64,
}

impl Merged {
    fn new(variant: Variant) -> Result<Self, ConsumerError> {
        let settings = VoxelMapSettings { voxel_m: VOXEL_M, max_voxels: MOST_VOXELS };
        Ok(Self { variant, map: VoxelMap::new(settings)?, clouds: 0, without_pose: 0 })
    }

    fn take(&mut self, cloud: &PlacedCloud, correction: Option<Transform<World, World>>) {
        if !self.variant.takes(cloud.camera()) {
            return;
        }
        let Some(correction) = correction else {
            self.without_pose += 1;
            return;
        };
        self.map.insert_corrected(cloud, correction);
        self.clouds += 1;
    }

    /// What came of it.
    pub(super) fn report(&self) -> Merge {
        let counts = self.map.counts();
        Merge {
            variant: self.variant,
            clouds: self.clouds,
            points: counts.points,
            voxels: self.map.len() as u64,
            without_pose: self.without_pose,
            forgotten: counts.evicted,
        }
    }
}

/// Poses of one camera over the time of merging.
#[derive(Debug)]
pub(super) struct Watched {
    name: String,
    others: OtherPoses,
    own: PoseMean,
    refined: PoseMean,
    without_magnetometer: PoseMean,
    truth: PoseMean,
    variance_sum: f64,
    clouds: f64,
}

impl Watched {
    pub(super) fn new(name: &str, others: OtherPoses) -> Self {
        let mean = PoseMean::default;
        Self {
            name: name.into(),
            others,
            own: mean(),
            refined: mean(),
            without_magnetometer: mean(),
            truth: mean(),
            variance_sum: 0.0,
            clouds: 0.0,
        }
    }

    /// What is not there yet.
    pub(super) fn missing(&mut self) -> Option<&'static str> {
        self.others.missing()
    }

    /// `None` if no cloud of it was merged.
    pub(super) fn report(&self, lost: u64) -> Option<SeenCamera> {
        Some(SeenCamera {
            name: self.name.clone(),
            lost,
            heading_sigma_deg: (self.variance_sum / self.clouds).sqrt().to_degrees(),
            own: self.own.mean()?,
            refined: self.refined.mean(),
            without_magnetometer: self.without_magnetometer.mean(),
            truth: self.truth.mean(),
        })
    }
}

/// All merges.
#[derive(Debug)]
pub(super) struct Merges {
    pub(super) all: Vec<Merged>,
    pub(super) watched: Vec<Watched>,
    refiner: CloudRefiner,
}

impl Merges {
    pub(super) fn new(watched: Vec<Watched>) -> Result<Self, ConsumerError> {
        let all = Variant::ALL.into_iter().map(Merged::new).collect::<Result<_, _>>()?;
        let settings = RefineSettings { period: REFINED_EVERY, ..RefineSettings::default() };
        let refiner = CloudRefiner::new(watched.len(), settings)?;
        Ok(Self { all, watched, refiner })
    }

    /// Where ICP moves a cloud; `None` while its camera's first registration is waited for. The first camera
    /// stays where it is.
    pub(super) fn refine(&mut self, cloud: &PlacedCloud) -> Option<Transform<World, World>> {
        match self.refiner.place(cloud) {
            Placement::Insert(correction) => Some(correction),
            Placement::Hold => None,
        }
    }

    /// How ICP went, of all cameras.
    pub(super) fn refinement(&self) -> Refinement {
        let mut all = Refinement::default();
        for report in (0..self.watched.len()).map(|camera| self.refiner.report(camera)) {
            all.accepted += report.accepted;
            all.refused += report.refused.total();
            all.unrefined += report.unrefined;
            all.last_refusal =
                report.last_refusal.as_ref().map(ToString::to_string).or(all.last_refusal);
        }
        all
    }

    /// Takes a cloud that was placed by its camera's own pose into every merge that it belongs to.
    pub(super) fn take(&mut self, cloud: &PlacedCloud) {
        // A cloud that was placed has this.
        let Ok(own) = cloud.pose().world_from_body() else { return };
        let time_ns = cloud.info().time_ns();
        let refined = self.refine(cloud);
        let Some(watched) = self.watched.get_mut(cloud.camera()) else { return };
        let without = watched.others.without_magnetometer(time_ns);
        let truth = watched.others.truth(time_ns);
        watched.note(cloud, (own, refined, without, truth));
        let instead = |place: Option<Place>| place.map(|place| place * own.inverse());
        let (without, truth) = (instead(without), instead(truth));
        for merged in &mut self.all {
            let correction = match merged.variant {
                Variant::FrontAlone | Variant::RearAlone | Variant::Lodestone => {
                    Some(Transform::IDENTITY)
                }
                Variant::WithoutMagnetometer => without,
                Variant::Refined => refined,
                Variant::Perfect => truth,
            };
            merged.take(cloud, correction);
        }
    }

    /// Points that both cameras' merge by their own poses has.
    pub(super) fn points(&self) -> u64 {
        let both = self.all.iter().find(|merged| merged.variant == Variant::Lodestone);
        both.map_or(0, |merged| merged.map.counts().points)
    }
}

type Moved = Option<Transform<World, World>>;

impl Watched {
    fn note(
        &mut self,
        cloud: &PlacedCloud,
        (own, refined, without, truth): (Place, Moved, Option<Place>, Option<Place>),
    ) {
        self.own.add(&own);
        if let Some(moved) = refined {
            self.refined.add(&(moved * own));
        }
        if let Some(without) = &without {
            self.without_magnetometer.add(without);
        }
        if let Some(truth) = &truth {
            self.truth.add(truth);
        }
        if let Some(heading) = cloud.pose().heading() {
            self.variance_sum += heading.sigma_rad.powi(2);
            self.clouds += 1.0;
        }
    }
}
