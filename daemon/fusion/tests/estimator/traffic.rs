//! Where a car in city traffic is, with speed and constraint and without: how far off, and does the filter
//! know it?

use glam::DVec3;
use lodestone_fusion::{AidKind, MOUNTING, PositionOrigin, SPEED_SCALE};

use crate::ride::{BAND, Ride, in_vehicle, in_vehicle_with, mean, median};
use crate::simulation::steps;

const SEEDS: u64 = 10;

/// NEES of position and velocity over all rides.
fn assert_honest(what: &str, rides: &[Ride], (low, high): (f64, f64)) {
    let scores: Vec<[f64; 2]> = rides.iter().map(Ride::nees).collect();
    for (k, name) in ["position", "velocity"].into_iter().enumerate() {
        let nees = mean(&scores.iter().map(|s| s[k]).collect::<Vec<_>>());
        println!("{what}: NEES of {name} {nees:.2}");
        assert!((low..high).contains(&nees), "{what}: {name} {nees:.2}");
    }
}

/// Position errors as percentages of the way.
fn errors_percent(rides: &[Ride]) -> Vec<f64> {
    rides.iter().map(|r| 100.0 * r.position_error().length() / r.car.distance).collect()
}

#[test]
fn with_speed_and_constraint_a_car_is_off_by_less_than_a_hundredth_of_its_way() {
    let mut rides: Vec<Ride> = (0..SEEDS).map(|seed| Ride::new(seed, in_vehicle())).collect();
    for (seconds, what) in [(64.0, "a minute"), (540.0, "ten minutes")] {
        for ride in &mut rides {
            ride.drive(seconds, 50.0, 0.05);
        }
        let off = median(errors_percent(&rides));
        println!("{what}: {off:.2} % of the way");
        assert!(off < 1.0, "{what}: {off} %");
        // This speed has no error of scale and this camera none of mounting: too modest.
        assert_honest(what, &rides, (0.1, BAND.1));
    }
    for ride in &rides {
        let estimate = ride.estimate();
        assert!(estimate.aids.used.contains(AidKind::NonHolonomic));
        assert!(estimate.aids.refused.is_empty(), "{:?}", estimate.aids);
    }
}

#[test]
fn with_errors_of_scale_and_mounting_a_car_knows_how_far_off_it_is() {
    let told = in_vehicle();
    let mut rides: Vec<Ride> = (0..SEEDS)
        .map(|seed| {
            let mut ride = Ride::new(100 + seed, told);
            let v = told.vehicle.unwrap();
            ride.misread(v.speed_scale_sigma, v.mounting_sigma_rad);
            ride
        })
        .collect();
    for (seconds, what) in [(64.0, "a minute"), (240.0, "five minutes")] {
        for ride in &mut rides {
            ride.drive(seconds, 50.0, 0.05);
        }
        println!("{what}: {:.2} % of the way", median(errors_percent(&rides)));
        // At a stop the velocity is known better than the counted pitch on the springs allows.
        assert_honest(what, &rides, (0.25, BAND.1));
    }
}

#[test]
fn unaided_a_car_knows_how_lost_it_is() {
    let p = lodestone_fusion::Parameters::default();
    let mut rides: Vec<Ride> = (0..SEEDS).map(|seed| Ride::new(seed, p)).collect();
    // The first seconds are too modest: the accelerometer's bias and the tilt it causes cancel until the
    // car turns.
    for (seconds, band) in [(14.0, (0.4, 1.57)), (10.0, (0.4, 1.57)), (20.0, BAND), (20.0, BAND)] {
        for ride in &mut rides {
            ride.drive_unaided(seconds);
        }
        assert_honest("unaided", &rides, band);
    }
    let tilt_deg = rides.iter().map(|ride| {
        let up = ride.car.orientation.conjugate() * DVec3::Z;
        ride.estimate().orientation.apply(up).angle_between(DVec3::Z).to_degrees()
    });
    let worst = tilt_deg.fold(0.0, f64::max);
    assert!(worst < 3.0, "tilted by {worst}°");
}

