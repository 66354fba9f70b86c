//! One camera's clouds on their way into the world.

use std::time::Instant;

use core::time::Duration;

use lodestone_schema::CloudFrame;

use super::camera::{CameraMerge, PoseSource};
use super::lateness::Lateness;
use super::lenses::Lenses;
use super::place::{PlacedCloud, PlacedPoint, PointCounts, Range, span_ns};
use crate::client::Client;
use crate::cloud::{Cloud, CloudStream, LensPlace, Motion, MotionError};
use crate::error::{CameraNameError, LookupError};
use crate::frame::{Body, Optical};
use crate::pose_stream::PoseStream;
use crate::time::monotonic_now_ns;
use crate::transform::Transform;

/// Poses kept: ten seconds at 400 Hz, more than four clouds of a slow source may wait.
const POSES_KEPT: usize = 4096;

/// What became of one camera's clouds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MergeCounts {
    /// Clouds in the map.
    pub clouds: u64,
    /// What became of the points of clouds that had a pose.
    pub points: PointCounts,
    /// Clouds without a pose at their time.
    pub without_pose: u64,
    /// Clouds of a world that was over when they came.
    pub past_world: u64,
    /// Clouds missing by their sequence: pushed out of shared memory because this consumer was behind, or
    /// left out by their source.
    pub lost: u64,
    /// Clouds whose header was not sound.
    pub invalid: u64,
    /// Restarts of the source.
    pub restarts: u64,
}

/// One camera.
#[derive(Debug)]
pub(super) struct Feed {
    setup: CameraMerge,
    clouds: CloudStream,
    poses: PoseStream,
    waiting: Option<Waiting>,
    counts: MergeCounts,
    pub(super) lateness: Lateness,
    lens: Option<LensPlace>,
    refused: Option<MotionError>,
}

/// A cloud whose poses are not there yet. Only one: those after it wait in shared memory.
#[derive(Debug)]
struct Waiting {
    cloud: Cloud,
    span_ns: (i64, i64),
    since: Instant,
}

/// How clouds are placed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placing {
    pub(super) range: Range,
    pub(super) patience: Duration,
    pub(super) compensate: bool,
}

impl Feed {
    pub(super) fn new(client: &Client, setup: CameraMerge) -> Result<Self, CameraNameError> {
        let builder = client.pose_stream(setup.poses.camera())?.capacity(POSES_KEPT);
        let poses = match setup.poses {
            PoseSource::Estimate(_) => builder,
            PoseSource::Truth(_) => builder.truth(),
        };
        let (clouds, poses) = (client.clouds(&setup.camera)?, poses.open());
        let counts = MergeCounts::default();
        let lateness = Lateness::default();
        Ok(Self {
            setup,
            clouds,
            poses,
            waiting: None,
            counts,
            lateness,
            lens: None,
            refused: None,
        })
    }

    pub(super) const fn setup(&self) -> &CameraMerge {
        &self.setup
    }

    pub(super) const fn clouds(&self) -> &CloudStream {
        &self.clouds
    }

    /// How the lens's place is known; `None` before the first cloud in optical axes.
    pub(super) const fn lens(&self) -> Option<LensPlace> {
        self.lens
    }

    /// Why the last cloud without a pose had none.
    pub(super) const fn refused(&self) -> Option<&MotionError> {
        self.refused.as_ref()
    }

    pub(super) const fn counts(&self) -> MergeCounts {
        let stream = self.clouds.counts();
        let (lost, invalid, restarts) = (stream.lost, stream.invalid, stream.restarts);
        MergeCounts { lost, invalid, restarts, ..self.counts }
    }

    /// The next cloud in the world, if one is there and its poses are too.
    pub(super) fn next(
        &mut self,
        camera: usize,
        lenses: &mut Lenses,
        placing: &Placing,
        buffer: &mut Vec<Vec<PlacedPoint>>,
    ) -> Option<PlacedCloud> {
        let waiting = self.take_waiting(placing)?;
        match self.motion(&waiting, lenses, placing.patience) {
            Ok(Some(motion)) => {
                let Waiting { cloud, .. } = waiting;
                let of = (cloud.info(), cloud.points());
                let buffer = buffer.pop().unwrap_or_default();
                Some(PlacedCloud::place(camera, of, motion, placing.range, buffer))
            }
            Ok(None) => {
                self.waiting = Some(waiting);
                None
            }
            Err(error) => {
                self.counts.without_pose += 1;
                tracing::debug!(camera = self.setup.camera, %error, "cloud without a pose");
                self.refused = Some(error);
                None
            }
        }
    }

