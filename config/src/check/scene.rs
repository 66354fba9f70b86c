//! Rules of the scene, of where synthetic cameras truly are in it, and of their depth sources.

use super::report::Report;
use crate::model::{Camera, Config, Depth, DriverKind, Room, Scene, Synthetic, TrajectoryKind};

/// Most points of a cloud: 20 MB of shared memory.
const MAX_POINTS: usize = 1 << 20;
/// What may stand this far inside a wall, m: measures in millimetres add up.
const TOLERANCE_M: f64 = 1e-3;

/// Checks the rules.
pub(super) fn check(config: &Config, report: &mut Report) {
    if let Some(scene) = &config.scene {
        furniture_inside(scene, report);
    }
    for (index, camera) in config.camera.iter().enumerate() {
        let place = format!("camera[{index}]");
        if let Some(synthetic) = &camera.synthetic {
            tilt_of_standing(synthetic, &place, report);
        }
        if let Some(depth) = &camera.depth {
            depth_of_synthetic(camera, &place, report);
            few_enough_points(depth, &place, report);
            shutter_within_frame(depth, &place, report);
            range_in_order(depth, &place, report);
        }
        begins_inside(config, camera, &place, report);
    }
    first_at_the_origin(config, report);
}

/// Corners, or ends and sides, of everything that stands or moves in the room.
fn furniture_inside(scene: &Scene, report: &mut Report) {
    let inside = |place: String, points: &[[f64; 3]], report: &mut Report| {
        if points.iter().any(|&point| !holds(&scene.room, point, TOLERANCE_M)) {
            let others = ["scene.room.centre_m", "scene.room.size_m", "scene.room.heading_deg"];
            let problem = "reaches through a wall, the floor or the ceiling of the room".into();
            report.conflict(&place, &others, problem, "a place inside scene.room");
        }
    };
    for (index, b) in scene.boxes.iter().enumerate() {
        let half = b.size_m.map(|side| 0.5 * side);
        inside(format!("scene.box[{index}]"), &corners(b.centre_m, half, b.heading_deg), report);
    }
    for (index, c) in scene.cylinder.iter().enumerate() {
        let points = ring(c.centre_m, c.radius_m, c.radius_m, 0.5 * c.height_m);
        inside(format!("scene.cylinder[{index}]"), &points, report);
    }
    if let Some(m) = &scene.mover {
        let half = 0.5 * m.size_m;
        let way = ring(m.centre_m, m.reach_east_m + half, m.reach_north_m + half, half);
        inside("scene.mover".into(), &way, report);
    }
}

/// Whether a point of the world is in a room, or this far outside.
fn holds(room: &Room, point: [f64; 3], tolerance_m: f64) -> bool {
    let [x, y, z] = std::array::from_fn(|axis| point[axis] - room.centre_m[axis]);
    let (x, y) = turned(x, y, room.heading_deg);
    let offsets = [x, y, z].into_iter().zip(room.size_m);
    offsets.map(|(offset, side)| offset.abs() - 0.5 * side).all(|beyond| beyond <= tolerance_m)
}

/// A vector turned anticlockwise, seen from above.
fn turned(x: f64, y: f64, angle_deg: f64) -> (f64, f64) {
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    (cos * x - sin * y, sin * x + cos * y)
}

fn corners(centre: [f64; 3], half: [f64; 3], heading_deg: f64) -> Vec<[f64; 3]> {
    let corner = |number: usize| {
        let sign = |bit: usize| if number >> bit & 1 == 0 { -1.0 } else { 1.0 };
        let (x, y) = turned(sign(0) * half[0], sign(1) * half[1], -heading_deg);
        [centre[0] + x, centre[1] + y, centre[2] + sign(2) * half[2]]
    };
    (0..8).map(corner).collect()
}

/// Points round an upright ellipse's rims.
fn ring(centre: [f64; 3], east: f64, north: f64, half_height: f64) -> Vec<[f64; 3]> {
    const POINTS: u32 = 72;
    let point = |number: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(number) / f64::from(POINTS)).sin_cos();
        let height = if number.is_multiple_of(2) { half_height } else { -half_height };
        [centre[0] + east * cos, centre[1] + north * sin, centre[2] + height]
    };
    (0..POINTS).map(point).collect()
}

