//! Cores that share a world, and what a low-pass does to one.

use std::sync::Arc;

use glam::{DMat3, DQuat, DVec3};
use lodestone_config::model::{AxisMap, Camera, Config, Start};
use lodestone_fusion::{Accel, Aid, Gyro, Mag, Measurement, Rotation, SensorTime, so3};
use lodestone_schema::DistanceSource;

use super::{Membership, Motion, WorldFrame, anchor_for, relative_of};
use crate::lane::{Core, LaneSettings, StepOutput};
use crate::reading::{HostTime, Reading, RecordedAiding};

const RATE_HZ: f64 = 400.0;
const FIELD_UT: DVec3 = DVec3::new(0.0, 22.0, -42.0);

fn settings(camera: Camera) -> LaneSettings {
    let camera = Camera { axis_map: Some(AxisMap::IDENTITY), ..camera };
    LaneSettings::new(&Config::default(), 0, &camera, None, RATE_HZ).unwrap()
}

fn with_start(position_m: [f64; 3]) -> Camera {
    Camera { start: Some(Start { position_m, sigma_m: 0.01 }), ..Camera::default() }
}

/// A level camera that turns about up; `yaw` by time, rad.
struct Turning<F> {
    yaw: F,
    /// Sample number, and how often its source began anew.
    next: u64,
    epoch: u32,
}

impl<F: Fn(f64) -> f64> Turning<F> {
    const fn new(yaw: F) -> Self {
        Self { yaw, next: 1, epoch: 0 }
    }

    fn time_s(&self) -> f64 {
        self.next as f64 / RATE_HZ
    }

    /// Runs a core for a while; gives its last step.
    fn run(&mut self, core: &mut Core, seconds: f64) -> StepOutput {
        let mut last = None;
        for _ in 0..(seconds * RATE_HZ) as u64 {
            core.take(&self.reading(), |step| last = Some(*step));
            self.next += 1;
        }
        last.expect("a step")
    }

    fn reading(&self) -> Reading {
        let now_s = self.time_s();
        let rate = ((self.yaw)(now_s) - (self.yaw)(now_s - 1.0 / RATE_HZ)) * RATE_HZ;
        let to_body = DQuat::from_rotation_z(-(self.yaw)(now_s));
        let nanos = (now_s * 1e9).round() as i64;
        Reading {
            epoch: self.epoch,
            sensor_time: SensorTime::from_nanos(nanos),
            arrival: HostTime::from_nanos(nanos),
            gyro: Gyro::new(DVec3::Z * rate),
            accel: Accel::new(DVec3::Z * 9.81),
            mag: self.next.is_multiple_of(8).then(|| Mag::new(to_body * FIELD_UT)),
            temperature_c: None,
            aiding: RecordedAiding::NONE,
            saturated: false,
        }
    }
}

/// Cores in one world: the first camera, and others with the given settings.
fn cores(cameras: Vec<Camera>) -> (Arc<WorldFrame>, Vec<Core>) {
    let frame = Arc::new(WorldFrame::waiting(cameras.len(), 1));
    let core = |(member, camera): (usize, Camera)| {
        let settings = settings(camera);
        Core::in_world(&settings, Membership::new(Arc::clone(&frame), member, settings.member))
    };
    let cores = cameras.into_iter().enumerate().map(core).collect();
    (frame, cores)
}

fn position(step: &StepOutput) -> DVec3 {
    step.estimate.expect("aligned").position
}

#[test]
fn the_first_camera_fixes_the_world_with_its_magnetometer_in_the_origin() {
    // Given a first camera whose magnetometer is 5 cm ahead of its IMU, turned to the north (yaw 90°)
    let ahead = Camera { magnetometer_position_m: [0.05, 0.0, 0.0], ..Camera::default() };
    let (frame, mut cores) = cores(vec![ahead, with_start([0.5, 0.0, 0.0]), Camera::default()]);
    let north = core::f64::consts::FRAC_PI_2;
    // When another one is aligned before it
    let mut second = Turning::new(|_| 0.3);
    let early = second.run(&mut cores[1], 2.0);
    assert_eq!((early.world.epoch, frame.phase().fixed), (0, false), "it is not its to fix");
    let step = Turning::new(|_| north).run(&mut cores[0], 2.0);
    // Then the origin is at the first one's magnetometer: 5 cm north of its IMU
    assert_eq!(step.world.epoch, 1);
    assert!((position(&step) - DVec3::new(0.0, -0.05, 0.0)).length() < 5e-3, "{step:?}");
    // And the one with a start stands there, and the one without is nowhere
    let step = second.run(&mut cores[1], 0.1);
    assert!((position(&step) - DVec3::X * 0.5).length() < 5e-3);
    assert_eq!((step.world.epoch, step.world.source), (1, DistanceSource::CommonStart));
    let step = Turning::new(|_| 0.0).run(&mut cores[2], 2.0);
    assert_eq!((step.world.epoch, step.world.source), (1, DistanceSource::Unknown));
    assert!(!step.estimate.unwrap().is_position_known());
}

