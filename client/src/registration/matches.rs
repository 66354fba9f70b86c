//! Which plane of the target each point of the source belongs to.

use glam::DVec3;
use nalgebra::Vector6;

use super::correction::Correction;
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

/// How far apart a point and its plane may be: the target's spacing, and the larger of a distance that
/// shrinks from step to step and some standard deviations of the pair.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    /// The shrinking distance, m.
    pub(super) distance_m: f64,
    /// The standard deviations.
    pub(super) sigmas: f64,
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
        let found = evaluate(index as u32, point, plane, target, correction);
        let away = reach.distance_m.max(reach.sigmas * found.sigma_m);
        let limit = away + BESIDE * target.spacing_m();
        (square <= limit * limit).then_some(found)
    };
    source.iter().enumerate().filter_map(of).collect()
}

fn evaluate(
    index: u32,
    point: &SourcePoint,
    plane_index: u32,
    target: &SurfaceMap,
    correction: &Correction,
) -> Match {
    let plane = target.plane(plane_index);
    let variance = plane.normal.dot(point.ray_sigma).powi(2)
        + plane.height_variance_m2
        + SMALLEST_SIGMA_M.powi(2);
    let sigma_m = variance.sqrt();
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