#[test]
fn a_stop_is_found_and_the_car_does_not_creep() {
    for seed in 0..4 {
        let mut ride = Ride::new(seed, in_vehicle());
        ride.drive(60.0, 50.0, 0.05);
        let mut stood_s = 0.0;
        let mut place = None;
        for _ in 0..steps(240.0) {
            ride.drive(0.0025, 400.0, 0.05);
            stood_s = if ride.car.stands() { stood_s + 0.0025 } else { 0.0 };
            if stood_s < 4.0 {
                place = None;
                continue;
            }
            assert!(ride.estimate().at_rest, "seed {seed}, {stood_s} s into a stop");
            assert_eq!(ride.estimate().position_origin, PositionOrigin::Standstill);
            let now = ride.estimate().position;
            let moved = (now - *place.get_or_insert(now)).length();
            assert!(moved < 0.05, "crept by {moved} m in {stood_s} s");
        }
    }
}

#[test]
fn no_smooth_road_passes_for_a_stop_while_the_speed_is_known() {
    for seed in 0..4 {
        let mut ride = Ride::new(seed, in_vehicle());
        for _ in 0..steps(300.0) / 8 {
            ride.drive(0.02, 50.0, 0.05);
            let rolls = ride.car.speed > 0.5;
            assert!(!(rolls && ride.filter.state().is_some() && ride.estimate().at_rest));
        }
    }
}

#[test]
fn coarse_wheel_ticks_are_good_enough() {
    // Given a speed in steps of a third of a metre per second, ten times a second, as some buses of
    // cars give it, when it is offered with the noise of such a step, then the position is as good.
    let mut rides: Vec<Ride> = (0..6).map(|seed| Ride::new(seed, in_vehicle())).collect();
    for ride in &mut rides {
        for _ in 0..steps(240.0) / 40 {
            ride.drive_unaided(0.1);
            let ticks = (3.0 * ride.car.speed).round() / 3.0;
            ride.offer_speed(ticks, 0.1);
        }
    }
    let off = median(errors_percent(&rides));
    assert!(off < 1.0, "{off} % of the way");
}

#[test]
fn a_speed_that_reads_too_fast_is_counted_and_learnt_once_a_fix_tells() {
    let mut ride = Ride::new(2, in_vehicle());
    for k in 0..steps(300.0) / 8 {
        ride.drive_unaided(0.02);
        let speed_m_s = 1.015 * ride.car.speed + ride.car.number(0.05);
        ride.offer_speed(speed_m_s, 0.05);
        if k > 4000 && k % 50 == 0 {
            let fix = ride.car.position + DVec3::splat(ride.car.number(0.5));
            ride.offer_position(fix, 0.9, 0.0);
        }
    }
    let state = ride.filter.state().unwrap();
    let error = 0.015 - state.speed_scale;
    let sigma = state.covariance.variance(SPEED_SCALE).sqrt();
    assert!(error.abs() < 3.0 * sigma && sigma < 0.005, "{error} off, {sigma}");
}

#[test]
fn a_mounting_that_is_a_degree_off_is_learnt_from_the_way_it_speeds_up() {
    // The filter is told another yaw and pitch than the camera has; acceleration shows them.
    for (seed, axis) in [DVec3::Y, DVec3::Z].into_iter().enumerate() {
        let p = in_vehicle_with(|v| {
            let wrong = lodestone_fusion::so3::exp(axis * 0.02) * v.vehicle_from_body.quaternion();
            v.vehicle_from_body = lodestone_fusion::Rotation::from_quaternion(wrong).unwrap();
        });
        let mut ride = Ride::new(seed as u64, p);
        ride.drive(240.0, 50.0, 0.05);
        let state = ride.filter.state().unwrap();
        let found = DVec3::new(0.0, state.mounting_rad[0], state.mounting_rad[1]);
        let sigma = state.covariance.variance(MOUNTING + seed).sqrt();
        let error = (found + axis * 0.02).dot(axis);
        assert!(error.abs() < 4.0 * sigma.max(2e-3) && sigma < 0.01, "{found}, σ {sigma}");
    }
}