    /// The cloud that waits already, or the next one.
    fn take_waiting(&mut self, placing: &Placing) -> Option<Waiting> {
        if let Some(waiting) = self.waiting.take() {
            return Some(waiting);
        }
        let cloud = self.clouds.next()?;
        let span_ns = if placing.compensate { span_ns(cloud.info(), &cloud) } else { (0, 0) };
        Some(Waiting { cloud, span_ns, since: Instant::now() })
    }

    /// Where the sensor was; `None` while that may still turn up.
    ///
    /// As long as patience lasts, only poses on both sides of each time count. Then what may be predicted is.
    fn motion(
        &mut self,
        waiting: &Waiting,
        lenses: &mut Lenses,
        patience: Duration,
    ) -> Result<Option<Motion>, MotionError> {
        let time_ns = waiting.cloud.info().time_ns();
        let is_patient = waiting.since.elapsed() < patience;
        let newest_ns = self.poses.latest().map_or(i64::MIN, |pose| pose.time_ns());
        if is_patient && newest_ns < time_ns.saturating_add(waiting.span_ns.1) {
            return Ok(None);
        }
        let Some(sensor) = self.sensor(waiting.cloud.info().frame(), lenses) else {
            return Ok(None);
        };
        match sensor.motion(time_ns, waiting.span_ns, &mut self.poses) {
            Ok(motion) => Ok(Some(motion)),
            Err(MotionError::Lookup(error)) if is_patient && may_heal(&error) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// The sensor on the body; `None` while it may still turn up.
    fn sensor(&mut self, frame: CloudFrame, lenses: &mut Lenses) -> Option<Sensor> {
        if frame == CloudFrame::Body {
            return Some(Sensor::Body);
        }
        let lens = lenses.of(&self.setup)?;
        if self.lens != Some(lens.place) && lens.place == LensPlace::AssumedAtImu {
            let camera = &self.setup.camera;
            tracing::warn!(camera, "the lens's place is not configured: it counts as at the IMU");
        }
        self.lens = Some(lens.place);
        Some(Sensor::Lens(lens.body_from_optical))
    }

    /// A cloud of this camera is in the map.
    pub(super) fn merged(&mut self, cloud: &PlacedCloud) {
        self.counts.clouds += 1;
        self.counts.points.add(cloud.counts());
        let late_ns = monotonic_now_ns().saturating_sub(cloud.info().published_time_ns());
        self.lateness.add(Duration::from_nanos(u64::try_from(late_ns).unwrap_or(0)));
    }

    /// A cloud of this camera came too late for its world.
    pub(super) const fn passed_over(&mut self) {
        self.counts.past_world += 1;
    }
}

/// What a cloud's points are relative to.
#[derive(Clone, Copy, Debug)]
enum Sensor {
    Body,
    Lens(Transform<Body, Optical>),
}

impl Sensor {
    /// Where it was over a cloud's times.
    fn motion(
        self,
        time_ns: i64,
        span_ns: (i64, i64),
        poses: &mut PoseStream,
    ) -> Result<Motion, MotionError> {
        let lookup = |time, fields| poses.lookup_with(time, fields);
        match self {
            Self::Body => Motion::over(time_ns, span_ns, AT_BODY, lookup),
            Self::Lens(lens) => Motion::over(time_ns, span_ns, lens, lookup),
        }
    }
}

const AT_BODY: Transform<Body, Body> = Transform::IDENTITY;

/// Whether poses that come later can make it good.
const fn may_heal(error: &LookupError) -> bool {
    matches!(error, LookupError::NotConnected(_) | LookupError::Empty | LookupError::TooNew { .. })
}
