//! Rules between keys, each a function of its own.

use std::collections::BTreeMap;

use super::report::Report;
use super::scene;
use crate::model::{Camera, Config, DriverKind, Lane, Rig, RigidBody, SharedMemory, Synthetic};

/// Most poses in the pool of one camera's service: about 120 MB of shared memory.
const MAX_POOL: usize = 262_144;

/// Checks all rules between the keys of a configuration.
pub(crate) fn check(config: &Config, report: &mut Report) {
    some_camera(config, report);
    unique_names(&config.camera, report);
    unique_serials(&config.camera, report);
    bodies(config, report);
    pool_fits(&config.shared_memory, report);
    limits_in_order(&config.lane, report);
    limits_above_step(&config.lane, report);
    for (index, camera) in config.camera.iter().enumerate() {
        let place = format!("camera[{index}]");
        serial_where_needed(camera, &place, report);
        section_of_driver(camera, &place, report);
        events_before_end(camera, &place, report);
        low_pass_below_half_rate(camera, &place, report);
    }
    scene::check(config, report);
}

fn some_camera(config: &Config, report: &mut Report) {
    if config.camera.is_empty() {
        let problem = "no camera is configured".into();
        report.conflict("camera", &[], problem, "at least one table headed [[camera]]");
    }
}

fn unique_names(cameras: &[Camera], report: &mut Report) {
    let mut seen = BTreeMap::new();
    for (index, camera) in cameras.iter().enumerate() {
        let place = format!("camera[{index}].name");
        if let Some(first) = seen.insert(&camera.name, place.clone()) {
            let line = report.line(&first);
            let problem =
                format!("\"{}\" is also the name of the camera in line {line}", camera.name);
            report.conflict(&place, &[&first], problem, "a different name for each camera");
        }
    }
}

fn unique_serials(cameras: &[Camera], report: &mut Report) {
    let mut seen = BTreeMap::new();
    for (index, camera) in cameras.iter().enumerate().filter(|(_, camera)| camera.serial != 0) {
        let place = format!("camera[{index}].serial");
        if let Some(first) = seen.insert(camera.serial, place.clone()) {
            let line = report.line(&first);
            let problem = format!("{} is also the serial number in line {line}", camera.serial);
            report.conflict(&place, &[&first], problem, "a different serial for each camera");
        }
    }
}

fn bodies(config: &Config, report: &mut Report) {
    unique_body_names(&config.body, report);
    for (index, body) in config.body.iter().enumerate() {
        body_unlike_cameras(body, &config.camera, &format!("body[{index}].name"), report);
        cpu_of_a_rig(config, index, report);
    }
    for (index, camera) in config.camera.iter().enumerate() {
        body_exists(camera, config, &format!("camera[{index}].body"), report);
    }
    for rig in config.rigs() {
        few_enough(&rig, report);
        one_motion(config, &rig, report);
    }
}

/// A body with fewer than two cameras has no thread of its own.
fn cpu_of_a_rig(config: &Config, body: usize, report: &mut Report) {
    let is_rig = config.rigs().iter().any(|rig| rig.body == body);
    if config.body[body].cpu.is_some() && !is_rig {
        let problem =
            "is for the common lane of several cameras, and fewer than two name this body";
        let allowed = "this key only with two cameras or more; for a single one, camera.cpu";
        report.conflict(&format!("body[{body}].cpu"), &[], problem.into(), allowed);
    }
}

/// Most cameras of one body.
const MAX_MEMBERS: usize = 8;

fn few_enough(rig: &Rig, report: &mut Report) {
    let Some(index) = rig.members.get(MAX_MEMBERS) else { return };
    let (place, first) =
        (format!("camera[{index}].body"), format!("camera[{}].body", rig.members[0]));
    let problem = format!("is named by {} cameras", rig.members.len());
    report.conflict(&place, &[&first], problem, "at most 8 cameras on one body");
}

