//! Where a simulated camera truly begins, and that everything agrees on it.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::time::Duration;

use glam::DVec3;
use lodestone_config::model::{
    Camera, Mounting, SensorErrors, Start, Steel, Synthetic, TrajectoryKind, World,
};

use super::{SourceState, SyntheticDriver, Truth, field};
use crate::driver::Driver;
use crate::reading::Reading;

fn world() -> World {
    World { year: Some(2026.5), ..World::default() }
}

fn camera(synthetic: Synthetic) -> Camera {
    Camera { synthetic: Some(synthetic), imu_delay_s: 0.0, ..Camera::default() }
}

fn walking() -> Synthetic {
    Synthetic { rest_s: 1.0, seed: 5, speed: 0.0, duration_s: 20.0, ..Synthetic::default() }
}

/// The truth at a time since the beginning.
fn truth(driver: &SyntheticDriver, time_s: f64) -> Truth {
    let source = driver.truth_source();
    source.truth_at(source.start() + lodestone_fusion::SensorSpan::from_secs_f64(time_s))
}

#[test]
fn a_camera_begins_at_its_position_else_at_its_start_else_at_the_origin() {
    let place = [2.0, -1.0, 0.5];
    let start = Some(Start { position_m: [0.3, 0.2, 0.1], sigma_m: 0.02 });
    let begins = |position_m: Option<[f64; 3]>, start: Option<Start>| {
        let settings = Camera { start, ..camera(Synthetic { position_m, ..walking() }) };
        truth(&SyntheticDriver::new(&settings, &world()).unwrap(), 0.0).position_m
    };
    let is_near = |begins: DVec3, place: DVec3| (begins - place).length() < 1e-12;
    assert_eq!(begins(None, None), DVec3::ZERO);
    assert!(is_near(begins(None, start), DVec3::new(0.3, 0.2, 0.1)));
    // What the daemon is told may be wrong.
    assert!(is_near(begins(Some(place), start), DVec3::from_array(place)));
}

#[test]
fn a_heading_turns_the_whole_way_and_nothing_else() {
    let as_drawn = SyntheticDriver::new(&camera(walking()), &world()).unwrap();
    let settings = Synthetic { heading_deg: Some(100.0), ..walking() };
    let turned = SyntheticDriver::new(&camera(settings), &world()).unwrap();
    let yaw = |truth: &Truth| truth.orientation.to_yaw_pitch_roll().0;
    let (drawn_yaw, turned_yaw) = (yaw(&truth(&as_drawn, 0.0)), yaw(&truth(&turned, 0.0)));
    assert!((turned_yaw - (FRAC_PI_2 - 100_f64.to_radians())).abs() < 1e-12, "{turned_yaw}");
    for time_s in [3.0, 8.0, 19.0] {
        let (drawn, turned) = (truth(&as_drawn, time_s), truth(&turned, time_s));
        let turn = glam::DQuat::from_rotation_z(turned_yaw - drawn_yaw);
        assert!((turn * drawn.position_m - turned.position_m).length() < 1e-9);
        assert!((turn * drawn.velocity_m_s - turned.velocity_m_s).length() < 1e-9);
        assert!((drawn.angular_rate_rad_s - turned.angular_rate_rad_s).length() < 1e-9);
        let yawed = (yaw(&turned) - yaw(&drawn) - (turned_yaw - drawn_yaw)).rem_euclid(TAU);
        assert!(yawed < 1e-9 || TAU - yawed < 1e-9, "{yawed}");
    }
}

#[test]
fn a_standing_camera_takes_the_tilt_it_is_given_and_draws_the_rest() {
    let standing = |pitch_deg, roll_deg| {
        let trajectory = TrajectoryKind::Standing;
        let settings = Synthetic { trajectory, pitch_deg, roll_deg, ..walking() };
        let driver = SyntheticDriver::new(&camera(settings), &world()).unwrap();
        truth(&driver, 0.0).orientation.to_yaw_pitch_roll()
    };
    let (yaw, pitch, roll) = standing(None, None);
    let given = standing(Some(12.0), None);
    assert!((given.1 - 12_f64.to_radians()).abs() < 1e-12);
    assert!((given.0 - yaw).abs() < 1e-12 && (given.2 - roll).abs() < 1e-12);
    let given = standing(None, Some(-7.0));
    assert!((given.1 - pitch).abs() < 1e-12 && (given.2 + 7_f64.to_radians()).abs() < 1e-12);
}

