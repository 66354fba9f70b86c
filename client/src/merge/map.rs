//! The map: what all clouds together have seen, in bounded memory.

use glam::{DMat3, DVec3, Mat3, Vec3};

use super::error::VoxelMapError;
use super::grid::{CellKey, Grid, LARGEST_VOXEL_M, SMALLEST_VOXEL_M};
use super::place::PlacedCloud;
use super::table::SlotTable;
use super::voxel::{Run, Sighting, Voxel, VoxelView};
use crate::frame::World;
use crate::transform::Transform;

/// Most voxels of a map: 2^28, 21 GB.
pub(super) const MOST_VOXELS: usize = 1 << 28;
/// Voxels looked at to find one to forget.
const LOOKED_AT: usize = 1024;

/// Runs handed to their voxels together.
const GATHERED: usize = 32;

/// Size of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoxelMapSettings {
    /// Edge of a voxel, m; default 0.05.
    pub voxel_m: f64,
    /// Voxels kept at most, at 80 bytes each; default two million, 5000 m² of surface in voxels of 5 cm.
    pub max_voxels: usize,
}

impl Default for VoxelMapSettings {
    fn default() -> Self {
        Self { voxel_m: 0.05, max_voxels: 2_000_000 }
    }
}

/// What a map has taken and lost since it was made, over all worlds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MapCounts {
    /// Points taken.
    pub points: u64,
    /// Points too far from the world's origin for the grid.
    pub beyond_grid: u64,
    /// Voxels forgotten to make room for new ones.
    pub evicted: u64,
}

/// Points gathered in voxels, of a fixed number at most: when full, those go that were not seen for longest.
///
/// All memory is taken when it is made. What goes is found as by a clock with a second chance: a hand goes
/// round over all voxels and takes the first that was not seen since it came by last; if it meets none within
/// 1024, it takes the one of them that was seen longest ago. So the time for a point is bounded too.
#[derive(Clone, Debug)]
pub struct VoxelMap {
    settings: VoxelMapSettings,
    grid: Grid,
    table: SlotTable,
    voxels: Vec<Voxel>,
    hand: usize,
    start_ns: Option<i64>,
    counts: MapCounts,
}

impl VoxelMap {
    /// An empty map.
    ///
    /// # Errors
    /// [`VoxelMapError`].
    pub fn new(settings: VoxelMapSettings) -> Result<Self, VoxelMapError> {
        let VoxelMapSettings { voxel_m, max_voxels } = settings;
        if !(SMALLEST_VOXEL_M..=LARGEST_VOXEL_M).contains(&voxel_m) {
            return Err(VoxelMapError::VoxelSize(voxel_m));
        }
        if !(1..=MOST_VOXELS).contains(&max_voxels) {
            return Err(VoxelMapError::VoxelCount(max_voxels));
        }
        Ok(Self {
            settings,
            grid: Grid::new(voxel_m),
            table: SlotTable::new(max_voxels),
            voxels: Vec::with_capacity(max_voxels),
            hand: 0,
            start_ns: None,
            counts: MapCounts::default(),
        })
    }

    /// The size.
    pub const fn settings(&self) -> VoxelMapSettings {
        self.settings
    }

    /// Voxels in which something was seen.
    pub fn len(&self) -> usize {
        self.voxels.len()
    }

    /// Whether nothing was seen.
    pub fn is_empty(&self) -> bool {
        self.voxels.is_empty()
    }

    /// What was taken and lost.
    pub const fn counts(&self) -> MapCounts {
        self.counts
    }

    /// Memory taken, bytes; never changes.
    pub fn bytes(&self) -> usize {
        self.table.bytes() + self.voxels.capacity() * size_of::<Voxel>()
    }

    /// Every voxel, in no order.
    pub fn voxels(&self) -> impl ExactSizeIterator<Item = VoxelView> {
        let start_ns = self.start_ns.unwrap_or_default();
        self.voxels.iter().map(move |voxel| voxel.view(self.grid, start_ns))
    }

    /// The voxel that holds a place in the world, m; `None` if nothing was seen there.
    pub fn at(&self, place_m: DVec3) -> Option<VoxelView> {
        let key = CellKey::of(self.grid.locate(place_m).0)?;
        let slot = self.table.find(key.hash(), |slot| self.is_in(slot, key))?;
        Some(self.voxels[slot as usize].view(self.grid, self.start_ns.unwrap_or_default()))
    }

    /// Forgets all that was seen; keeps the memory and the counts.
    pub fn clear(&mut self) {
        self.table.clear();
        self.voxels.clear();
        self.hand = 0;
        self.start_ns = None;
    }

    /// Takes a cloud.
    pub fn insert(&mut self, cloud: &PlacedCloud) {
        self.insert_corrected(cloud, Transform::IDENTITY);
    }

    /// Takes a cloud, moved and turned in the world by a correction.
    pub fn insert_corrected(&mut self, cloud: &PlacedCloud, correction: Transform<World, World>) {
        let start_ns = *self.start_ns.get_or_insert(cloud.info().time_ns());
        let since_start_ms = cloud.info().time_ns().saturating_sub(start_ns) / 1_000_000;
        let sighting = Sighting {
            camera: cloud.camera() as u32 % u16::BITS,
            has_colour: cloud.info().has_colour(),
            time_ms: u32::try_from(since_start_ms.max(0)).unwrap_or(u32::MAX),
        };
        let turn = correction.rotation().matrix();
        let origin_m = correction.apply(cloud.origin_m());
        if turn == DMat3::IDENTITY {
            self.take(cloud, origin_m, &sighting, |offset| offset);
        } else {
            let turn: Mat3 = turn.as_mat3();
            self.take(cloud, origin_m, &sighting, |offset| turn * offset);
        }
    }

