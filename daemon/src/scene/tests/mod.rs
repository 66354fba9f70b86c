//! The scene from outside: distances, rays, and what stereo makes of them.

mod exposure;
mod geometry;
mod stereo;

use std::convert::Infallible;

use glam::{DQuat, DVec3, EulerRot};
use lodestone_client::{Body, Rotation, Transform, World, body_from_optical_axes};
use lodestone_config::model::{self, Camera, Depth};
use lodestone_schema::CloudPoint;

use super::{DepthCamera, Frame, Scene};

/// Where a body is: yaw to the left, pitch nose down, roll right side down, rad.
fn pose(position_m: [f64; 3], [yaw, pitch, roll]: [f64; 3]) -> Transform<World, Body> {
    let turn = DQuat::from_euler(EulerRot::ZYX, yaw, pitch, roll);
    let rotation = Rotation::from_quaternion(turn).expect("a unit quaternion");
    Transform::new(rotation, DVec3::from_array(position_m))
}

/// A small camera without errors of any kind.
fn perfect() -> Depth {
    Depth {
        width: 50,
        height: 33,
        sigma_per_m: 0.0,
        min_m: 0.0,
        max_m: 1000.0,
        rolling_shutter_s: 0.0,
        drop_probability: 0.0,
        grazing_deg: 0.0,
        ..Depth::default()
    }
}

fn camera(depth: Depth) -> DepthCamera {
    DepthCamera::new(&Camera { depth: Some(depth), ..Camera::default() }, 0)
}

/// A cloud as `camera` sees it from one place.
fn exposed(
    camera: &DepthCamera,
    scene: &Scene,
    place: Transform<World, Body>,
    frame: Frame,
) -> Vec<CloudPoint> {
    let nothing = CloudPoint { position_m: [0.0; 3], time_offset_ns: -1, colour: [0; 4] };
    let mut cloud = vec![nothing; camera.points()];
    let still = |_| Ok::<_, Infallible>(place);
    let Ok(()) = camera.expose(scene, frame, still, &mut cloud);
    cloud
}

const FIRST: Frame = Frame { number: 0, time_ns: 1_000_000_000 };

/// A point of a cloud in W.
fn in_world(place: Transform<World, Body>, point: &CloudPoint) -> DVec3 {
    let optical = DVec3::from_array(point.position_m.map(f64::from));
    (place * body_from_optical_axes()).apply(optical)
}

/// A bare room of 6 by 5 by 3 m, whose centre is the origin.
fn bare() -> model::Scene {
    let room =
        model::Room { centre_m: [0.0; 3], size_m: [6.0, 5.0, 3.0], ..model::Room::default() };
    model::Scene { room, ..model::Scene::default() }
}

/// Every kind of solid in a room that is turned, and something that moves.
fn furnished() -> model::Scene {
    let table = model::SceneBox {
        centre_m: [1.2, 0.9, -0.7],
        size_m: [1.4, 0.8, 0.06],
        heading_deg: 20.0,
        pattern: model::Pattern::Planks,
        ..model::SceneBox::default()
    };
    let cupboard = model::SceneBox {
        centre_m: [-1.9, 0.2, -0.4],
        size_m: [0.6, 1.2, 2.2],
        heading_deg: -11.0,
        pattern: model::Pattern::Checks,
        ..model::SceneBox::default()
    };
    let column = model::Cylinder {
        centre_m: [0.7, -1.3, 0.0],
        radius_m: 0.2,
        height_m: 3.0,
        ..model::Cylinder::default()
    };
    let mover = model::SceneMover {
        shape: model::MoverShape::Ball,
        centre_m: [0.1, 0.0, -1.2],
        period_s: 7.0,
        ..model::SceneMover::default()
    };
    let room = model::Room { heading_deg: 33.0, ..bare().room };
    model::Scene { room, boxes: vec![table, cupboard], cylinder: vec![column], mover: Some(mover) }
}