#[test]
fn a_rig_begins_where_its_leader_says_and_members_keep_their_arms() {
    let mounting = |position_m, yaw_deg| Mounting {
        position_m,
        roll_pitch_yaw_deg: [0.0, 0.0, yaw_deg],
        ..Mounting::default()
    };
    let member = |mounting, seed| Camera { mounting, ..camera(Synthetic { seed, ..walking() }) };
    let (front, left) = (mounting([0.3, 0.0, 0.0], 0.0), mounting([0.0, 0.25, 0.0], 90.0));
    let follower = member(left, 2);
    let begins = |leader: &Camera| {
        let truth_of =
            |camera| truth(&SyntheticDriver::riding(camera, leader, &world()).unwrap(), 0.0);
        (truth_of(leader), truth_of(&follower))
    };
    // By the body's place: the leader is an arm ahead of it.
    let mut leader = member(front, 1);
    leader.synthetic.as_mut().unwrap().position_m = Some([5.0, 6.0, 0.0]);
    let (first, second) = begins(&leader);
    let body = first.position_m - first.orientation.apply(DVec3::new(0.3, 0.0, 0.0));
    assert!((body - DVec3::new(5.0, 6.0, 0.0)).length() < 1e-12, "{body}");
    let arm = first.orientation.inverse().apply(second.position_m - body);
    assert!((arm - DVec3::new(0.0, 0.25, 0.0)).length() < 1e-12, "{arm}");
    // By a start, which is that of the leader's IMU; a start of the follower does not count.
    let start = |position_m| Some(Start { position_m, sigma_m: 0.02 });
    let mut leader = member(front, 1);
    leader.start = start([1.0, 2.0, 3.0]);
    let (first, _) = begins(&leader);
    assert!((first.position_m - DVec3::new(1.0, 2.0, 3.0)).length() < 1e-12);
}

#[test]
fn steel_is_felt_from_where_the_camera_truly_is() {
    let steel = Steel { position_m: [3.0, 1.0, 0.5], moment_a_m2: [100.0, -50.0, 80.0] };
    let near = [2.0, 0.4, 0.1];
    let errors = SensorErrors { noise_scale: 0.0, quantise: false, ..SensorErrors::default() };
    let trajectory = TrajectoryKind::Standing;
    let settings =
        Synthetic { trajectory, errors, duration_s: 1.0, position_m: Some(near), ..walking() };
    let world = World { steel: vec![steel], ..world() };
    let mut driver = SyntheticDriver::new(&camera(settings), &world).unwrap();
    let mut readings: Vec<Reading> = Vec::new();
    while driver.poll(Duration::from_millis(10), &mut readings) == SourceState::Streaming {}
    let expected = field::EarthField::of(&world).unwrap().world_ut
        + field::steel_at(&steel, DVec3::from_array(near));
    let orientation = truth(&driver, 0.0).orientation;
    for mag in readings.iter().filter_map(|reading| reading.mag) {
        // The ZED 2's sensor axes: body x, y, z are sensor z, y, −x.
        let v = mag.vector;
        let felt = orientation.apply(DVec3::new(v.z, v.y, -v.x));
        assert!((felt - expected).length() < 1e-9, "{felt} {expected}");
    }
    assert!((expected - field::EarthField::of(&world).unwrap().world_ut).length() > 1.0);
}

/// Every shipped configuration with a scene: whoever is carried through it for half an hour meets no
/// wall and no furniture.
#[test]
fn nobody_is_carried_through_a_wall() {
    let config = lodestone_config::Config::embedded();
    let scene = crate::scene::Scene::new(config.scene.as_ref().expect("a room"));
    for camera in &config.camera {
        let driver = SyntheticDriver::new(camera, &world()).unwrap();
        for step in 0..18_000 {
            let place = truth(&driver, f64::from(step) * 0.1).position_m;
            assert!(scene.holds(place), "{} is outside at {place}", camera.name);
            let near_m = scene.distance_m(place, None);
            assert!(near_m > 0.25, "{} is {near_m} m from something at {place}", camera.name);
        }
    }
}

/// The truth is told 100 times a second; in between, depth sources interpolate it as every consumer does.
#[test]
fn what_is_told_100_times_a_second_tells_the_way_between_to_a_millimetre() {
    use lodestone_client::{CameraPose, History, LookupLimits, Time};
    let driver = SyntheticDriver::new(&camera(walking()), &world()).unwrap();
    let mut history = History::new(4000, LookupLimits::default());
    for (step, sequence) in (0..1800_i64).zip(0..) {
        let told = crate::source::truth_message(&truth(&driver, step as f64 * 0.01));
        let told = lodestone_schema::Pose { sequence, time_ns: step * 10_000_000, ..told };
        history.push(CameraPose::try_from(told).expect("sound"));
    }
    let (mut place_off_m, mut turn_off_rad) = (0.0_f64, 0.0_f64);
    for step in 0..1790 {
        let time_s = f64::from(step) * 0.01 + 0.005;
        let exact = truth(&driver, time_s);
        let found = history.lookup(Time::Monotonic((time_s * 1e9) as i64)).unwrap();
        let found = found.world_from_body().unwrap();
        place_off_m = place_off_m.max((found.origin() - exact.position_m).length());
        let turn = found.rotation().quaternion().angle_between(exact.orientation.quaternion());
        turn_off_rad = turn_off_rad.max(turn);
    }
    // Of a point at 3 m, a third of a millimetre.
    assert!(place_off_m < 1e-6, "{place_off_m}");
    assert!(turn_off_rad < 1e-4, "{turn_off_rad}");
}
