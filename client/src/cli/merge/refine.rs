//! Corrections by registration while merging, and their way back to the daemon.

use lodestone_client::{
    AidingError, AidingOrigin, AidingPublisher, CameraMerge, CloudFix, CloudMerger, CloudRefiner,
    PlacedCloud, Placement, PoseSource, RefineReport, RefineSettings, monotonic_now_ns,
};

use super::super::args::MergeArgs;
use super::super::failure::Failure;
use super::super::session::Session;

/// Refines the clouds of a merger.
pub(super) struct Refining {
    refiner: CloudRefiner,
    anchor: usize,
    /// One for each camera; none for the anchor, and where nobody is told.
    aids: Vec<Option<Aid>>,
}

/// Tells a camera's lane what was found.
struct Aid {
    publisher: AidingPublisher,
    /// Not handed over yet.
    waiting: Option<CloudFix>,
    offered: u64,
    failed: u64,
    last_failure: Option<AidingError>,
}

/// A fix is of use to the daemon for two seconds.
const USEFUL_NS: i64 = 1_900_000_000;

/// What became of the fixes of one camera.
#[derive(Clone, Debug, Default)]
pub(super) struct AidReport {
    pub(super) offered: u64,
    pub(super) failed: u64,
    pub(super) last_failure: Option<String>,
}

impl Refining {
    /// `None` unless asked for.
    pub(super) fn open(
        session: &Session,
        args: &MergeArgs,
        merger: &CloudMerger,
    ) -> Result<Option<Self>, Failure> {
        if !args.refinement.refine {
            return Ok(None);
        }
        let cameras: Vec<&CameraMerge> = merger.cameras().collect();
        let anchor = anchor(args, &cameras)?;
        let settings =
            RefineSettings { anchor, aids: args.refinement.aid, ..RefineSettings::default() };
        let refiner = CloudRefiner::new(cameras.len(), settings)
            .map_err(|error| Failure::Other(error.to_string()))?;
        let aid = |(index, camera): (usize, &&CameraMerge)| {
            (args.refinement.aid && index != anchor)
                .then(|| Aid::open(session, &camera.poses, &cameras[anchor].poses))
                .transpose()
        };
        let aids = cameras.iter().enumerate().map(aid).collect::<Result<_, _>>()?;
        Ok(Some(Self { refiner, anchor, aids }))
    }

    /// Lays a cloud into the map where it now is known to be, and tells the daemon of what was found.
    pub(super) fn insert(&mut self, merger: &mut CloudMerger, cloud: PlacedCloud) {
        if let Placement::Insert(correction) = self.refiner.place(&cloud) {
            merger.insert_corrected(cloud, correction);
        }
        for fix in self.refiner.take_fixes() {
            if let Some(aid) = &mut self.aids[fix.camera] {
                aid.waiting = Some(fix);
            }
        }
        self.aids.iter_mut().flatten().for_each(Aid::hand_over);
    }

    /// `None` for the anchor, which is never registered.
    pub(super) fn report(&self, camera: usize) -> Option<&RefineReport> {
        (camera != self.anchor).then(|| self.refiner.report(camera))
    }

    /// `None` where nobody is told.
    pub(super) fn aid_report(&self, camera: usize) -> Option<AidReport> {
        self.aids[camera].as_ref().map(Aid::report)
    }
}

/// Index of the camera whose clouds stay where they are.
fn anchor(args: &MergeArgs, cameras: &[&CameraMerge]) -> Result<usize, Failure> {
    let Some(name) = &args.refinement.anchor else { return Ok(0) };
    cameras.iter().position(|camera| camera.camera == *name).ok_or_else(|| {
        let there: Vec<_> = cameras.iter().map(|camera| camera.camera.as_str()).collect();
        let there = there.join(", ");
        Failure::Usage(format!(
            "--anchor: no clouds of camera {name:?} are merged; there are: {there}"
        ))
    })
}

impl Aid {
    /// Tells the lane whose poses place the clouds, measured against that of the anchor.
    fn open(session: &Session, lane: &PoseSource, anchor: &PoseSource) -> Result<Self, Failure> {
        let publisher = session.client.aiding(lane.camera())?;
        let publisher = publisher.made_with(AidingOrigin::CloudRegistration);
        let publisher = publisher.anchored_to(anchor.camera())?;
        Ok(Self { publisher, waiting: None, offered: 0, failed: 0, last_failure: None })
    }

    /// Hands over what waits. The lane may not be heard of yet, so that it is tried again with the next cloud,
    /// until the fix is too old.
    fn hand_over(&mut self) {
        // Asked with every cloud, so that the lane is known by the time there is something to say.
        let _ = self.publisher.is_ready();
        let Some(fix) = self.waiting.take() else { return };
        let (pose, covariance) = (fix.estimate.world_from_body, fix.estimate.covariance);
        let position = (pose.origin(), covariance.position_m2);
        let orientation = (pose.rotation(), covariance.orientation_rad2);
        match self.publisher.pose(fix.time_ns, position, orientation) {
            Ok(()) => self.offered += 1,
            Err(_) if monotonic_now_ns().saturating_sub(fix.time_ns) < USEFUL_NS => {
                self.waiting = Some(fix);
            }
            Err(error) => {
                self.failed += 1;
                self.last_failure = Some(error);
            }
        }
    }

    fn report(&self) -> AidReport {
        let last_failure = self.last_failure.as_ref().map(ToString::to_string);
        AidReport { offered: self.offered, failed: self.failed, last_failure }
    }
}
