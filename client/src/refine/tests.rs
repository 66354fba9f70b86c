//! Two cameras in one room, of which one is wrong about where it looks.

use glam::{DQuat, DVec3};
use lodestone_schema::{CloudPoint, Pose};

use super::worker::Worker;
use super::*;
use crate::cloud::{CloudInfo, Motion};
use crate::frame::Body;
use crate::merge::samples::{header, point};
use crate::merge::{PlacedCloud, Range};
use crate::pose::samples::{checked, still};
use crate::registration::RegistrationError;
use crate::transform::Transform;

const SECOND: i64 = 1_000_000_000;
const HALF_ROOM_M: DVec3 = DVec3::new(3.0, 2.5, 1.5);
/// Error of the second camera's poses.
const WRONG_YAW_RAD: f64 = 0.026;
const WRONG_SHIFT_M: DVec3 = DVec3::new(0.03, -0.04, 0.02);

/// A camera at the room's middle, level.
#[derive(Clone, Copy)]
struct Camera {
    index: usize,
    at: DVec3,
    yaw: f64,
    /// What its poses are wrong by.
    yaw_error: f64,
    shift_error: DVec3,
    epoch: u32,
}

const ANCHOR: Camera = Camera {
    index: 0,
    at: DVec3::new(-0.5, 0.3, 0.0),
    yaw: 0.3,
    yaw_error: 0.0,
    shift_error: DVec3::ZERO,
    epoch: 1,
};
const OTHER: Camera = Camera {
    index: 1,
    at: DVec3::new(-0.8, -0.4, 0.1),
    yaw: 0.0,
    yaw_error: WRONG_YAW_RAD,
    shift_error: WRONG_SHIFT_M,
    epoch: 1,
};

impl Camera {
    /// What it sees of the room, body axes, without noise.
    fn points(&self) -> Vec<CloudPoint> {
        let rays = (0..160 * 90).map(|i| {
            let (u, v) = (f64::from(i % 160) / 80.0 - 1.0, f64::from(i / 160) / 45.0 - 1.0);
            DVec3::new(1.0, u * 1.2, v * 0.8)
        });
        let turn = DQuat::from_rotation_z(self.yaw);
        rays.map(|ray| {
            let in_room = turn * ray;
            let to_walls = (HALF_ROOM_M * in_room.signum() - self.at) / in_room;
            point((ray * to_walls.min_element()).as_vec3().to_array())
        })
        .collect()
    }

    /// A cloud of it, placed by the pose that it believes in.
    fn cloud(&self, time_ns: i64) -> PlacedCloud {
        let points = self.points();
        let info = CloudInfo::check(&header(points.len(), time_ns), points.len()).unwrap();
        let pose = Pose {
            position_m: (self.at + self.shift_error).to_array(),
            orientation: DQuat::from_rotation_z(self.yaw + self.yaw_error).to_array(),
            position_covariance_m2: [2.5e-3, 0.0, 0.0, 2.5e-3, 0.0, 2.5e-3],
            orientation_covariance_rad2: [1e-4, 0.0, 0.0, 1e-4, 0.0, 6e-4],
            world_epoch: self.epoch,
            ..still(1, time_ns)
        };
        let at_rest = Transform::<Body, Body>::IDENTITY;
        let motion = Motion::over(time_ns, (0, 0), at_rest, |_, _| Ok(checked(pose))).unwrap();
        PlacedCloud::place(self.index, (&info, &points), motion, Range::default(), Vec::new())
    }
}

/// One that has seen some clouds of the anchor.
fn worker() -> Worker {
    let mut worker = Worker::new(2, RefineSettings::default()).unwrap();
    seen_by(&mut worker, ANCHOR);
    worker
}

fn seen_by(worker: &mut Worker, anchor: Camera) {
    for i in 0..4 {
        assert!(worker.take(&anchor.cloud(i * SECOND / 5)).is_none());
    }
}

/// The worst distance of a camera's points from the room's walls.
fn worst_m(cloud: &PlacedCloud, moved: Transform<crate::World, crate::World>) -> f64 {
    let off = |p: DVec3| ((p.abs() - HALF_ROOM_M).max_element()).abs();
    cloud.positions_m().map(|p| off(moved.apply(p))).fold(0.0, f64::max)
}

