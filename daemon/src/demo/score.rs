//! How far a cloud is from the surfaces that it shows.
//!
//! Each voxel of a merged cloud is the mean of the points in it and counts as many times as it has points. Points
//! near the way of what moves are left out: in a cloud of many seconds there is no one place where it was.

use glam::DVec3;
use serde::Serialize;

use super::cloud_file::Voxel;
use super::rigid::{RigidMotion, fit};
use crate::scene::Scene;

/// What is closer than this to the way of what moves is left out, m.
const MOVER_MARGIN_M: f64 = 0.15;
/// Voxels by which a common motion is found; more do not make it better.
const FITTED: usize = 5_000;

/// Distances to the nearest surface, each voxel counted by its points, m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Distances {
    /// Root mean square.
    pub rmse_m: f64,
    /// Half are below.
    pub median_m: f64,
    /// 95 % are below.
    pub p95_m: f64,
}

/// A cloud against the truth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Score {
    /// Points that count.
    pub points: u64,
    /// Share of all points that were left out because of what moves.
    pub left_out: f64,
    /// In the world, as it is.
    pub in_world: Distances,
    /// After the one rigid motion of the whole cloud that makes it fit best.
    pub without_common_motion: Distances,
    /// That motion: the turn, degrees.
    pub common_turn_deg: f64,
    /// That motion: the shift, m.
    pub common_shift_m: f64,
}

/// Scores a cloud; `None` if no point counts.
pub fn score(voxels: &[Voxel], scene: &Scene) -> Option<Score> {
    let all: u64 = voxels.iter().map(|voxel| u64::from(voxel.points)).sum();
    let counts = |voxel: &&Voxel| !scene.is_swept(voxel.position_m, MOVER_MARGIN_M);
    let still: Vec<(DVec3, f64)> = voxels
        .iter()
        .filter(counts)
        .map(|voxel| (voxel.position_m, f64::from(voxel.points)))
        .collect();
    let to_surface = |point| scene.distance_m(point, None);
    let thinned: Vec<_> = still.iter().copied().step_by(still.len() / FITTED + 1).collect();
    let common = fit(&thinned, to_surface)?;
    let points = still.iter().map(|(_, points)| *points as u64).sum::<u64>();
    Some(Score {
        points,
        left_out: 1.0 - points as f64 / all as f64,
        in_world: Distances::of(&still, to_surface)?,
        without_common_motion: Distances::of(&moved(&still, &common), to_surface)?,
        common_turn_deg: common.angle_rad().to_degrees(),
        common_shift_m: common.shift_m(),
    })
}

fn moved(points: &[(DVec3, f64)], motion: &RigidMotion) -> Vec<(DVec3, f64)> {
    points.iter().map(|(point, weight)| (motion.apply(*point), *weight)).collect()
}

impl Distances {
    fn of(points: &[(DVec3, f64)], distance_m: impl Fn(DVec3) -> f64) -> Option<Self> {
        let mut all: Vec<(f64, f64)> =
            points.iter().map(|(point, weight)| (distance_m(*point), *weight)).collect();
        all.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let total: f64 = all.iter().map(|(_, weight)| weight).sum();
        let squares: f64 = all.iter().map(|(distance, weight)| weight * distance * distance).sum();
        Some(Self {
            rmse_m: (squares / total).sqrt(),
            median_m: quantile(&all, 0.5 * total)?,
            p95_m: quantile(&all, 0.95 * total)?,
        })
    }
}

/// The distance below which a weight lies; `sorted` by distance.
fn quantile(sorted: &[(f64, f64)], wanted: f64) -> Option<f64> {
    let mut below = 0.0;
    let reached = |(_, weight): &&(f64, f64)| {
        below += weight;
        below >= wanted
    };
    sorted.iter().find(reached).or(sorted.last()).map(|(distance, _)| *distance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodestone_config::model;

    fn scene() -> Scene {
        let room =
            model::Room { size_m: [6.0, 4.0, 2.0], centre_m: [0.0; 3], ..model::Room::default() };
        let mover =
            model::SceneMover { centre_m: [0.0, 0.0, -0.7], ..model::SceneMover::default() };
        Scene::new(&model::Scene { room, mover: Some(mover), ..model::Scene::default() })
    }

    /// Three walls in front of which all points stand by the same distance.
    fn walls(off_m: f64, points: u32) -> Vec<Voxel> {
        let at = |n: i32| {
            let (i, j) = (f64::from(n % 40) / 20.0 - 0.975, f64::from(n / 40 % 40) / 20.0 - 0.975);
            match n / 1600 {
                0 => DVec3::new(3.0 - off_m, 1.9 * i, 0.9 * j),
                1 => DVec3::new(-3.0 + off_m, 1.9 * i, 0.9 * j),
                _ => DVec3::new(2.9 * i, 2.0 - off_m, 0.9 * j),
            }
        };
        (0..4800).map(|n| Voxel { position_m: at(n), points, ..Voxel::default() }).collect()
    }

    #[test]
    fn distances_count_by_points() {
        // Given as many points 10 mm from the walls as 30 mm, in a third of the voxels
        let mut voxels = walls(0.01, 1);
        voxels.extend(walls(0.03, 3).iter().step_by(3));
        let score = score(&voxels, &scene()).unwrap();
        // Then the mean square is that of both alike
        let expected = f64::midpoint(0.01_f64.powi(2), 0.03_f64.powi(2)).sqrt();
        assert!((score.in_world.rmse_m - expected).abs() < 1e-4, "{score:?}");
        assert!((score.in_world.p95_m - 0.03).abs() < 1e-6);
        assert_eq!(score.points, 9600);
    }

    #[test]
    fn what_moves_is_left_out_and_said_so() {
        let mut voxels = walls(0.0, 1);
        // On the mover's way, a metre from its centre.
        let position_m = DVec3::new(1.0, 0.0, -0.7);
        voxels.push(Voxel { position_m, points: 1600, ..Voxel::default() });
        let score = score(&voxels, &scene()).unwrap();
        assert_eq!(score.points, 4800);
        assert!((score.left_out - 0.25).abs() < 1e-12);
        assert!(score.in_world.rmse_m < 1e-9);
    }

    #[test]
    fn a_common_motion_is_told_from_a_misfit() {
        let shifted = |shift: f64| {
            let voxels = walls(0.0, 1).into_iter();
            voxels.map(move |v| Voxel { position_m: v.position_m + DVec3::Y * shift, ..v })
        };
        let together: Vec<Voxel> = shifted(0.05).collect();
        let apart: Vec<Voxel> = shifted(0.05).chain(shifted(-0.05)).collect();
        let [together, apart] = [together, apart].map(|v| score(&v, &scene()).unwrap());
        assert!((together.in_world.rmse_m / apart.in_world.rmse_m - 1.0).abs() < 0.01);
        assert!(together.without_common_motion.rmse_m < 2e-3, "{together:?}");
        assert!((together.common_shift_m - 0.05).abs() < 5e-3);
        assert!(apart.without_common_motion.rmse_m > 0.02, "{apart:?}");
    }

    #[test]
    fn nothing_has_no_score() {
        assert!(score(&[], &scene()).is_none());
    }
}
