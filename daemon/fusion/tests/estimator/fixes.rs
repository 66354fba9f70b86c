//! Positions, poses and velocities by others: late, wrong, and after long absence.

use glam::{DMat3, DVec3};
use lodestone_fusion::{AidKind, AidRefusal, Measurement, Parameters, PositionOrigin, so3};

use crate::ride::{Ride, in_vehicle, mean};
use crate::simulation::steps;

/// A position with independent errors.
fn measured(ride: &mut Ride, truth: DVec3, sigma_m: f64) -> DVec3 {
    let mut number = || ride.car.number(sigma_m);
    truth + DVec3::new(number(), number(), number())
}

#[test]
fn a_late_fix_is_one_of_where_the_car_was() {
    // Given fixes that are 0.3 s late and say so, when the car drives at up to 80 km/h and turns, then
    // the position neither lags nor leads, and the innovations are as large as they should be.
    let mut ride = Ride::new(5, in_vehicle());
    ride.drive(8.0, 50.0, 0.05);
    let (mut along, mut innovations) = (Vec::new(), Vec::new());
    let mut past: std::collections::VecDeque<DVec3> = std::collections::VecDeque::new();
    for k in 0..steps(240.0) / 8 {
        ride.drive(0.02, 50.0, 0.05);
        past.push_back(ride.car.position);
        if past.len() <= 15 {
            continue;
        }
        let then = past.pop_front().unwrap();
        if k % 10 == 0 {
            let fix = measured(&mut ride, then, 0.3);
            let report = ride.offer_position(fix, 0.3, 0.3);
            innovations.push(report.nis.unwrap() / 3.0);
        }
        if ride.car.speed > 3.0 {
            along.push(ride.position_error().dot(ride.car.velocity.normalize()));
        }
    }
    let (lag, nis) = (mean(&along), mean(&innovations));
    println!("lag {lag:.3} m, NIS {nis:.2}");
    assert!(lag.abs() < 0.05, "{lag} m");
    assert!((0.85..1.15).contains(&nis), "{nis}");
    assert_eq!(ride.estimate().position_origin, PositionOrigin::PositionFix);
}

#[test]
fn a_late_speed_is_one_of_how_fast_the_car_was() {
    let run = |said_s: f64| {
        let mut ride = Ride::new(3, in_vehicle());
        let mut past = std::collections::VecDeque::new();
        let mut errors = Vec::new();
        for _ in 0..steps(120.0) / 8 {
            ride.drive_unaided(0.02);
            past.push_back(ride.car.speed + ride.car.number(0.05));
            if past.len() <= 15 {
                continue;
            }
            let then = past.pop_front().unwrap();
            if ride.filter.state().is_some() {
                let (speed_m_s, sigma_m_s) = (then, Some(0.05));
                ride.offer(Measurement::Speed { speed_m_s, sigma_m_s }, said_s);
                errors.push((ride.car.velocity - ride.estimate().velocity).length());
            }
        }
        mean(&errors)
    };
    let (compensated, ignored) = (run(0.3), run(0.0));
    println!("velocity error {compensated:.3} m/s, {ignored:.3} m/s where the delay is not told");
    assert!(compensated < 0.15 && compensated < 0.6 * ignored, "{compensated} {ignored}");
}

fn speed(speed_m_s: f64, sigma_m_s: f64) -> Measurement {
    Measurement::Speed { speed_m_s, sigma_m_s: Some(sigma_m_s) }
}

/// Measurements that nobody can have made.
fn senseless() -> [Measurement; 8] {
    let position = |position_m, covariance| Measurement::Position {
        position_m,
        covariance,
        lever_m: DVec3::ZERO,
    };
    let velocity = |velocity_m_s, covariance| Measurement::Velocity {
        velocity_m_s,
        covariance,
        lever_m: DVec3::ZERO,
    };
    [
        speed(f64::NAN, 0.1),
        speed(1.0, 0.0),
        speed(1.0, -0.1),
        speed(1e300, 0.1),
        position(DVec3::INFINITY, DMat3::IDENTITY),
        position(DVec3::X * 1e300, DMat3::IDENTITY),
        position(DVec3::ZERO, -DMat3::IDENTITY),
        velocity(DVec3::ZERO, DMat3::NAN),
    ]
}

#[test]
fn what_comes_too_late_or_too_early_or_makes_no_sense_is_refused() {
    let mut ride = Ride::new(1, Parameters::default());
    let early = ride.offer_position(DVec3::ZERO, 1.0, 0.0);
    assert_eq!(early.refusal, Some(AidRefusal::NotAligned));
    ride.drive_unaided(10.0);
    let before = ride.filter;
    let refused = |ride: &mut Ride, m: Measurement, age_s: f64| ride.offer(m, age_s).refusal;
    let good = Measurement::Position {
        position_m: DVec3::ZERO,
        covariance: DMat3::IDENTITY,
        lever_m: DVec3::ZERO,
    };
    assert_eq!(refused(&mut ride, good, 2.5), Some(AidRefusal::TooOld));
    assert_eq!(refused(&mut ride, good, -0.1), Some(AidRefusal::Future));
    assert_eq!(refused(&mut ride, speed(1.0, 0.1), 0.0), Some(AidRefusal::NoVehicle));
    for wrong in senseless() {
        assert_eq!(refused(&mut ride, wrong, 0.0), Some(AidRefusal::Invalid), "{wrong:?}");
    }
    let aids = ride.estimate().aids;
    assert!(aids.refused.contains(AidKind::PositionFix) && aids.refused.contains(AidKind::Speed));
    assert!(!aids.used.contains(AidKind::PositionFix));
    let moved = ride.filter.state().unwrap().error_from(before.state().unwrap());
    assert!(moved.iter().all(|x| x.abs() < 1e-12), "{moved:?}");
}

