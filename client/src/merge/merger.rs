//! Clouds of several cameras, one map.

use std::thread::sleep;
use std::time::Instant;

use core::time::Duration;

use super::camera::{CameraMerge, MOST_CAMERAS};
use super::epoch::{Epoch, Turn};
use super::error::MergeError;
use super::feed::{Feed, MergeCounts, Placing};
use super::lateness::Lateness;
use super::lenses::Lenses;
use super::map::{VoxelMap, VoxelMapSettings};
use super::place::{PlacedCloud, PlacedPoint, Range};
use crate::client::Client;
use crate::cloud::{CloudStream, LensPlace, MotionError};
use crate::frame::World;
use crate::time::monotonic_now_ns;
use crate::transform::Transform;

/// A source's next cloud is some tens of milliseconds away.
const BETWEEN_LOOKS: Duration = Duration::from_millis(1);

/// Settings of a [`CloudMerger`].
#[derive(Clone, Debug)]
pub struct CloudMergerBuilder {
    client: Client,
    cameras: Vec<CameraMerge>,
    map: VoxelMapSettings,
    placing: Placing,
}

impl CloudMergerBuilder {
    pub(crate) const fn new(client: Client) -> Self {
        let placing = Placing {
            range: Range { min_m: 0.1, max_m: 40.0 },
            patience: Duration::from_millis(150),
            compensate: true,
        };
        let map = VoxelMapSettings { voxel_m: 0.05, max_voxels: 2_000_000 };
        Self { client, cameras: Vec::new(), map, placing }
    }

    /// Adds a camera.
    #[must_use]
    pub fn camera(mut self, camera: CameraMerge) -> Self {
        self.cameras.push(camera);
        self
    }

    /// Size of the map; see [`VoxelMapSettings`].
    #[must_use]
    pub const fn map(mut self, settings: VoxelMapSettings) -> Self {
        self.map = settings;
        self
    }

    /// How far from the sensor points may be; see [`Range`].
    #[must_use]
    pub const fn range(mut self, range: Range) -> Self {
        self.placing.range = range;
        self
    }

    /// How long a cloud may wait for poses on both sides of each of its points' times; then they are predicted
    /// as far as lookups allow. Default 150 ms: four clouds wait behind it in shared memory, a quarter of a
    /// second at 15 Hz.
    #[must_use]
    pub const fn patience(mut self, patience: Duration) -> Self {
        self.placing.patience = patience;
        self
    }

    /// Whether each point is placed by the pose at its own time, which is the default, or all by the pose at the
    /// cloud's time, to compare with.
    #[must_use]
    pub const fn compensate(mut self, compensate: bool) -> Self {
        self.placing.compensate = compensate;
        self
    }

    /// Makes the merger, which connects when it is first asked for a cloud.
    ///
    /// # Errors
    /// [`MergeError`].
    pub fn open(self) -> Result<CloudMerger, MergeError> {
        self.check()?;
        let lenses = Lenses::new(&self.client);
        let map = VoxelMap::new(self.map)?;
        let feeds: Result<Vec<Feed>, _> =
            self.cameras.into_iter().map(|camera| Feed::new(&self.client, camera)).collect();
        Ok(CloudMerger {
            feeds: feeds?,
            lenses,
            placing: self.placing,
            map,
            epoch: Epoch::default(),
            begun_anew: 0,
            turn: 0,
            buffers: Vec::new(),
        })
    }

    fn check(&self) -> Result<(), MergeError> {
        if self.cameras.is_empty() {
            return Err(MergeError::NoCamera);
        }
        if self.cameras.len() > MOST_CAMERAS {
            return Err(MergeError::TooManyCameras(self.cameras.len()));
        }
        for (index, CameraMerge { camera, .. }) in self.cameras.iter().enumerate() {
            if self.cameras[..index].iter().any(|other| other.camera == *camera) {
                return Err(MergeError::Twice(camera.clone()));
            }
        }
        let Range { min_m, max_m } = self.placing.range;
        let is_range = min_m >= 0.0 && max_m > min_m && max_m.is_finite();
        if is_range { Ok(()) } else { Err(MergeError::Range { min_m, max_m }) }
    }
}