fn tilt_of_standing(synthetic: &Synthetic, place: &str, report: &mut Report) {
    if synthetic.trajectory == TrajectoryKind::Standing {
        return;
    }
    for (key, given) in [("pitch_deg", synthetic.pitch_deg), ("roll_deg", synthetic.roll_deg)] {
        if given.is_some() {
            let trajectory = format!("{place}.synthetic.trajectory");
            let problem = "the camera moves, and tilts as its trajectory says".into();
            let allowed = "this key only with trajectory = \"standing\"";
            report.conflict(&format!("{place}.synthetic.{key}"), &[&trajectory], problem, allowed);
        }
    }
}

fn depth_of_synthetic(camera: &Camera, place: &str, report: &mut Report) {
    if camera.driver != DriverKind::Synthetic {
        let problem = format!("the driver of camera \"{}\" is another one", camera.name);
        let driver = format!("{place}.driver");
        let allowed = "this table only with driver = \"synthetic\"";
        report.conflict(&format!("{place}.depth"), &[&driver], problem, allowed);
    }
}

fn few_enough_points(depth: &Depth, place: &str, report: &mut Report) {
    let points = depth.width.saturating_mul(depth.height);
    if points > MAX_POINTS {
        let problem = format!("with height that is {points} points");
        let (width, height) = (format!("{place}.depth.width"), format!("{place}.depth.height"));
        report.conflict(&width, &[&height], problem, &format!("width × height up to {MAX_POINTS}"));
    }
}

fn shutter_within_frame(depth: &Depth, place: &str, report: &mut Report) {
    if depth.rolling_shutter_s * depth.rate_hz > 1.0 {
        let (key, rate) =
            (format!("{place}.depth.rolling_shutter_s"), format!("{place}.depth.rate_hz"));
        let problem = format!("{} is longer than a frame", depth.rolling_shutter_s);
        report.conflict(&key, &[&rate], problem, "at most 1 / rate_hz");
    }
}

fn range_in_order(depth: &Depth, place: &str, report: &mut Report) {
    if depth.min_m >= depth.max_m {
        let (min, max) = (format!("{place}.depth.min_m"), format!("{place}.depth.max_m"));
        report.conflict(
            &min,
            &[&max],
            format!("{} is not below max_m", depth.min_m),
            "below max_m",
        );
    }
}

/// From outside of the room, a depth source would see nothing.
fn begins_inside(config: &Config, camera: &Camera, place: &str, report: &mut Report) {
    let (Some(scene), Some(_)) = (&config.scene, &camera.depth) else { return };
    let leader = config.leader_of(camera);
    let given = leader.synthetic.as_ref().and_then(|synthetic| synthetic.position_m);
    let begins = given.or(leader.start.map(|start| start.position_m)).unwrap_or_default();
    if !holds(&scene.room, begins, 0.0) {
        let [x, y, z] = begins;
        let problem = format!("the camera begins at {x} {y} {z}, outside of the room");
        let others = ["scene.room.centre_m", "scene.room.size_m"];
        let allowed = "a beginning (camera.synthetic.position_m, camera.start) inside scene.room";
        report.conflict(&format!("{place}.depth"), &others, problem, allowed);
    }
}

/// The world has its origin where the first camera begins, unless that one's start says otherwise.
fn first_at_the_origin(config: &Config, report: &mut Report) {
    let Some(camera) = config.camera.first() else { return };
    let given = camera.synthetic.as_ref().and_then(|synthetic| synthetic.position_m);
    let fixed = camera.start.map_or([0.0; 3], |start| start.position_m);
    let differs = |place: [f64; 3]| place.iter().zip(fixed).any(|(a, b)| (a - b).abs() > 1e-9);
    if given.is_some_and(differs) {
        let problem = "the first camera fixes the world's origin".into();
        let allowed = "camera.start of the first camera, or the origin; move the scene instead";
        let start = "camera[0].start.position_m";
        report.conflict("camera[0].synthetic.position_m", &[start], problem, allowed);
    }
}
