//! A magnet beside one camera is told from what the whole rig sees.

use glam::DVec3;

use crate::scene::{Scene, Settings, polygon};

/// From when the magnet is there, and until when, s.
const MAGNET_S: (f64, f64) = (12.0, 18.0);

/// What was said about each member's magnetometer while the magnet was there, and after it, as shares
/// of the time; and the heading's error at the end of it, rad.
#[derive(Debug)]
struct Said {
    alone: Vec<f64>,
    alone_after: Vec<f64>,
    heading: f64,
    disturbed: bool,
}

fn with_magnet(count: usize, seed: u64, magnet: DVec3, on: &[usize]) -> Said {
    let mut settings = Settings::indoors(seed);
    settings.steel.clear();
    settings.mountings = polygon(count, 0.5);
    let mut scene = Scene::new(settings, seed);
    let (mut during, mut after, mut steps) = (vec![0.0; count], vec![0.0; count], [0.0; 2]);
    let (mut heading, mut disturbed) = (0.0, false);
    while scene.time_s() < 26.0 {
        let time_s = scene.time_s();
        let there = (MAGNET_S.0..MAGNET_S.1).contains(&time_s);
        for &member in on {
            scene.members[member].magnet = if there { magnet } else { DVec3::ZERO };
        }
        let Some(report) = scene.step(|_, _| {}) else { continue };
        let alone = report.members.map(|m| f64::from(m.magnetometer_alone));
        if there {
            steps[0] += 1.0;
            during.iter_mut().zip(alone).for_each(|(sum, a)| *sum += a);
            let estimate = scene.filter.estimate().unwrap();
            let turn = estimate.orientation.quaternion() * scene.orientation().conjugate();
            heading = 2.0 * turn.z;
            disturbed |= estimate.magnetic_disturbance || report.field_bent;
        } else if time_s > MAGNET_S.1 + 1.0 {
            steps[1] += 1.0;
            after.iter_mut().zip(alone).for_each(|(sum, a)| *sum += a);
        }
    }
    let said = Said {
        alone: during.iter().map(|sum| sum / steps[0]).collect(),
        alone_after: after.iter().map(|sum| sum / steps[1]).collect(),
        heading,
        disturbed,
    };
    println!("{said:?}");
    said
}

#[test]
fn a_magnet_beside_one_camera_disturbs_that_one_alone() {
    for (count, strength) in [(3, 15.0), (3, 60.0), (4, 12.0)] {
        let said = with_magnet(count, 3, DVec3::new(0.6, -0.8, 0.2) * strength, &[1]);
        assert!(said.alone[1] > 0.8, "{count} cameras, {strength} µT: {said:?}");
        let others = (0..count).filter(|&k| k != 1).all(|k| said.alone[k] < 0.02);
        assert!(others, "{count} cameras, {strength} µT: {said:?}");
        assert!(said.alone_after.iter().all(|share| *share < 0.1), "{said:?}");
        assert!(said.heading.abs() < 0.05, "{said:?}");
    }
}

#[test]
fn what_all_cameras_see_is_the_field() {
    let said = with_magnet(3, 4, DVec3::new(12.0, -16.0, 4.0), &[0, 1, 2]);
    assert!(said.alone.iter().all(|share| *share < 0.05), "{said:?}");
    assert!(said.disturbed, "{said:?}");
}