/// What rides on one body moves as one.
fn one_motion(config: &Config, rig: &Rig, report: &mut Report) {
    let motion = |index: usize| {
        let camera = &config.camera[index];
        let synthetic = camera.synthetic.clone().unwrap_or_default();
        (camera.driver == DriverKind::Synthetic).then_some(synthetic)
    };
    let first = rig.members[0];
    for &index in &rig.members[1..] {
        let (Some(own), Some(leader)) = (motion(index), motion(first)) else { continue };
        if !moves_alike(&own, &leader) {
            let place = format!("camera[{index}].synthetic");
            let other = format!("camera[{first}].synthetic");
            let problem = format!(
                "moves unlike the camera in line {} on the same body",
                report.line(&format!("camera[{first}].name"))
            );
            let allowed = "the same trajectory, rest_s, tilt_deg, arm_m and halt_s; position_m and heading_deg \
                           the same, or none";
            report.conflict(&place, &[&other], problem, allowed);
        }
    }
}

/// Where and whither the motion begins need not be said again.
fn moves_alike(own: &Synthetic, leader: &Synthetic) -> bool {
    let kind = |s: &Synthetic| (s.trajectory, s.rest_s, s.tilt_deg, s.arm_m, s.halt_s);
    let begins_alike = own.position_m.is_none_or(|place| leader.position_m == Some(place))
        && own.heading_deg.is_none_or(|heading| leader.heading_deg == Some(heading))
        && own.pitch_deg.is_none_or(|pitch| leader.pitch_deg == Some(pitch))
        && own.roll_deg.is_none_or(|roll| leader.roll_deg == Some(roll));
    kind(own) == kind(leader) && begins_alike
}

fn unique_body_names(bodies: &[RigidBody], report: &mut Report) {
    let mut seen = BTreeMap::new();
    for (index, body) in bodies.iter().enumerate() {
        let place = format!("body[{index}].name");
        if let Some(first) = seen.insert(&body.name, place.clone()) {
            let line = report.line(&first);
            let problem = format!("\"{}\" is also the name of the body in line {line}", body.name);
            report.conflict(&place, &[&first], problem, "a different name for each body");
        }
    }
}

/// What is published for a body and for a camera stands under its name.
fn body_unlike_cameras(body: &RigidBody, cameras: &[Camera], place: &str, report: &mut Report) {
    let Some(index) = cameras.iter().position(|camera| camera.name == body.name) else { return };
    let other = format!("camera[{index}].name");
    let line = report.line(&other);
    let problem = format!("\"{}\" is also the name of the camera in line {line}", body.name);
    report.conflict(place, &[&other], problem, "a name that no camera has");
}

fn body_exists(camera: &Camera, config: &Config, place: &str, report: &mut Report) {
    let Some(name) = &camera.body else { return };
    if config.body_of(camera).is_none() {
        let problem = format!("no body is called \"{name}\"");
        let known: Vec<String> = config.body.iter().map(|b| format!("\"{}\"", b.name)).collect();
        let allowed = if known.is_empty() {
            "the name of a table headed [[body]], of which there is none".into()
        } else {
            format!("the name of a table headed [[body]]: {}", known.join(", "))
        };
        report.conflict(place, &[], problem, &allowed);
    }
}

/// iceoryx2 sets memory aside for every consumer's buffer and for the history itself.
fn pool_fits(shared_memory: &SharedMemory, report: &mut Report) {
    let pool = shared_memory.pose_history.saturating_mul(shared_memory.max_subscribers + 1);
    if pool > MAX_POOL {
        let problem = format!("with max_subscribers it needs room for {pool} poses of each camera");
        let allowed = format!("pose_history × (max_subscribers + 1) up to {MAX_POOL}");
        let others = ["shared_memory.max_subscribers"];
        report.conflict("shared_memory.pose_history", &others, problem, &allowed);
    }
}

fn limits_in_order(lane: &Lane, report: &mut Report) {
    let limits =
        [("lane.bridge_limit_s", lane.bridge_limit_s), ("lane.stale_after_s", lane.stale_after_s)];
    for (key, limit_s) in limits {
        if limit_s > lane.reset_after_s {
            let problem = format!("{limit_s} is longer than reset_after_s, {}", lane.reset_after_s);
            report.conflict(key, &["lane.reset_after_s"], problem, "at most lane.reset_after_s");
        }
    }
}