#[test]
fn relative_poses_follow_from_two_cores_alone() {
    let (_, mut cores) = cores(vec![Camera::default(), with_start([0.02, 0.03, 0.0])]);
    for (core, yaw) in cores.iter_mut().zip([0.3, 2.0]) {
        Turning::new(move |_| yaw).run(core, 3.0);
    }
    let found = relative_of(&cores[0], &cores[1]).expect("both are aligned");
    let turned = found.orientation.to_yaw_pitch_roll().0;
    assert!((turned - 1.7).abs() < 0.01, "{turned}");
    let expected = DQuat::from_rotation_z(-0.3) * DVec3::new(0.02, 0.03, 0.0);
    assert!((found.distance.unwrap().vector - expected).length() < 1e-2);
    assert!((0.8..1.0).contains(&found.field_correlation), "{}", found.field_correlation);
    // Less than two headings' uncertainty: the common part has cancelled.
    let alone = cores[0].at_last_reading().unwrap().orientation_covariance.z_axis.z;
    assert!(found.orientation_covariance.z_axis.z < 1.5 * alone);
    // Same readings in, same bits out.
    let again = relative_of(&cores[0], &cores[1]);
    assert_eq!(again, Some(found));
}

#[test]
fn a_camera_that_begins_anew_is_where_it_was_less_surely_and_the_world_stays() {
    let (frame, mut cores) = cores(vec![Camera::default(), with_start([3.0, 0.0, 0.0])]);
    let mut first = Turning::new(|_| 0.0);
    let before = first.run(&mut cores[0], 3.0);
    let phase = frame.phase();
    // When the source is opened again after two seconds
    first.next += 800;
    first.epoch = 1;
    let after = first.run(&mut cores[0], 3.0);
    assert_eq!(cores[0].counts().resets, 1);
    assert_eq!((frame.phase(), after.world.epoch), (phase, before.world.epoch));
    assert!((position(&after) - position(&before)).length() < 0.02);
    let sigma = |step: &StepOutput| step.estimate.unwrap().position_covariance.x_axis.x.sqrt();
    // Away for two seconds, at up to 0.3 m/s each way (1σ) by default... and no less.
    assert!(sigma(&after) > 0.5 && sigma(&after) < 1.5, "{} {}", sigma(&before), sigma(&after));
    assert_eq!(after.world.source, DistanceSource::CommonStart);
}

#[test]
fn a_new_world_takes_everybody_back_to_the_start_once() {
    let (frame, mut cores) = cores(vec![Camera::default(), with_start([3.0, 0.0, 0.0])]);
    let (mut first, mut second) = (Turning::new(|_| 0.0), Turning::new(|_| 1.0));
    first.run(&mut cores[0], 3.0);
    second.run(&mut cores[1], 3.0);
    assert!(frame.end());
    // The second one goes on before the first has fixed the new world.
    assert_eq!(second.run(&mut cores[1], 0.1).world.epoch, 0);
    assert_eq!(first.run(&mut cores[0], 0.1).world.epoch, 2);
    let step = second.run(&mut cores[1], 0.1);
    assert_eq!(step.world.epoch, 2);
    assert!((position(&step) - DVec3::X * 3.0).length() < 0.01);
    assert_eq!([0, 1].map(|camera| cores[camera].counts().resets), [1, 1]);
}

