//! Which plane of the target each point of the source belongs to.

use glam::DVec3;
use nalgebra::Vector6;

use super::correction::Correction;
use super::plane::Plane;
use super::residual::{distance_m, jacobian};
use super::source::SourcePoint;
use super::surface::SurfaceMap;

/// A source point and its plane; residual and Jacobian in standard deviations of their noise.
#[derive(Clone, Copy, Debug)]
pub(super) struct Match {
    /// Index of the plane.
    pub(super) plane: u32,
    /// Index of the point.
    pub(super) point: u32,
    /// Patch of the target's surface.
    pub(super) patch: u32,
    /// Standard deviation of the distance, m.
    pub(super) sigma_m: f64,
    /// From the body to the point as it is moved, m.
    pub(super) arm: DVec3,
    /// Distance to the plane over its standard deviation.
    pub(super) residual: f64,
    /// Its change with a step of the correction.
    pub(super) jacobian: Vector6<f64>,
}

/// How far apart a point and its plane may be: the target's spacing, and some standard deviations of the
/// pair, of which one part shrinks from step to step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    /// The shrinking part: standard deviation of what the misalignment still adds, m.
    ///
    /// Without it, near surfaces with little noise would be thrown out as outliers before they had their say.
    pub(super) misaligned_m: f64,
    /// The standard deviations.
    pub(super) sigmas: f64,
}

impl Reach {
    /// Smallest scale of the robust weights. While clouds come closer, a wall that fits already must not
    /// make outliers of a floor that does not yet; in the end, noise may be better than declared.
    pub(super) const fn smallest_scale(&self) -> f64 {
        if self.misaligned_m > 0.0 { 1.0 } else { 0.2 }
    }
}

/// Share of the spacing by which the nearest point of a surface may lie beside.
const BESIDE: f64 = 1.5;
/// What no depth source and no plane goes below, m.
const SMALLEST_SIGMA_M: f64 = 1e-3;

/// Looks for each point's nearest plane; a point without one within reach has no match.
pub(super) fn find(
    source: &[SourcePoint],
    target: &SurfaceMap,
    correction: &Correction,
    reach: Reach,
) -> Vec<Match> {
    let of = |(index, point): (usize, &SourcePoint)| {
        let (plane, square) = target.nearest(correction.apply(point.position));
        let found = evaluate((index as u32, point), (plane, target), correction, reach);
        let limit = reach.sigmas * found.sigma_m + BESIDE * target.spacing_m();
        (square <= limit * limit).then_some(found)
    };
    source.iter().enumerate().filter_map(of).collect()
}

fn evaluate(
    (index, point): (u32, &SourcePoint),
    (plane_index, target): (u32, &SurfaceMap),
    correction: &Correction,
    reach: Reach,
) -> Match {
    let plane = target.plane(plane_index);
    let ray_sigma = ray_sigma_m(point, plane, correction);
    let own = ray_sigma.powi(2) + plane.height_variance_m2 + SMALLEST_SIGMA_M.powi(2);
    let sigma_m = (own + reach.misaligned_m.powi(2)).sqrt();
    Match {
        plane: plane_index,
        point: index,
        patch: target.patch(plane_index) as u32,
        sigma_m,
        arm: correction.arm(point.position),
        residual: distance_m(correction, point.position, plane) / sigma_m,
        jacobian: jacobian(correction, point.position, plane) / sigma_m,
    }
}

/// Standard deviation of the distance to the plane from the noise along the ray, m.
///
/// It is that of a point where the ray meets the plane. Were it taken where the noise has put the point,
/// those that happen to be too near would count more than those too far, with the square of depth in σ by
/// four times the relative error: a bias of `4 σ²/z`, millimetres at a few metres.
fn ray_sigma_m(point: &SourcePoint, plane: &Plane, correction: &Correction) -> f64 {
    let across = plane.normal.dot(correction.turn(point.ray));
    let expected = across - distance_m(correction, point.position, plane);
    let ratio = (expected / across).clamp(0.5, 2.0);
    let ratio = if ratio.is_finite() { ratio } else { 1.0 };
    across * point.sigma_per_range * ratio * ratio
}
