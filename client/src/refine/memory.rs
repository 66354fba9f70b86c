//! What a camera has seen lately.

use std::collections::HashMap;

use core::time::Duration;

use glam::DVec3;

use crate::frame::World;
use crate::merge::{PlacedCloud, VoxelMap, VoxelMapError, VoxelMapSettings};
use crate::transform::Transform;

/// Two maps: the one being filled, and the one before it. So what is older than twice a span is forgotten,
/// and memory is bounded.
#[derive(Debug)]
pub(super) struct Memory {
    current: VoxelMap,
    before: VoxelMap,
    span_ns: i64,
    begun_ns: Option<i64>,
    clouds: u64,
}

/// Fewer points than these in a voxel may be stray; fewer clouds do not tell.
const SOLID: u32 = 3;

impl Memory {
    pub(super) fn new(size: VoxelMapSettings, span: Duration) -> Result<Self, VoxelMapError> {
        let span_ns = i64::try_from(span.as_nanos()).unwrap_or(i64::MAX);
        let (current, before) = (VoxelMap::new(size)?, VoxelMap::new(size)?);
        Ok(Self { current, before, span_ns, begun_ns: None, clouds: 0 })
    }

    pub(super) fn insert(&mut self, cloud: &PlacedCloud, correction: Transform<World, World>) {
        let now_ns = cloud.info().time_ns();
        if now_ns.saturating_sub(*self.begun_ns.get_or_insert(now_ns)) > self.span_ns {
            core::mem::swap(&mut self.current, &mut self.before);
            self.current.clear();
            self.begun_ns = Some(now_ns);
        }
        self.current.insert_corrected(cloud, correction);
        self.clouds += 1;
    }

    pub(super) fn clear(&mut self) {
        self.current.clear();
        self.before.clear();
        (self.begun_ns, self.clouds) = (None, 0);
    }

    /// Whether enough was seen for a surface to be solid.
    pub(super) const fn is_solid(&self) -> bool {
        self.clouds >= SOLID as u64
    }

    /// Adds what it holds in a box to a surface.
    pub(super) fn collect(&self, within: &Box3, surface: &mut Gathered) {
        for voxel in self.current.voxels().chain(self.before.voxels()) {
            if voxel.points >= SOLID && within.contains(voxel.position_m) {
                surface.add(voxel.position_m, f64::from(voxel.points));
            }
        }
    }
}

/// An axis-parallel box, m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Box3 {
    low: DVec3,
    high: DVec3,
}

impl Box3 {
    /// Around points, with a margin, m.
    pub(super) fn around(points: impl Iterator<Item = DVec3>, margin_m: f64) -> Self {
        let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = points.fold(none, |(low, high), p| (low.min(p), high.max(p)));
        Self { low: low - margin_m, high: high + margin_m }
    }

    fn contains(&self, point: DVec3) -> bool {
        point.cmpge(self.low).all() && point.cmple(self.high).all()
    }
}

/// Means of what several maps hold in the same voxels, so that points stay evenly spaced.
#[derive(Debug)]
pub(super) struct Gathered {
    voxel_m: f64,
    cells: HashMap<[i64; 3], (DVec3, f64)>,
}

impl Gathered {
    pub(super) fn new(voxel_m: f64) -> Self {
        Self { voxel_m, cells: HashMap::new() }
    }

    fn add(&mut self, position: DVec3, weight: f64) {
        let cell = (position / self.voxel_m).floor().to_array().map(|c| c as i64);
        let (sum, total) = self.cells.entry(cell).or_insert((DVec3::ZERO, 0.0));
        *sum += position * weight;
        *total += weight;
    }

    /// Positions, m, and weights, in an order that does not depend on the hash.
    pub(super) fn points(self) -> Vec<(DVec3, f64)> {
        let mut cells: Vec<_> = self.cells.into_iter().collect();
        cells.sort_unstable_by_key(|(cell, _)| *cell);
        cells.into_iter().map(|(_, (sum, total))| (sum / total, total)).collect()
    }
}