    /// Gathers runs of points that fall into one voxel, as neighbours in an image mostly do.
    fn take(
        &mut self,
        cloud: &PlacedCloud,
        origin_m: DVec3,
        sighting: &Sighting,
        turned: impl Fn(Vec3) -> Vec3,
    ) {
        // The origin's cell in whole numbers; from its corner on, f32 is exact enough.
        let (corner, inside) = self.grid.locate(origin_m);
        let (start, edges_per_m) = (inside.as_vec3(), (1.0 / self.grid.edge_m()) as f32);
        let mut gathered = Gathered::default();
        let mut current: Option<CellKey> = None;
        let mut run = Run::default();
        for point in cloud.points() {
            let edges = turned(Vec3::from_array(point.offset_m)) * edges_per_m + start;
            let (cell, inside) = floor(edges);
            let key = CellKey::of([0, 1, 2].map(|axis| corner[axis].wrapping_add(cell[axis])));
            if key != current || run.is_full() {
                self.hand_on(current, run, &mut gathered, sighting);
                (current, run) = (key, Run::default());
            }
            run.add(inside, point.colour);
        }
        self.hand_on(current, run, &mut gathered, sighting);
        self.flush(&mut gathered, sighting);
    }

    /// Lays a run with the others, and hands all to their voxels once there are enough.
    #[inline]
    fn hand_on(
        &mut self,
        key: Option<CellKey>,
        run: Run,
        gathered: &mut Gathered,
        sighting: &Sighting,
    ) {
        let points = u64::from(run.count());
        let Some(key) = key else {
            self.counts.beyond_grid += points;
            return;
        };
        self.counts.points += points;
        gathered.push(key, run);
        if gathered.is_full() {
            self.flush(gathered, sighting);
        }
    }

    /// Hands runs to their voxels.
    ///
    /// In three rounds, because each look into table and voxels is most likely a cache miss: within a round no
    /// look depends on another, so that the processor has many under way at a time.
    fn flush(&mut self, gathered: &mut Gathered, sighting: &Sighting) {
        let runs = gathered.runs();
        let mut guesses = [None; GATHERED];
        for (guess, (key, _)) in guesses.iter_mut().zip(runs) {
            *guess = self.table.guess(key.hash());
        }
        for (guess, (key, _)) in guesses.iter_mut().zip(runs) {
            *guess = guess.filter(|&slot| self.is_in(slot, *key));
        }
        for (guess, (key, run)) in guesses.iter().zip(runs) {
            // An earlier run of this round may have needed the slot.
            let slot = match guess.filter(|&slot| self.is_in(slot, *key)) {
                Some(slot) => slot as usize,
                None => self.slot(*key),
            };
            self.voxels[slot].take(run, sighting);
        }
        gathered.clear();
    }

    #[inline]
    fn is_in(&self, slot: u32, key: CellKey) -> bool {
        self.voxels.get(slot as usize).is_some_and(|voxel| voxel.key == key)
    }

    /// The slot of a voxel, made if there is none.
    fn slot(&mut self, key: CellKey) -> usize {
        let hash = key.hash();
        if let Some(slot) = self.table.find(hash, |slot| self.is_in(slot, key)) {
            return slot as usize;
        }
        let slot = if self.voxels.len() < self.settings.max_voxels {
            self.voxels.push(Voxel::new(key));
            self.voxels.len() - 1
        } else {
            let slot = self.forget();
            self.voxels[slot] = Voxel::new(key);
            slot
        };
        self.table.insert(hash, slot as u32);
        slot
    }

    /// Forgets one voxel of a full map and gives its slot.
    fn forget(&mut self) -> usize {
        let mut oldest = self.hand;
        for _ in 0..LOOKED_AT.min(self.voxels.len()) {
            let at = self.hand;
            self.hand = (at + 1) % self.voxels.len();
            if !core::mem::take(&mut self.voxels[at].seen_lately) {
                oldest = at;
                break;
            }
            if self.voxels[at].last_seen_ms < self.voxels[oldest].last_seen_ms {
                oldest = at;
            }
        }
        self.table.remove(self.voxels[oldest].key.hash(), oldest as u32);
        self.counts.evicted += 1;
        oldest
    }
}

/// Runs that wait to be handed to their voxels together.
#[derive(Debug)]
struct Gathered {
    runs: [(CellKey, Run); GATHERED],
    count: usize,
}

impl Default for Gathered {
    fn default() -> Self {
        Self { runs: [(CellKey::ORIGIN, Run::default()); GATHERED], count: 0 }
    }
}

impl Gathered {
    #[inline]
    const fn push(&mut self, key: CellKey, run: Run) {
        self.runs[self.count] = (key, run);
        self.count += 1;
    }

    #[inline]
    const fn is_full(&self) -> bool {
        self.count == GATHERED
    }

    fn runs(&self) -> &[(CellKey, Run)] {
        &self.runs[..self.count]
    }

    const fn clear(&mut self) {
        self.count = 0;
    }
}

/// Whole cells and the rest, 0 to 1, for each axis.
#[inline]
fn floor(edges: Vec3) -> ([i64; 3], [f32; 3]) {
    // `f32::floor` is a call into the system's library where SSE4.1 is not taken for granted.
    let cell = edges.to_array().map(|e| {
        let whole = e as i32;
        i64::from(whole) - i64::from(e < whole as f32)
    });
    let rest = [0, 1, 2].map(|axis| edges[axis] - cell[axis] as f32);
    (cell, rest)
}

#[cfg(test)]
mod tests;
