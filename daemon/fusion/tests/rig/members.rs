//! One member fails: it is voted out, the pose goes on, and it comes back when it is well again.

use glam::DVec3;
use lodestone_fusion::Step;
use lodestone_fusion::rig::{Exclusion, MAX_MEMBERS};
use lodestone_fusion::so3;

use crate::scene::{Scene, Settings, polygon};

type Steps = [Option<Step>; MAX_MEMBERS];

/// The member that fails, and when, s.
const FAILING: usize = 1;
const FROM_S: f64 = 8.0;
const TO_S: f64 = 10.0;

fn scene(count: usize, seed: u64) -> Scene {
    let mut settings = Settings::indoors(seed);
    settings.steel.clear();
    settings.mountings = polygon(count, 0.5);
    Scene::new(settings, seed)
}

/// What became of the failing member.
#[derive(Debug)]
struct Story {
    /// First exclusion, and after how long, s.
    out: Option<(Exclusion, f64)>,
    /// When it came back, s after it was well again.
    back_s: Option<f64>,
    /// Others that were voted out at any time.
    innocent: usize,
    /// Most that the attitude's error, rad, and the velocity's, m/s, changed within 50 ms.
    attitude_step: f64,
    velocity_step: f64,
    torn: bool,
}

fn attitude_error(scene: &Scene) -> DVec3 {
    let estimated = scene.filter.estimate().unwrap().orientation.quaternion();
    so3::log(scene.orientation() * estimated.conjugate())
}

/// Twenty seconds of walking in which `spoil` changes the failing member's steps for two.
fn tell(count: usize, seed: u64, mut spoil: impl FnMut(&mut Option<Step>)) -> Story {
    let mut scene = scene(count, seed);
    let mut story = Story {
        out: None,
        back_s: None,
        innocent: 0,
        attitude_step: 0.0,
        velocity_step: 0.0,
        torn: false,
    };
    let mut before = None;
    while scene.time_s() < 20.0 {
        let report = scene.step(|time_s, steps: &mut Steps| {
            if (FROM_S..TO_S).contains(&time_s) {
                spoil(&mut steps[FAILING]);
            }
        });
        let Some(report) = report else { continue };
        story.torn |= report.torn;
        let others = (0..count).filter(|&k| k != FAILING);
        story.innocent += others.filter(|&k| report.members[k].exclusion.is_some()).count();
        match report.members[FAILING].exclusion {
            Some(why) if story.out.is_none() => story.out = Some((why, scene.time_s() - FROM_S)),
            None if story.out.is_some() && story.back_s.is_none() => {
                story.back_s = Some(scene.time_s() - TO_S);
            }
            _ => {}
        }
        if scene.time_s() > 7.5 && (scene.time_s() / 0.05).fract() < 0.05 {
            let error = (
                attitude_error(&scene),
                scene.filter.estimate().unwrap().velocity - scene.velocity(),
            );
            if let Some((attitude, velocity)) = before.replace(error) {
                story.attitude_step = story.attitude_step.max((error.0 - attitude).length());
                story.velocity_step = story.velocity_step.max((error.1 - velocity).length());
            }
        }
    }
    println!("{story:?}");
    story
}

fn assert_survived(story: &Story, why: &[Exclusion], within_s: f64) {
    let (exclusion, after_s) = story.out.expect("voted out");
    assert!(why.contains(&exclusion), "{story:?}");
    assert!(after_s < within_s, "{story:?}");
    assert_eq!(story.innocent, 0, "{story:?}");
    assert!(story.back_s.is_some_and(|s| (2.5..8.0).contains(&s)), "{story:?}");
    assert!(story.attitude_step < 0.01 && story.velocity_step < 0.1, "{story:?}");
}

#[test]
fn values_that_are_no_numbers() {
    let story = tell(3, 1, |step| step.as_mut().unwrap().increment.angle.x = f64::NAN);
    assert_survived(&story, &[Exclusion::Invalid], 0.01);
}

