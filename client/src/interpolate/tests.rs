use glam::{DQuat, DVec3};
use lodestone_schema::{Pose, Status, Validity};
use proptest::prelude::*;

use super::{between, slerp};
use crate::pose::samples::{checked, moving, quaternions, still};
use crate::pose::{CameraPose, Origin};

const START_NS: i64 = 5_000_000_000;
const SPAN_NS: i64 = 10_000_000;

fn neighbours() -> impl Strategy<Value = (CameraPose, CameraPose)> {
    (moving(7, START_NS), moving(8, START_NS + SPAN_NS))
}

fn position(pose: &CameraPose) -> DVec3 {
    pose.position_m().unwrap()
}

/// Angle between two rotations, rad.
fn angle(a: DQuat, b: DQuat) -> f64 {
    let d = a.conjugate() * b;
    2.0 * d.xyz().length().atan2(d.w.abs())
}

proptest! {
    #[test]
    fn end_points_are_exact((a, b) in neighbours()) {
        prop_assert_eq!(between(&a, &b, START_NS), a);
        prop_assert_eq!(between(&a, &b, START_NS + SPAN_NS), b);
    }

    #[test]
    fn a_nanosecond_is_a_tiny_step((a, b) in neighbours(), at in 0..SPAN_NS) {
        let (here, next) = (between(&a, &b, START_NS + at), between(&a, &b, START_NS + at + 1));
        // 350 m in 10 ms is the fastest that the strategy makes, 1.5 times that on the curve.
        prop_assert!(position(&here).distance(position(&next)) < 1e-4);
        let turned = angle(
            here.orientation().unwrap().quaternion(), next.orientation().unwrap().quaternion());
        prop_assert!(turned < 1e-6, "{turned}");
        prop_assert!(here.position_covariance_m2().unwrap().abs_diff_eq(
            next.position_covariance_m2().unwrap(), 1e-6));
    }

    #[test]
    fn slerp_takes_the_shorter_arc_at_constant_rate(
        a in quaternions(), b in quaternions(), s in 0.0..1.0_f64
    ) {
        let whole = angle(a, b);
        let part = slerp(a, b, s);
        prop_assert!(whole <= std::f64::consts::PI + 1e-12);
        prop_assert!((angle(a, part) - s * whole).abs() < 1e-9);
        prop_assert!((angle(part, b) - (1.0 - s) * whole).abs() < 1e-9);
        // The same rotation by the opposite quaternion gives the same path.
        prop_assert!(angle(part, slerp(a, -b, s)) < 1e-9 || (whole - std::f64::consts::PI).abs() < 1e-6);
    }

    #[test]
    fn constant_acceleration_is_met_exactly(
        p in -10.0..10.0_f64, v in -5.0..5.0_f64, a in -9.0..9.0_f64, at in 0..SPAN_NS
    ) {
        let along = |t: f64| p + v * t + a * t * t / 2.0;
        let pose = |sequence, ns: i64| {
            let t = ns as f64 * 1e-9;
            checked(Pose {
                position_m: [along(t), 0.0, 0.0],
                velocity_m_s: [v + a * t, 0.0, 0.0],
                ..still(sequence, START_NS + ns)
            })
        };
        let found = between(&pose(0, 0), &pose(1, SPAN_NS), START_NS + at);
        prop_assert!((position(&found).x - along(at as f64 * 1e-9)).abs() < 1e-12);
    }
}

#[test]
fn tiny_turns_are_interpolated_too() {
    let step = DQuat::from_xyzw(1e-14, 0.0, 0.0, 1.0);
    assert!((slerp(DQuat::IDENTITY, step, 0.5).x - 0.5e-14).abs() < 1e-28);
}

#[test]
fn valid_is_what_is_valid_in_both() {
    let a = checked(still(0, START_NS));
    let without = Validity::all().difference(Validity::POSITION | Validity::ANGULAR_RATE);
    let b = checked(Pose {
        validity: without.bits(),
        position_m: [f64::NAN; 3],
        ..still(1, START_NS + SPAN_NS)
    });
    let found = between(&a, &b, START_NS + SPAN_NS / 2);
    assert_eq!(found.validity(), without);
    assert_eq!(found.position_m(), None);
    assert_eq!(found.origin(), Origin::Interpolated);
}

#[test]
fn warnings_add_up_and_claims_must_agree() {
    let pose = |sequence, time_ns, status: Status| {
        checked(Pose { status: status.bits(), ..still(sequence, time_ns) })
    };
    let a = pose(0, START_NS, Status::INITIALISED | Status::STATIONARY);
    let b = pose(1, START_NS + SPAN_NS, Status::INITIALISED | Status::SATURATED);
    let found = between(&a, &b, START_NS + 1);
    assert_eq!(found.status(), Status::INITIALISED | Status::SATURATED);
}

#[test]
fn without_a_velocity_the_path_is_straight() {
    let valid = Validity::all().difference(Validity::VELOCITY).bits();
    let pose = |sequence, time_ns, x: f64| {
        let velocity_m_s = [f64::NAN; 3];
        checked(Pose {
            validity: valid,
            position_m: [x, 0.0, 0.0],
            velocity_m_s,
            ..still(sequence, time_ns)
        })
    };
    let found =
        between(&pose(0, START_NS, 2.0), &pose(1, START_NS + SPAN_NS, 4.0), START_NS + 2_500_000);
    assert!((position(&found).x - 2.5).abs() < 1e-12);
}
