use std::sync::atomic::{AtomicBool, Ordering};

use super::*;

/// A status all of whose numbers are made from one, so that a mixture shows.
fn uniform(n: u32) -> LaneStatus {
    let x = f64::from(n);
    LaneStatus {
        time_ns: i64::from(n),
        sensor_time_ns: i64::from(n),
        status: lodestone_schema::Status::from_bits_retain(n),
        validity: lodestone_schema::Validity::from_bits_retain(n),
        heading_source: n as u8,
        position_source: n as u8,
        aids_used: n as u8,
        aids_refused: n as u8,
        world_epoch: n,
        position_m: [x; 3],
        position_variance_m2: [x; 3],
        orientation: [x; 4],
        orientation_variance_rad2: [x; 3],
        sensor: SensorStatus { temperature_c: x, magnetic_norm_ut: x, clock_drift: x },
    }
}

#[test]
fn before_the_first_report_everything_is_unknown() {
    let status = LaneBoard::new().latest.read();
    assert!(status.heading_rad().is_nan() && status.heading_sigma_rad().is_nan());
    assert!(status.position_sigma_m().is_nan() && status.sensor.temperature_c.is_nan());
    assert_eq!(LaneBoard::new().state(), LaneState::Searching);
}

#[test]
fn the_latest_report_is_read_again_and_again() {
    let latest = Latest::default();
    for n in 1..10 {
        latest.report(&uniform(n));
        latest.report(&uniform(n + 100));
        assert_eq!(latest.read(), uniform(n + 100));
        assert_eq!(latest.read(), uniform(n + 100));
    }
}

#[test]
fn a_reader_never_sees_a_mixture_nor_an_older_report() {
    let latest = Latest::default();
    latest.report(&uniform(1));
    let done = AtomicBool::new(false);
    std::thread::scope(|threads| {
        for _ in 0..2 {
            threads.spawn(|| {
                let mut newest = 1;
                while !done.load(Ordering::Relaxed) {
                    let seen = latest.read();
                    let n = u32::try_from(seen.time_ns).unwrap();
                    assert_eq!(seen, uniform(n));
                    assert!(n >= newest, "{n} after {newest}");
                    newest = n;
                }
            });
        }
        (2..200_000).for_each(|n| latest.report(&uniform(n)));
        done.store(true, Ordering::Relaxed);
    });
    assert_eq!(latest.read(), uniform(199_999));
}

#[test]
fn heading_is_clockwise_from_north_and_tilt_follows_the_frames() {
    let about = |axis: glam::DVec3, deg: f64| glam::DQuat::from_axis_angle(axis, deg.to_radians());
    let of = |q: glam::DQuat| LaneStatus { orientation: q.to_array(), ..LaneStatus::default() };
    // Yaw turns from east towards north.
    for (yaw_deg, heading_deg) in [(0.0, 90.0), (90.0, 0.0), (180.0, 270.0), (-90.0, 180.0)] {
        let heading = of(about(glam::DVec3::Z, yaw_deg)).heading_rad().to_degrees();
        let off = (heading - heading_deg + 180.0_f64).rem_euclid(360.0) - 180.0;
        assert!(off.abs() < 1e-9, "yaw {yaw_deg}: {heading}");
    }
    let q = glam::DQuat::from_euler(glam::EulerRot::ZYX, 0.4, -0.3, 0.2);
    let (roll, pitch) = of(q).roll_pitch_rad();
    assert!((roll - 0.2).abs() < 1e-12 && (pitch + 0.3).abs() < 1e-12);
}

#[test]
fn an_axis_of_unknown_position_makes_the_position_unknown() {
    let known = LaneStatus { position_variance_m2: [0.01, 0.04, 0.0], ..LaneStatus::default() };
    assert!((known.position_sigma_m() - 0.2).abs() < 1e-12);
    let unknown =
        LaneStatus { position_variance_m2: [0.01, f64::NAN, 0.04], ..LaneStatus::default() };
    assert!(unknown.position_sigma_m().is_nan());
}

#[test]
fn counters_reach_the_health_message_under_their_names() {
    let board = LaneBoard::new();
    board.counters.samples.add(3);
    board.counters.publish_errors.set(7);
    let mut health = crate::publisher::blank_health();
    board.counters.values().fill(&mut health);
    assert_eq!((health.samples, health.poses, health.publish_errors), (3, 0, 7));
}