#[test]
fn starts_do_not_hold_in_a_world_that_somebody_fixed_anywhere() {
    // Given a world that the second camera, which has no start, fixes in the first one's stead
    let (frame, mut cores) =
        cores(vec![Camera::default(), Camera::default(), with_start([3.0, 0.0, 0.0])]);
    assert!(frame.pass_on(frame.phase(), 1));
    let mut third = Turning::new(|_| 0.0);
    third.run(&mut cores[2], 2.0);
    Turning::new(|_| 0.0).run(&mut cores[1], 2.0);
    // Then nobody knows where in it a declared start is
    let step = third.run(&mut cores[2], 0.1);
    assert_eq!((step.world.epoch, step.world.source), (1, DistanceSource::Unknown));
    // Nor where the first camera is, when it comes at last
    let step = Turning::new(|_| 0.0).run(&mut cores[0], 2.0);
    assert_eq!(step.world.source, DistanceSource::Unknown);
}

/// Root mean square of the heading's error over a shaking about up of ±0.8 rad at 0.7 Hz, degrees.
fn heading_error_deg(settings: &LaneSettings) -> f64 {
    let yaw = |time_s: f64| {
        let since = (time_s - 3.0).max(0.0);
        0.8 * (core::f64::consts::TAU * 0.7 * since).sin()
    };
    let mut core = Core::new(settings);
    let mut camera = Turning::new(yaw);
    camera.run(&mut core, 4.0);
    let (mut sum, mut count) = (0.0, 0.0);
    for _ in 0..2000 {
        let step = camera.run(&mut core, 1.0 / RATE_HZ + 1e-9);
        let truth = DQuat::from_rotation_z(yaw(step.time.as_nanos() as f64 * 1e-9));
        let error = step.estimate.unwrap().orientation.quaternion() * truth.conjugate();
        sum += so3::log(error).z.powi(2);
        count += 1.0;
    }
    f64::sqrt(sum / count).to_degrees()
}

#[test]
fn a_low_pass_delays_and_its_delay_is_made_up_for() {
    // These samples are means over their interval, so they show what was half a sample ago.
    let camera = |low_pass_hz| Camera { low_pass_hz, imu_delay_s: 0.0, ..Camera::default() };
    let with_lead = |mut settings: LaneSettings| {
        settings.estimator.lead_s += 0.5 / RATE_HZ;
        settings
    };
    let plain = heading_error_deg(&with_lead(settings(camera(None))));
    let filtered = with_lead(settings(camera(Some(10.0))));
    let made_up_for = heading_error_deg(&filtered);
    let mut as_if_there_were_none = filtered;
    as_if_there_were_none.estimator.lead_s = 0.0;
    as_if_there_were_none.estimator.compass.delay_s = 0.0;
    let ignored = heading_error_deg(&as_if_there_were_none);
    println!(
        "heading error {plain:.3}°, low-pass {made_up_for:.3}°, its delay ignored {ignored:.3}°"
    );
    assert!(plain < 0.1 && made_up_for < 0.3, "{plain}° {made_up_for}°");
    assert!(ignored > 2.0, "22.5 ms at up to 3.5 rad/s are degrees: {ignored}°");
}

#[test]
fn what_was_kept_is_where_a_camera_goes_on() {
    let mut settings = settings(Camera::default());
    settings.member.kept = Some(super::Place {
        position: DVec3::new(1.0, 2.0, 3.0),
        covariance: DMat3::IDENTITY * 0.09,
        source: DistanceSource::PositionFix,
    });
    let phase = super::WorldPhase { epoch: 7, fixed: true, starts_hold: true, member: Some(0) };
    let frame = Arc::new(WorldFrame::new(1, phase));
    let mut core = Core::in_world(&settings, Membership::new(frame, 0, settings.member));
    let step = Turning::new(|_| 0.0).run(&mut core, 2.0);
    assert_eq!((step.world.epoch, step.world.source), (7, DistanceSource::PositionFix));
    assert!((position(&step) - DVec3::new(1.0, 2.0, 3.0)).length() < 0.01);
}

#[test]
fn a_fix_tells_a_camera_that_is_nowhere_where_it_is_and_names_itself() {
    let (_, mut cores) = cores(vec![Camera::default(), Camera::default()]);
    Turning::new(|_| 0.0).run(&mut cores[0], 2.0);
    let mut second = Turning::new(|_| 0.5);
    let before = second.run(&mut cores[1], 2.0);
    assert_eq!(before.world.source, DistanceSource::Unknown);
    let measurement = Measurement::Position {
        position_m: DVec3::new(4.0, 5.0, 0.5),
        covariance: DMat3::IDENTITY * 1e-4,
        lever_m: DVec3::ZERO,
    };
    cores[1].hear_fix(DistanceSource::CloudRegistration);
    cores[1].aid(Aid { time: before.time, measurement, anchor: None });
    let after = second.run(&mut cores[1], 0.1);
    assert_eq!(after.world.source, DistanceSource::CloudRegistration);
    assert!((position(&after) - DVec3::new(4.0, 5.0, 0.5)).length() < 0.01, "{after:?}");
    let sigma = after.estimate.unwrap().position_covariance.x_axis.x.sqrt();
    assert!((sigma - 0.01).abs() < 2e-3, "{sigma}");
}