/// Merges the clouds of several cameras into one map of the world, live.
///
/// Each cloud takes two steps, between which a caller may look at it and correct it:
///
/// ```no_run
/// use std::time::Duration;
/// use lodestone_client::{CameraMerge, Client};
///
/// let client = Client::connect()?;
/// let mut merger = client
///     .merger()
///     .camera(CameraMerge::new("front"))
///     .camera(CameraMerge::new("rear"))
///     .open()?;
/// while merger.map().len() < 100_000 {
///     if let Some(cloud) = merger.wait(Duration::from_secs(1)) {
///         merger.insert(cloud);
///     }
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// A cloud waits until the poses around the times of all its points are there. One whose poses never come is
/// counted and passed over; no point is placed by a guess. When the world is defined anew, the map begins anew:
/// places in different worlds do not compare. Stays on the thread that made it.
#[derive(Debug)]
pub struct CloudMerger {
    feeds: Vec<Feed>,
    lenses: Lenses,
    placing: Placing,
    map: VoxelMap,
    epoch: Epoch,
    begun_anew: u64,
    /// The camera that is asked first.
    turn: usize,
    /// Buffers of clouds that are in the map.
    buffers: Vec<Vec<PlacedPoint>>,
}

impl CloudMerger {
    /// The next cloud that is there with its poses, placed in the world; `None` if none is. Cameras take turns.
    #[allow(clippy::should_implement_trait, reason = "None now may be followed by a cloud later")]
    pub fn next(&mut self) -> Option<PlacedCloud> {
        let count = self.feeds.len();
        (0..count).find_map(|_| {
            let camera = self.turn;
            self.turn = (camera + 1) % count;
            let feed = &mut self.feeds[camera];
            feed.next(camera, &mut self.lenses, &self.placing, &mut self.buffers)
        })
    }

    /// The next cloud, waited for; `None` if none comes in time.
    pub fn wait(&mut self, timeout: Duration) -> Option<PlacedCloud> {
        let end = Instant::now() + timeout;
        loop {
            let found = self.next();
            let left = end.saturating_duration_since(Instant::now());
            if found.is_some() || left.is_zero() {
                return found;
            }
            sleep(BETWEEN_LOOKS.min(left));
        }
    }

    /// Lays a cloud into the map as it was placed.
    pub fn insert(&mut self, cloud: PlacedCloud) {
        self.insert_corrected(cloud, Transform::IDENTITY);
    }

    /// Lays a cloud into the map, moved and turned in the world by a correction, such as a registration's.
    pub fn insert_corrected(&mut self, cloud: PlacedCloud, correction: Transform<World, World>) {
        let Some(feed) = self.feeds.get_mut(cloud.camera()) else { return };
        let number = cloud.pose().world_epoch();
        match self.epoch.observe(number, monotonic_now_ns()) {
            Turn::Past => feed.passed_over(),
            turn => {
                if turn == Turn::Anew {
                    tracing::warn!(epoch = number, "the world was defined anew: so is the map");
                    self.map.clear();
                    self.begun_anew += 1;
                }
                self.map.insert_corrected(&cloud, correction);
                feed.merged(&cloud);
            }
        }
        if self.buffers.len() < self.feeds.len() {
            self.buffers.push(cloud.into_points());
        }
    }

    /// The map.
    pub const fn map(&self) -> &VoxelMap {
        &self.map
    }

    /// Epoch of the map's world; `None` before the first cloud.
    pub fn world_epoch(&self) -> Option<u32> {
        self.epoch.number()
    }

    /// How often the map began anew because the world did.
    pub const fn begun_anew(&self) -> u64 {
        self.begun_anew
    }

    /// The cameras; their indices are those of clouds and voxels.
    pub fn cameras(&self) -> impl ExactSizeIterator<Item = &CameraMerge> {
        self.feeds.iter().map(Feed::setup)
    }

    /// What became of a camera's clouds, by its index.
    ///
    /// # Panics
    /// If there is no such camera; so do the others that take an index.
    pub fn counts(&self, camera: usize) -> MergeCounts {
        self.feeds[camera].counts()
    }

    /// How late a camera's clouds came into the map.
    pub fn lateness(&self, camera: usize) -> &Lateness {
        &self.feeds[camera].lateness
    }

    /// How the place of a camera's lens is known; `None` before its first cloud in optical axes.
    pub fn lens(&self, camera: usize) -> Option<LensPlace> {
        self.feeds[camera].lens()
    }

    /// Why the last cloud without a pose had none.
    pub fn refused(&self, camera: usize) -> Option<&MotionError> {
        self.feeds[camera].refused()
    }

    /// The stream of a camera's clouds, for its state of connection.
    pub fn clouds(&self, camera: usize) -> &CloudStream {
        self.feeds[camera].clouds()
    }
}
