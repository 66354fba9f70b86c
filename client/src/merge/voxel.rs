//! One voxel: what was seen in it.

use glam::DVec3;

use super::grid::{CellKey, Grid};

/// Colours stop to be added here: 255 times as much still fits 32 bits, and the mean no longer moves.
const MOST_COLOURED: u32 = 1 << 24;

/// What was seen in one voxel; one cache line.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Voxel {
    pub(super) key: CellKey,
    /// Sum of the points' distances from the lower corner, in edges.
    sum: [f64; 3],
    colour_sum: [u32; 3],
    /// Points; stops at the largest number.
    count: u32,
    coloured: u32,
    /// Clouds in which it was seen; stops at the largest number.
    clouds: u32,
    /// Time of the last cloud in which it was seen, ms after the map's first.
    pub(super) last_seen_ms: u32,
    /// One bit for each camera.
    cameras: u16,
    /// Seen since the last look for something to forget.
    pub(super) seen_lately: bool,
}

const _: () = assert!(size_of::<Voxel>() == 64, "a voxel is not one cache line");

/// Neighbouring points of one cloud that fall into one voxel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Run {
    sum: [f64; 3],
    colour_sum: [u32; 3],
    count: u32,
}

impl Run {
    /// Takes a point, in edges from the lower corner.
    #[inline]
    pub(super) fn add(&mut self, inside: [f32; 3], colour: [u8; 4]) {
        for axis in 0..3 {
            self.sum[axis] += f64::from(inside[axis]);
            // Before these overflow, `is_full` says so.
            self.colour_sum[axis] += u32::from(colour[axis]);
        }
        self.count += 1;
    }

    /// Whether its sums must be handed on before more is added.
    #[inline]
    pub(super) const fn is_full(&self) -> bool {
        self.count >= MOST_COLOURED
    }

    pub(super) const fn count(&self) -> u32 {
        self.count
    }
}

/// The cloud that a run is part of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sighting {
    /// Index of the camera.
    pub(super) camera: u32,
    pub(super) has_colour: bool,
    /// Time of the cloud, ms after the map's first.
    pub(super) time_ms: u32,
}

impl Voxel {
    /// A voxel in which nothing was seen yet.
    pub(super) const fn new(key: CellKey) -> Self {
        Self {
            key,
            sum: [0.0; 3],
            colour_sum: [0; 3],
            count: 0,
            coloured: 0,
            clouds: 0,
            last_seen_ms: 0,
            cameras: 0,
            seen_lately: false,
        }
    }

    /// Takes points.
    #[inline]
    pub(super) fn take(&mut self, run: &Run, sighting: &Sighting) {
        for axis in 0..3 {
            self.sum[axis] += run.sum[axis];
        }
        // The first run of this cloud here: another cloud has another millisecond, or hardly ever the same.
        let is_first = self.clouds == 0 || self.last_seen_ms != sighting.time_ms;
        self.clouds = self.clouds.saturating_add(u32::from(is_first));
        self.count = self.count.saturating_add(run.count);
        self.last_seen_ms = sighting.time_ms;
        self.cameras |= 1 << sighting.camera;
        self.seen_lately = true;
        if sighting.has_colour && self.coloured + run.count <= MOST_COLOURED {
            self.coloured += run.count;
            for axis in 0..3 {
                self.colour_sum[axis] += run.colour_sum[axis];
            }
        }
    }

    /// The voxel as others see it; `start_ns` is the time of the map's first cloud.
    pub(super) fn view(&self, grid: Grid, start_ns: i64) -> VoxelView {
        let mean = DVec3::from_array(self.sum) / f64::from(self.count.max(1));
        let channel = |sum: u32| ((sum + self.coloured / 2) / self.coloured.max(1)) as u8;
        VoxelView {
            position_m: grid.place_m(self.key.cell(), mean),
            colour: (self.coloured > 0).then(|| self.colour_sum.map(channel)),
            points: self.count,
            clouds: self.clouds,
            cameras: self.cameras,
            last_seen_ns: start_ns.saturating_add(i64::from(self.last_seen_ms) * 1_000_000),
        }
    }
}

/// What was seen in one voxel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoxelView {
    /// Mean of the points in it, in the world, m.
    pub position_m: DVec3,
    /// Mean colour of the points that have one: red, green, blue.
    pub colour: Option<[u8; 3]>,
    /// Points seen in it.
    pub points: u32,
    /// Clouds it was seen in.
    pub clouds: u32,
    /// Cameras it was seen by, one bit for each in the merger's order.
    pub cameras: u16,
    /// Time of the last cloud it was seen in, `CLOCK_MONOTONIC`, to the millisecond, ns.
    pub last_seen_ns: i64,
}

impl VoxelView {
    /// Whether a camera has seen it, by its index in the merger.
    pub const fn is_seen_by(&self, camera: usize) -> bool {
        camera < u16::BITS as usize && self.cameras >> camera & 1 == 1
    }
}
