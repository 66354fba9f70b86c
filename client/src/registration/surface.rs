//! The cloud that another one is laid over: points on planes, found by place.

use std::collections::HashMap;
use std::num::NonZero;

use glam::DVec3;
use kiddo::{ImmutableKdTree, SquaredEuclidean};

use super::error::RegistrationError;
use super::plane::Plane;

/// How planes are found in a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceSettings {
    /// Points that make a plane, its own included. Fewer follow small surfaces, more average noise.
    pub neighbours: NonZero<usize>,
    /// Points that make a plane where the fewer are too noisy to be one.
    pub many_neighbours: NonZero<usize>,
    /// Neighbours further away than this do not belong to it, m.
    pub radius_m: f64,
    /// Planes looked for at most, around points evenly out of all; all points are neighbours.
    pub planes: usize,
    /// From which planarity on neighbours are a plane, 0 to 1.
    pub planarity: f64,
}

impl Default for SurfaceSettings {
    /// For voxels of about 5 cm.
    fn default() -> Self {
        let count = |n| NonZero::new(n).unwrap_or(NonZero::<usize>::MIN);
        Self {
            neighbours: count(20),
            many_neighbours: count(80),
            radius_m: 0.4,
            planes: 20_000,
            planarity: 0.5,
        }
    }
}

/// Fewest neighbours that tell a plane from chance.
const FEWEST_NEIGHBOURS: usize = 8;
/// Fewest points on planes that make a target.
const FEWEST_POINTS: usize = 200;
/// Ratio of the variances of distances to a plane up to which both are its noise.
const SAME_THICKNESS: f64 = 1.7;
/// Edge of a patch, in radii of a neighbourhood: beyond that, no two planes share neighbours.
const PATCH_RADII: f64 = 2.0;

/// The surfaces of a target cloud.
///
/// Its points should be thinned to an even spacing well above their noise, such as voxel centroids: the
/// plane through 20 neighbours is only as good as they are wide.
#[derive(Debug)]
pub struct SurfaceMap {
    planes: Vec<Plane>,
    patches: Vec<u32>,
    patch_count: usize,
    spacing_m: f64,
    tree: Tree,
}

impl SurfaceMap {
    /// Finds the planes in points of the world, m, each with its weight: the measurements that it stands
    /// for. Points that are not finite or on no plane are left out.
    ///
    /// # Errors
    /// [`RegistrationError::TooFewPoints`] if hardly any is on a plane.
    pub fn new(
        points: impl IntoIterator<Item = (DVec3, f64)>,
        settings: &SurfaceSettings,
    ) -> Result<Self, RegistrationError> {
        let usable = |(point, weight): &(DVec3, f64)| {
            point.is_finite() && *weight > 0.0 && weight.is_finite()
        };
        let cloud = Cloud::new(points.into_iter().filter(usable).collect())?;
        let step = cloud.points.len().div_ceil(settings.planes.max(1)).max(1);
        let around = (0..cloud.points.len()).step_by(step);
        let found = around.filter_map(|at| cloud.plane(at, settings));
        let (planes, radii): (Vec<Plane>, Vec<f64>) = found.unzip();
        if planes.len() < FEWEST_POINTS {
            let (found, needed) = (planes.len(), FEWEST_POINTS);
            return Err(RegistrationError::TooFewPoints { cloud: "target", found, needed });
        }
        Self::of_planes(planes, radii, (step, settings))
    }

    fn of_planes(
        planes: Vec<Plane>,
        mut radii: Vec<f64>,
        (step, settings): (usize, &SurfaceSettings),
    ) -> Result<Self, RegistrationError> {
        let middle = radii.len() / 2;
        let radius = *radii.select_nth_unstable_by(middle, f64::total_cmp).1;
        // k points of one surface at spacing s fill a disc: k s² = π r². Of those, one in `step` has a plane.
        let filled = std::f64::consts::PI * step as f64 / settings.neighbours.get() as f64;
        let spacing_m = radius * filled.sqrt();
        let (patches, patch_count) = patches(&planes, PATCH_RADII * radius);
        let tree = index(planes.iter().map(|plane| plane.point))?;
        Ok(Self { planes, patches, patch_count, spacing_m, tree })
    }

    /// Points that lie on planes.
    pub fn len(&self) -> usize {
        self.planes.len()
    }

    /// Whether there are none; a map that was made is never empty.
    pub fn is_empty(&self) -> bool {
        self.planes.is_empty()
    }

    /// Typical distance between neighbouring points, m.
    pub const fn spacing_m(&self) -> f64 {
        self.spacing_m
    }

    /// Pieces of the surface whose planes share no neighbours.
    pub(super) const fn patch_count(&self) -> usize {
        self.patch_count
    }

    pub(super) fn plane(&self, index: u32) -> &Plane {
        &self.planes[index as usize]
    }

    pub(super) fn patch(&self, index: u32) -> usize {
        self.patches[index as usize] as usize
    }

    /// The plane whose point is nearest, and the square of its distance, m².
    pub(super) fn nearest(&self, point: DVec3) -> (u32, f64) {
        let query = point.to_array();
        let found = self.tree.query(&query).nearest_one::<SquaredEuclidean<f64>>().execute();
        (found.item, found.distance)
    }
}