#[test]
fn a_camera_is_laid_over_what_the_anchor_saw() {
    let mut worker = worker();
    let cloud = OTHER.cloud(SECOND);
    let found = worker.take(&cloud).unwrap().result.unwrap();
    let (turn, shift) = found.correction;
    assert!((turn.z + WRONG_YAW_RAD).abs() < 1e-3, "{turn}");
    assert!(shift.abs_diff_eq(-WRONG_SHIFT_M, 4e-3), "{shift}");
    let body = OTHER.at + OTHER.shift_error;
    let moved = super::worker::movement(body, found.correction);
    assert!(worst_m(&cloud, Transform::IDENTITY) > 0.05);
    assert!(worst_m(&cloud, moved) < 0.01, "{}", worst_m(&cloud, moved));
    // And not again before it is due.
    assert!(worker.take(&OTHER.cloud(2 * SECOND)).is_none());
    assert!(worker.take(&OTHER.cloud(3 * SECOND)).is_some());
}

#[test]
fn without_the_anchor_there_is_nothing_to_register_against() {
    let mut worker = Worker::new(2, RefineSettings::default()).unwrap();
    assert!(worker.take(&OTHER.cloud(SECOND)).is_none());
}

#[test]
fn in_a_new_world_all_is_forgotten() {
    let mut worker = worker();
    assert!(worker.take(&OTHER.cloud(SECOND)).unwrap().result.is_ok());
    let later = Camera { epoch: 2, ..OTHER };
    assert!(worker.take(&later.cloud(9 * SECOND)).is_none());
    seen_by(&mut worker, Camera { epoch: 2, ..ANCHOR });
    assert!(worker.take(&later.cloud(20 * SECOND)).unwrap().result.is_ok());
}

#[test]
fn a_refusal_has_its_reason() {
    let mut worker = worker();
    let lost = Camera { shift_error: DVec3::new(0.0, 0.0, 0.6), ..OTHER };
    let why = worker.take(&lost.cloud(SECOND)).unwrap().result.unwrap_err();
    assert!(
        matches!(
            why,
            RegistrationError::ContradictsPrior { .. } | RegistrationError::NoOverlap { .. }
        ),
        "{why}"
    );
    let mut refused = Refusals::default();
    refused.count(&why);
    assert_eq!(refused.total(), 1);
}

#[test]
fn clouds_wait_for_the_first_registration_and_follow_it() {
    let mut refiner = CloudRefiner::new(2, RefineSettings::default()).unwrap();
    // The thread takes its time, and clouds that it has no room for are not offered.
    for i in 0..8 {
        let cloud = ANCHOR.cloud(i * SECOND / 5);
        assert_eq!(refiner.place(&cloud), Placement::Insert(Transform::IDENTITY));
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    assert_eq!(refiner.place(&OTHER.cloud(0)), Placement::Hold);
    let begin = std::time::Instant::now();
    while refiner.report(1).correction.is_none() {
        assert!(begin.elapsed().as_secs() < 60, "{:?}", refiner.report(1));
        std::thread::sleep(std::time::Duration::from_millis(20));
        refiner.place(&ANCHOR.cloud(0));
    }
    let cloud = OTHER.cloud(SECOND);
    let Placement::Insert(moved) = refiner.place(&cloud) else { panic!("held") };
    assert!(worst_m(&cloud, moved) < 0.01);
    assert_eq!((refiner.report(1).accepted, refiner.report(1).held), (1, 1));
    let fixes = refiner.take_fixes();
    assert_eq!((fixes.len(), fixes[0].camera, fixes[0].time_ns), (1, 1, 0));
    assert!(fixes[0].estimate.world_from_body.origin().abs_diff_eq(OTHER.at, 5e-3));
    assert!(refiner.take_fixes().is_empty());
}

#[test]
fn patience_ends_and_a_correction_expires() {
    let settings = RefineSettings::default();
    let mut refiner = CloudRefiner::new(2, settings).unwrap();
    assert_eq!(refiner.place(&OTHER.cloud(0)), Placement::Hold);
    let late = OTHER.cloud(7 * SECOND);
    assert_eq!(refiner.place(&late), Placement::Insert(Transform::IDENTITY));
    assert_eq!((refiner.report(1).held, refiner.report(1).unrefined), (1, 1));
}

#[test]
fn the_anchor_must_be_one_of_the_cameras() {
    let settings = RefineSettings { anchor: 2, ..RefineSettings::default() };
    let error = CloudRefiner::new(2, settings).unwrap_err();
    assert_eq!(error.to_string(), "the anchor has index 2; there are 2 cameras");
}
