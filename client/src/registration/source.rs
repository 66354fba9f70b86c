//! The cloud that is laid over the target.

use glam::DVec3;

use crate::frame::{Optical, World};
use crate::transform::Transform;

/// Noise of a depth source: along the ray, growing with the square of depth, as of a stereo camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthNoise {
    sigma_per_m: f64,
}

impl DepthNoise {
    /// What the maker of the ZED 2 promises: 1 % at 3 m, 5 % at 15 m; 0.0033 of the depth squared in both.
    pub const ZED2: Self = Self { sigma_per_m: 0.01 / 3.0 };

    /// Takes [`lodestone_schema::CloudHeader::depth_sigma_per_m`], 1/m; what is not known
    /// (`NaN`, zero, negative) becomes [`DepthNoise::ZED2`].
    pub fn from_header(depth_sigma_per_m: f32) -> Self {
        let sigma_per_m = f64::from(depth_sigma_per_m);
        if sigma_per_m > 0.0 && sigma_per_m.is_finite() { Self { sigma_per_m } } else { Self::ZED2 }
    }

    /// Standard deviation along the ray at a depth, m.
    pub fn sigma_m(self, depth_m: f64) -> f64 {
        self.sigma_per_m * depth_m * depth_m
    }
}

/// A point and how it may be wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SourcePoint {
    /// Where the prior has it in the world, m.
    pub(super) position: DVec3,
    /// From the lens to it by the prior, m.
    pub(super) ray: DVec3,
    /// Standard deviation of its distance from the lens over that distance.
    pub(super) sigma_per_range: f64,
}

/// A cloud in the world as the prior has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SourceCloud {
    points: Vec<SourcePoint>,
}

impl SourceCloud {
    /// Takes points in the world by the prior pose, m, and the lens that saw them, by the same pose.
    /// Points that are not finite or not in front of the lens are left out.
    pub fn new(
        world_from_optical: Transform<World, Optical>,
        points: impl IntoIterator<Item = DVec3>,
        noise: DepthNoise,
    ) -> Self {
        let axis = world_from_optical.rotation().apply(DVec3::Z);
        Self::seen_from((world_from_optical.origin(), axis), points, noise)
    }

    /// The same, from a lens and the direction it looks in the world.
    pub(crate) fn seen_from(
        (lens, axis): (DVec3, DVec3),
        points: impl IntoIterator<Item = DVec3>,
        noise: DepthNoise,
    ) -> Self {
        let point = |position: DVec3| {
            let ray = position - lens;
            let depth = axis.dot(ray);
            let seen = position.is_finite() && depth > 0.0;
            let sigma_per_range = noise.sigma_m(depth) / ray.length();
            seen.then_some(SourcePoint { position, ray, sigma_per_range })
        };
        Self { points: points.into_iter().filter_map(point).collect() }
    }

    /// Usable points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there is no usable point.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// At most so many points, evenly out of all.
    pub(super) fn thinned(&self, limit: usize) -> Vec<SourcePoint> {
        let step = (self.points.len() as f64 / limit.max(1) as f64).max(1.0);
        let count = (self.points.len() as f64 / step) as usize;
        (0..count).map(|i| self.points[(i as f64 * step) as usize]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Rotation;

    #[test]
    fn what_is_not_there_is_left_out_and_far_points_count_less() {
        let lens = Transform::new(Rotation::IDENTITY, DVec3::X);
        let points =
            [DVec3::NAN, DVec3::ZERO, DVec3::new(1.0, 0.0, 2.0), DVec3::new(1.0, 0.0, 4.0)];
        let cloud = SourceCloud::new(lens, points, DepthNoise::from_header(0.01));
        let sigmas: Vec<_> =
            cloud.thinned(9).iter().map(|p| p.ray.length() * p.sigma_per_range).collect();
        assert!((sigmas[0] - 0.04).abs() < 1e-8 && (sigmas[1] - 0.16).abs() < 1e-8, "{sigmas:?}");
        assert_eq!(cloud.thinned(1).len(), 1);
    }

    #[test]
    fn noise_that_is_not_known_is_that_of_the_data_sheet() {
        for unknown in [f32::NAN, 0.0, -1.0, f32::INFINITY] {
            assert_eq!(DepthNoise::from_header(unknown), DepthNoise::ZED2);
        }
        assert!((DepthNoise::ZED2.sigma_m(3.0) - 0.03).abs() < 1e-12);
        assert!((DepthNoise::ZED2.sigma_m(15.0) - 0.75).abs() < 1e-12);
    }
}