/// A yaw, rad, by time, s.
type Yaw = fn(f64) -> f64;

/// Two cores go on together, each telling the other where it is, as two lanes do.
fn run_both(frame: &WorldFrame, cores: &mut [Core], cameras: &mut [Turning<Yaw>]) {
    for _ in 0..100 {
        for (member, (core, camera)) in cores.iter_mut().zip(&mut *cameras).enumerate() {
            let step = camera.run(core, 0.003);
            let Some(estimate) = &step.estimate else { continue };
            let motion = Motion::of(estimate, step.time.as_nanos(), &step.world);
            frame.report_motion(member, &motion);
            frame.report_tie(member, &motion, estimate.tie.as_ref());
        }
    }
}

fn pose(position_m: DVec3, yaw_rad: f64) -> Measurement {
    Measurement::Pose {
        position_m,
        covariance: DMat3::IDENTITY * 1e-5,
        lever_m: DVec3::ZERO,
        orientation: Rotation::from_yaw_pitch_roll(yaw_rad, 0.0, 0.0),
        orientation_covariance: DMat3::IDENTITY * 1e-6,
    }
}

fn yaw_rad(core: &Core) -> f64 {
    core.at_last_reading().expect("aligned").orientation.to_yaw_pitch_roll().0
}

#[test]
fn a_camera_that_was_measured_against_another_one_goes_along_with_what_that_one_corrects() {
    // Given two cameras, the second one measured against the first
    let (frame, mut cores) = cores(vec![Camera::default(), with_start([0.3, 0.0, 0.0])]);
    let yaws: [Yaw; 2] = [|_| 0.0, |_| 1.0];
    let mut cameras = yaws.map(Turning::new);
    for (core, camera) in cores.iter_mut().zip(&mut cameras) {
        camera.run(core, 3.0);
    }
    run_both(&frame, &mut cores, &mut cameras);
    let time = cores[1].at_last_reading().unwrap().time;
    let now = HostTime::from_nanos(time.as_nanos());
    let anchor = Some(anchor_for(&frame, 1, 0, (now, now)).expect("it is one"));
    let (at_m, turned) = (DVec3::new(0.31, 0.0, 0.0), yaw_rad(&cores[0]) + 1.01);
    cores[1].aid(Aid { time, measurement: pose(at_m, turned), anchor });
    run_both(&frame, &mut cores, &mut cameras);
    assert_eq!(cores[1].counts().aiding_used, 1, "{:?}", cores[1].counts());
    let measured = relative_of(&cores[0], &cores[1]).unwrap();
    assert!((measured.orientation.to_yaw_pitch_roll().0 - 1.01).abs() < 3e-3, "{measured:?}");
    // When the first one learns by a fix of its own that it is turned
    let (time, before) = (cores[0].at_last_reading().unwrap().time, yaw_rad(&cores[0]));
    let elsewhere = pose(DVec3::ZERO, before + 0.02);
    cores[0].aid(Aid { time, measurement: elsewhere, anchor: None });
    run_both(&frame, &mut cores, &mut cameras);
    let turned = yaw_rad(&cores[0]) - before;
    assert!(turned > 0.015, "{turned} {:?}", cores[0].counts());
    // Then the second one has turned with it, and about it
    let after = relative_of(&cores[0], &cores[1]).unwrap();
    let apart = after.orientation.quaternion() * measured.orientation.quaternion().conjugate();
    assert!(so3::log(apart).length() < 1e-3, "{}", so3::log(apart));
    // Left behind it would be off by 6 mm; in between its own speed, just corrected, takes it a millimetre on.
    let [before, after] = [measured, after].map(|r| r.distance.unwrap().vector);
    assert!((after - before).length() < 2.5e-3, "{before} {after}");
}
