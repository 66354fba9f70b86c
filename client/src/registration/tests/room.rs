//! A small ray-cast world of boxes, seen by depth cameras with noise.

use glam::{DQuat, DVec3};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::frame::{Body, Rotation, World};
use crate::transform::{Transform, body_from_optical_axes};

/// Noise of the test's cameras, 1/m.
pub(super) const NOISE_PER_M: f64 = 0.0025;

/// Axis-parallel boxes, from one corner to the other, m; seen from inside or outside.
#[derive(Clone, Debug)]
pub(super) struct Room(Vec<(DVec3, DVec3)>);

impl Room {
    pub(super) fn boxes(boxes: &[([f64; 3], [f64; 3])]) -> Self {
        Self(boxes.iter().map(|(a, b)| (DVec3::from_array(*a), DVec3::from_array(*b))).collect())
    }

    /// Six metres by five, with a cupboard, a table and a pillar.
    pub(super) fn furnished() -> Self {
        Self::boxes(&[
            ([-3.0, -2.5, 0.0], [3.0, 2.5, 2.6]),
            ([2.3, -1.5, 0.0], [3.0, -0.3, 2.0]),
            ([0.6, 1.2, 0.0], [1.8, 2.2, 0.75]),
            ([-1.4, 2.0, 0.0], [-1.0, 2.5, 2.6]),
        ])
    }

    /// First hit of a ray, in multiples of its direction.
    fn hit(&self, from: DVec3, ray: DVec3) -> Option<f64> {
        let hits = self.0.iter().filter_map(|(low, high)| {
            let (a, b) = ((*low - from) / ray, (*high - from) / ray);
            let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
            let first = if enter > 1e-6 { enter } else { leave };
            (enter <= leave && first > 1e-6).then_some(first)
        });
        hits.min_by(f64::total_cmp)
    }

    /// What a camera sees, in its body frame, m: 85° wide, 54° high, row by row.
    pub(super) fn scan(
        &self,
        world_from_body: Transform<World, Body>,
        (columns, rows): (u32, u32),
        noise_per_m: f64,
        rng: &mut ChaCha8Rng,
    ) -> Vec<DVec3> {
        let world_from_optical = world_from_body * body_from_optical_axes();
        let mut seen = Vec::new();
        for pixel in 0..columns * rows {
            let across = (f64::from(pixel % columns) + 0.5) / f64::from(columns) * 2.0 - 1.0;
            let down = (f64::from(pixel / columns) + 0.5) / f64::from(rows) * 2.0 - 1.0;
            let ray = DVec3::new(across * 0.92, down * 0.51, 1.0);
            let in_world = world_from_optical.rotation().apply(ray);
            if let Some(depth) = self.hit(world_from_optical.origin(), in_world) {
                let error: f64 = StandardNormal.sample(rng);
                let noisy = depth + noise_per_m * depth * depth * error;
                seen.push(body_from_optical_axes().apply(ray * noisy));
            }
        }
        seen
    }
}

/// A camera somewhere, looking along a yaw (from east, rad) and a pitch (downwards, rad).
pub(super) fn camera(at: [f64; 3], yaw: f64, pitch: f64) -> Transform<World, Body> {
    let rotation = DQuat::from_rotation_z(yaw) * DQuat::from_rotation_y(pitch);
    Transform::new(Rotation::from_unit(rotation), DVec3::from_array(at))
}

/// Means of the points in each cube, as a voxel map has them, m, and their number.
pub(super) fn voxels(points: &[DVec3], edge_m: f64) -> Vec<(DVec3, f64)> {
    let mut cells = std::collections::BTreeMap::new();
    for point in points {
        let key = (*point / edge_m).floor().to_array().map(|c| c as i64);
        let (sum, count) = cells.entry(key).or_insert((DVec3::ZERO, 0.0));
        *sum += *point;
        *count += 1.0;
    }
    cells.values().map(|(sum, count)| (*sum / *count, *count)).collect()
}

/// Three independent normal deviates.
pub(super) fn normal3(rng: &mut ChaCha8Rng) -> DVec3 {
    DVec3::from_array(core::array::from_fn(|_| StandardNormal.sample(rng)))
}