fn limits_above_step(lane: &Lane, report: &mut Report) {
    let Some(step_rate_hz) = lane.step_rate_hz else { return };
    let limits =
        [("lane.bridge_limit_s", lane.bridge_limit_s), ("lane.stale_after_s", lane.stale_after_s)];
    for (key, limit_s) in limits {
        if limit_s * step_rate_hz < 1.0 {
            let problem = format!("{limit_s} is shorter than a step at {step_rate_hz} Hz");
            report.conflict(key, &["lane.step_rate_hz"], problem, "at least 1 / step_rate_hz");
        }
    }
}

fn serial_where_needed(camera: &Camera, place: &str, report: &mut Report) {
    let reason = if camera.driver == DriverKind::Zed2 {
        "driver \"zed2\" finds the camera by it"
    } else if camera.calibration.is_some() {
        "the calibration file is bound to it"
    } else {
        return;
    };
    if camera.serial == 0 {
        let problem = format!("is missing, and {reason}");
        let driver = format!("{place}.driver");
        let allowed = "the number printed on the camera, a whole number from 1";
        report.conflict(&format!("{place}.serial"), &[&driver], problem, allowed);
    }
}

/// A recording tells its rate itself; it is looked at when the lane is made.
fn low_pass_below_half_rate(camera: &Camera, place: &str, report: &mut Report) {
    let rate_hz = camera.model.nominal_rate_hz();
    let Some(cut_off_hz) = camera.low_pass_hz else { return };
    if camera.driver != DriverKind::Replay && cut_off_hz >= 0.45 * rate_hz {
        let problem =
            format!("{cut_off_hz} Hz cannot be told from lower frequencies at {rate_hz} samples/s");
        let allowed = format!("below {} Hz", 0.45 * rate_hz);
        report.conflict(&format!("{place}.low_pass_hz"), &[], problem, &allowed);
    }
}

fn section_of_driver(camera: &Camera, place: &str, report: &mut Report) {
    let driver = format!("{place}.driver");
    let (synthetic, replay) = (format!("{place}.synthetic"), format!("{place}.replay"));
    if camera.driver == DriverKind::Replay && camera.replay.is_none() {
        let problem = "driver \"replay\" needs a recording".into();
        report.conflict(&replay, &[&driver], problem, "a table [camera.replay] with the key file");
    }
    let sections = [
        (DriverKind::Synthetic, "synthetic", synthetic, camera.synthetic.is_some()),
        (DriverKind::Replay, "replay", replay, camera.replay.is_some()),
    ];
    for (kind, name, section, present) in sections {
        if present && camera.driver != kind {
            let problem = format!("the driver of camera \"{}\" is another one", camera.name);
            let allowed = format!("this table only with driver = \"{name}\"");
            report.conflict(&section, &[&driver], problem, &allowed);
        }
    }
}

/// What begins after the source has ended never happens: a test would pass without its fault.
fn events_before_end(camera: &Camera, place: &str, report: &mut Report) {
    let Some(synthetic) = &camera.synthetic else { return };
    let end_s = synthetic.duration_s;
    let end = format!("{place}.synthetic.duration_s");
    if end_s == 0.0 {
        return;
    }
    let faults = camera.fault.iter().map(|fault| fault.at_s).zip(0..);
    let faults = faults.map(|(at_s, index)| (at_s, format!("{place}.fault[{index}].at_s")));
    let disturbances = synthetic.disturbance.iter().map(|disturbance| disturbance.at_s).zip(0..);
    let disturbances = disturbances
        .map(|(at_s, index)| (at_s, format!("{place}.synthetic.disturbance[{index}].at_s")));
    for (at_s, key) in faults.chain(disturbances) {
        if at_s >= end_s {
            let problem = format!("{at_s} is after the end of the source at {end_s} s");
            report.conflict(&key, &[&end], problem, "less than camera.synthetic.duration_s");
        }
    }
}
