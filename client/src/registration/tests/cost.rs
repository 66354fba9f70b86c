//! What a registration costs.

use rustix::time::{ClockId, clock_gettime};

use super::room::{Room, camera, voxels};
use super::scene::{Scene, Sigma};
use crate::registration::{SurfaceMap, SurfaceSettings};

/// This thread's own processor time, ms: other load hardly counts.
fn processor_ms() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 * 1e-6
}

fn cost_ms<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let begin = processor_ms();
    let done = work();
    (done, processor_ms() - begin)
}

#[test]
#[ignore = "prints a figure; nothing that can fail"]
fn five_thousand_points_against_twenty_thousand() {
    let mapped = [camera([-1.5, -1.0, 1.3], 0.5, 0.1), camera([-1.5, -0.8, 1.3], -0.3, 0.2)];
    let truth = camera([-1.0, 0.4, 1.2], 0.1, 0.15);
    let mut scene = Scene::sized(&Room::furnished(), &mapped, truth, ((240, 144), (100, 60), 1));
    let cloud = voxels(&scene.map_points, 0.05);
    for planes in [40_000, 20_000, 8_000] {
        let settings = SurfaceSettings { planes, ..SurfaceSettings::default() };
        let (map, surface_ms) = cost_ms(|| SurfaceMap::new(cloud.iter().copied(), &settings));
        scene.target = map.unwrap();
        let sigma = Sigma { turn_deg: 1.5, shift_m: 0.1 };
        let away = sigma.draw(&mut scene.rng);
        let (found, register_ms) = cost_ms(|| scene.register(away, sigma).unwrap());
        println!(
            "{} voxels, {} on planes: surfaces {surface_ms:.0} ms; registration {register_ms:.0} ms, {:?}",
            cloud.len(),
            scene.target.len(),
            found.statistics
        );
    }
}