#[test]
fn huge_values() {
    let story = tell(3, 2, |step| step.as_mut().unwrap().increment.velocity.z += 2.0);
    assert_survived(&story, &[Exclusion::Deviating], 0.01);
}

#[test]
fn a_value_that_is_stuck() {
    let mut held = None;
    let story = tell(3, 3, |step| {
        let step = step.as_mut().unwrap();
        step.increment = *held.get_or_insert(step.increment);
    });
    assert_survived(&story, &[Exclusion::Stuck, Exclusion::Deviating], 0.3);
}

#[test]
fn a_bias_that_jumps() {
    let story =
        tell(3, 4, |step| step.as_mut().unwrap().increment.angle += DVec3::X * (0.1 * 0.0025));
    assert_survived(&story, &[Exclusion::Deviating], 0.5);
    let story =
        tell(3, 4, |step| step.as_mut().unwrap().increment.velocity += DVec3::Y * (1.5 * 0.0025));
    assert_survived(&story, &[Exclusion::Deviating], 0.5);
}

#[test]
fn a_scale_that_is_wrong() {
    let story = tell(3, 5, |step| step.as_mut().unwrap().increment.velocity *= 1.3);
    assert_survived(&story, &[Exclusion::Deviating], 0.5);
}

#[test]
fn noise_that_grows() {
    let mut random = crate::scene::Normal::seeded(77);
    let story = tell(3, 6, |step| {
        step.as_mut().unwrap().increment.angle += random.vector(0.2 * 0.0025);
    });
    assert_survived(&story, &[Exclusion::Deviating], 1.0);
}

#[test]
fn a_member_that_is_silent() {
    let story = tell(3, 7, |step| *step = None);
    assert_survived(&story, &[Exclusion::Silent], 0.02);
}

#[test]
fn a_member_at_the_end_of_its_range_does_not_count_meanwhile() {
    let story = tell(3, 8, |step| {
        let step = step.as_mut().unwrap();
        step.saturated = true;
        step.increment.angle = step.increment.angle.clamp_length_max(0.1 * 0.0025);
    });
    assert!(story.attitude_step < 0.01 && story.innocent == 0, "{story:?}");
}

#[test]
fn of_two_the_one_that_broke_goes() {
    let mut held = None;
    let story = tell(2, 9, |step| {
        let step = step.as_mut().unwrap();
        step.increment = *held.get_or_insert(step.increment);
    });
    assert_survived(&story, &[Exclusion::Stuck], 0.5);
    let story =
        tell(2, 9, |step| step.as_mut().unwrap().increment.angle += DVec3::Z * (0.5 * 0.0025));
    assert_survived(&story, &[Exclusion::Deviating], 0.5);
    let story = tell(2, 9, |step| *step = None);
    assert_survived(&story, &[Exclusion::Silent], 0.02);
}

#[test]
fn the_last_one_is_never_voted_out() {
    // Given a rig of three of which two go silent, when the third goes on, then so does the pose.
    let mut scene = scene(3, 10);
    while scene.time_s() < 15.0 {
        let report = scene.step(|time_s, steps| {
            if time_s > 8.0 {
                (steps[0], steps[1]) = (None, None);
            }
        });
        assert!(report.is_some());
    }
    assert!(attitude_error(&scene).truncate().length() < 0.02);
}

#[test]
fn with_all_present_nobody_is_ever_accused() {
    for (seed, sway) in [(11, 0.05), (12, 0.2)] {
        let mut settings = Settings { scale_error: 7e-3, ..Settings::indoors(seed) };
        settings.walk.sway_rad = sway;
        let mut scene = Scene::new(settings, seed);
        while scene.time_s() < 40.0 {
            let Some(report) = scene.step(|_, _| {}) else { continue };
            let out = report.members.iter().any(|m| m.exclusion.is_some());
            assert!(!out, "{:?} at {}", report.members, scene.time_s());
        }
    }
}