#[test]
fn an_outlier_changes_nothing_and_a_lasting_contradiction_is_believed_and_announced() {
    // Given a car that knows its position to a metre, when one fix is thirty metres off, then it is refused;
    // when all fixes are, then after some seconds the position jumps there, and says so.
    let mut ride = Ride::new(4, in_vehicle());
    ride.drive(30.0, 50.0, 0.05);
    let place = ride.car.position;
    assert_eq!(ride.offer_position(place, 0.5, 0.0).refusal, None);
    let off = DVec3::new(30.0, 0.0, 0.0);
    let report = ride.offer_position(place + off, 0.5, 0.0);
    assert_eq!(report.refusal, Some(AidRefusal::Innovation));
    assert!(ride.position_error().length() < 3.0);

    let mut jumps = 0;
    for _ in 0..40 {
        ride.drive(0.2, 50.0, 0.05);
        let shown = ride.car.position + off;
        let fix = measured(&mut ride, shown, 0.5);
        jumps += u32::from(ride.offer_position(fix, 0.5, 0.0).position_jumped);
    }
    assert_eq!(jumps, 1, "one jump");
    let left = ride.position_error() + off;
    assert!(left.length() < 1.5, "{left}");
    assert!(!ride.estimate().aids.refused.contains(AidKind::PositionFix));
}

#[test]
fn a_pose_corrects_position_and_orientation() {
    let mut ride = Ride::new(6, Parameters::default());
    ride.drive_unaided(20.0);
    for _ in 0..60 {
        ride.drive_unaided(0.5);
        let noise = DVec3::new(ride.car.number(2e-3), ride.car.number(2e-3), ride.car.number(2e-3));
        let turned = so3::exp(noise) * ride.car.orientation;
        let place = ride.car.position;
        let pose = Measurement::Pose {
            position_m: measured(&mut ride, place, 0.05),
            covariance: DMat3::IDENTITY * 0.0025,
            lever_m: DVec3::ZERO,
            orientation: lodestone_fusion::Rotation::from_quaternion(turned).unwrap(),
            orientation_covariance: DMat3::IDENTITY * 4e-6,
        };
        ride.offer(pose, 0.0);
    }
    let estimate = ride.estimate();
    assert_eq!(estimate.position_origin, PositionOrigin::PoseFix);
    assert!(ride.position_error().length() < 0.15, "{}", ride.position_error());
    let turn = so3::log(ride.car.orientation * estimate.orientation.quaternion().conjugate());
    assert!(turn.length() < 5e-3, "{turn}");
    // And is as sure as sixty of them make it.
    let sigma = estimate.position_covariance.x_axis.x.sqrt();
    assert!(sigma < 0.05, "{sigma}");
}

#[test]
fn a_velocity_in_the_world_holds_the_position() {
    let mut ride = Ride::new(7, Parameters::default());
    ride.drive_unaided(5.0);
    for _ in 0..steps(60.0) / 40 {
        ride.drive_unaided(0.1);
        let mut number = || ride.car.number(0.1);
        let noise = DVec3::new(number(), number(), number());
        let velocity_m_s = ride.car.velocity + noise;
        let covariance = DMat3::IDENTITY * 0.01;
        ride.offer(Measurement::Velocity { velocity_m_s, covariance, lever_m: DVec3::ZERO }, 0.0);
    }
    let aids = ride.estimate().aids;
    assert!(aids.used.contains(AidKind::Velocity) && !aids.used.contains(AidKind::Gradient));
    assert_eq!(aids.position_origin(), PositionOrigin::Speed);
    assert!(ride.position_error().length() < 1.0, "{}", ride.position_error());
    assert!(ride.nees()[0] < 4.0);
}

#[test]
fn a_position_of_which_nothing_is_known_is_found_by_the_first_fix() {
    // Given a camera placed ten kilometres unsurely in the world, when a fix comes, then it is there to
    // the fix's own accuracy, and tilt and velocity are what they were.
    let mut ride = Ride::new(8, in_vehicle());
    ride.drive(20.0, 50.0, 0.05);
    ride.filter.place(DVec3::ZERO, DMat3::IDENTITY * 1e8);
    let before = *ride.filter.state().unwrap();
    let truth = DVec3::new(3210.0, -2345.0, 12.0);
    let report = ride.offer_position(truth, 0.5, 0.0);
    assert_eq!((report.refusal, report.position_jumped), (None, false));
    let state = ride.filter.state().unwrap();
    assert!((state.position - truth).length() < 0.01, "{}", state.position);
    let sigma = state.covariance.variances(lodestone_fusion::POSITION);
    assert!((sigma.x.sqrt() - 0.5).abs() < 0.01, "{sigma}");
    assert!((state.velocity - before.velocity).length() < 1e-3);
    let moved = ride.car.position;
    ride.drive(20.0, 50.0, 0.05);
    let way = ride.car.position - moved;
    let off = ride.filter.state().unwrap().position - truth - way;
    assert!(off.length() < 0.02 * way.length() + 1.0, "{off} after {way}");
}