type Tree = ImmutableKdTree<f64, 3>;

fn index(points: impl Iterator<Item = DVec3>) -> Result<Tree, RegistrationError> {
    let rows: Vec<[f64; 3]> = points.map(|point| point.to_array()).collect();
    Tree::new_from_slice(&rows)
        .map_err(|error| RegistrationError::Index { what: error.to_string() })
}

/// Points with their weights, found by place.
struct Cloud {
    points: Vec<(DVec3, f64)>,
    tree: Tree,
}

impl Cloud {
    fn new(points: Vec<(DVec3, f64)>) -> Result<Self, RegistrationError> {
        let tree = index(points.iter().map(|(point, _)| *point))?;
        Ok(Self { points, tree })
    }

    /// The plane around a point, and how far its few nearest neighbours reach, m.
    ///
    /// Where few neighbours show none, noise may hide it, and many show it with the same thickness. At an
    /// edge they are thicker, and it is left out.
    fn plane(&self, at: usize, settings: &SurfaceSettings) -> Option<(Plane, f64)> {
        let (near, radius) = self.neighbours(at, settings.neighbours, settings);
        if near.len() < FEWEST_NEIGHBOURS.min(settings.neighbours.get()) {
            return None;
        }
        let (few, planarity) = Plane::fit(self.points[at].0, &near);
        if planarity >= settings.planarity {
            return Some((few, radius));
        }
        let (near, _) = self.neighbours(at, settings.many_neighbours, settings);
        let (many, planarity) = Plane::fit(self.points[at].0, &near);
        let same = many.thickness_m2 < SAME_THICKNESS * few.thickness_m2;
        (planarity >= settings.planarity && same).then_some((many, radius))
    }

    fn neighbours(
        &self,
        at: usize,
        count: NonZero<usize>,
        settings: &SurfaceSettings,
    ) -> (Vec<(DVec3, f64)>, f64) {
        let query = self.points[at].0.to_array();
        let found = self
            .tree
            .query(&query)
            .nearest_n::<SquaredEuclidean<f64>>(count)
            .within(settings.radius_m * settings.radius_m)
            .execute();
        let radius = found.last().map_or(0.0, |furthest| furthest.distance.sqrt());
        (found.iter().map(|near| self.points[near.item as usize]).collect(), radius)
    }
}

/// Numbers the pieces of surface: cubes of some edge, by the axis that the normal is nearest to.
fn patches(planes: &[Plane], edge_m: f64) -> (Vec<u32>, usize) {
    let mut numbers: HashMap<([i64; 3], usize), u32> = HashMap::new();
    let mut number = |plane: &Plane| {
        let cell = (plane.point / edge_m.max(1e-3)).floor().to_array().map(|c| c as i64);
        let facing = plane.normal.abs().to_array();
        let axis = usize::from(facing[1] > facing[0]);
        let axis = if facing[2] > facing[axis] { 2 } else { axis };
        let next = numbers.len() as u32;
        *numbers.entry((cell, axis)).or_insert(next)
    };
    let patches = planes.iter().map(&mut number).collect();
    (patches, numbers.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn floor() -> Vec<(DVec3, f64)> {
        let at = |i| DVec3::new(f64::from(i % 50), f64::from(i / 50), 20.0) * 0.05;
        (0..2_500).map(|i| (at(i), 1.0)).collect()
    }

    #[test]
    fn a_floor_has_its_spacing_and_patches() {
        let map = SurfaceMap::new(floor(), &SurfaceSettings::default()).unwrap();
        assert!((map.spacing_m() - 0.05).abs() < 0.01, "{}", map.spacing_m());
        assert!(map.len() > 2_000 && map.patch_count() > 50);
        let (index, square) = map.nearest(DVec3::new(1.01, 1.02, 1.1));
        assert!(map.plane(index).normal.z.abs() > 0.999_999);
        assert!(square < 0.1_f64.powi(2) + 0.04_f64.powi(2));
    }

    #[test]
    fn fewer_planes_are_further_apart() {
        let settings = SurfaceSettings { planes: 625, ..SurfaceSettings::default() };
        let map = SurfaceMap::new(floor(), &settings).unwrap();
        assert!((500..=625).contains(&map.len()), "{}", map.len());
        assert!((map.spacing_m() - 0.1).abs() < 0.02, "{}", map.spacing_m());
    }

    #[test]
    fn points_that_are_not_numbers_do_not_count() {
        let mut points = floor();
        points.extend([(DVec3::NAN, 1.0); 50]);
        points.extend([(DVec3::ONE, f64::NAN); 50]);
        let map = SurfaceMap::new(points, &SurfaceSettings::default()).unwrap();
        assert!(map.len() <= 2_500);
    }

    #[test]
    fn nothing_and_almost_nothing_make_no_target() {
        for count in [0, 1, 100] {
            let few = floor().into_iter().take(count);
            let error = SurfaceMap::new(few, &SurfaceSettings::default()).unwrap_err();
            assert!(matches!(error, RegistrationError::TooFewPoints { cloud: "target", .. }));
        }
    }
}
