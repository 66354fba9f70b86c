//! The tree of frames: world, bodies, cameras, their lenses and magnetometers.

use glam::{DMat3, DQuat, DVec3};
use lodestone_config::model::{Camera, Config};
use lodestone_schema::{StaticTransform, TransformKind};

use super::pairs::{field_of, mount_of};

/// Name of the world's frame.
const WORLD: &str = "world";

/// One edge of the tree: `p_parent = R p_child + t`.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// The frame in which the child is.
    pub parent: String,
    /// The frame that is in it.
    pub child: String,
    /// `None` where the child moves: its pose says where it is.
    pub fixed: Option<Fixed>,
}

/// An edge that never changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fixed {
    /// Origin of the child in the parent's axes, m; `None` where it is not configured.
    pub translation_m: Option<DVec3>,
    /// Child to parent.
    pub rotation: DQuat,
}

/// The tree of a configuration, each parent before its children.
pub fn tree(config: &Config) -> Vec<Edge> {
    let moving = |child: &str| Edge { parent: WORLD.into(), child: child.into(), fixed: None };
    let mut edges: Vec<Edge> = config.body.iter().map(|body| moving(&body.name)).collect();
    for camera in &config.camera {
        edges.push(match &camera.body {
            Some(body) => mounted(camera, body),
            None => moving(&camera.name),
        });
        edges.push(lens(camera));
        edges.push(magnetometer(camera));
    }
    edges
}

fn mounted(camera: &Camera, body: &str) -> Edge {
    let mount = mount_of(camera);
    let rotation = mount.orientation.quaternion();
    let fixed = Some(Fixed { translation_m: Some(mount.position), rotation });
    Edge { parent: body.into(), child: camera.name.clone(), fixed }
}

fn lens(camera: &Camera) -> Edge {
    let translation_m = camera.lens_position_m.map(DVec3::from);
    let fixed = Some(Fixed { translation_m, rotation: body_from_optical() });
    Edge { parent: camera.name.clone(), child: format!("{}/optical", camera.name), fixed }
}

fn magnetometer(camera: &Camera) -> Edge {
    let translation_m = Some(camera.magnetometer_position_m.into());
    let fixed = Some(Fixed { translation_m, rotation: DQuat::IDENTITY });
    Edge { parent: camera.name.clone(), child: format!("{}/magnetometer", camera.name), fixed }
}

/// Optical axes (x right, y down, z forward) to body axes (x forward, y left, z up).
fn body_from_optical() -> DQuat {
    DQuat::from_mat3(&DMat3::from_cols(DVec3::NEG_Y, DVec3::NEG_Z, DVec3::X))
}

/// The messages of a tree.
pub fn messages(edges: &[Edge]) -> Vec<StaticTransform> {
    let count = edges.len() as u32;
    edges.iter().zip(0..).map(|(edge, index)| message(edge, index, count)).collect()
}

fn message(edge: &Edge, index: u32, count: u32) -> StaticTransform {
    let (kind, translation_m, rotation) = match &edge.fixed {
        None => (TransformKind::Moving, DVec3::NAN, [f64::NAN; 4]),
        Some(fixed) => (
            TransformKind::Fixed,
            fixed.translation_m.unwrap_or(DVec3::NAN),
            fixed.rotation.to_array(),
        ),
    };
    StaticTransform {
        sequence: index.into(),
        index,
        count,
        kind: kind.code(),
        parent: field_of(&edge.parent),
        child: field_of(&edge.child),
        translation_m: translation_m.to_array(),
        rotation,
        ..blank()
    }
}

/// A message of which nothing is known.
pub(crate) const fn blank() -> StaticTransform {
    StaticTransform {
        sequence: 0,
        time_ns: 0,
        index: 0,
        count: 0,
        kind: TransformKind::Moving.code(),
        reserved: [0; 7],
        parent: [0; lodestone_schema::NAME_BYTES],
        child: [0; lodestone_schema::NAME_BYTES],
        translation_m: [f64::NAN; 3],
        rotation: [f64::NAN; 4],
    }
}

#[cfg(test)]
mod tests {
    use lodestone_config::model::{Mounting, RigidBody};

    use super::*;

    #[test]
    fn every_frame_but_the_world_is_the_child_of_one_that_came_before() {
        let camera = |name: &str, body: Option<&str>| Camera {
            name: name.into(),
            body: body.map(Into::into),
            mounting: Mounting {
                position_m: [1.0, 0.0, 0.5],
                roll_pitch_yaw_deg: [0.0, 0.0, 90.0],
                ..Mounting::default()
            },
            ..Camera::default()
        };
        let config = Config {
            camera: vec![camera("front", Some("car")), camera("hand", None)],
            body: vec![RigidBody { name: "car".into(), ..RigidBody::default() }],
            ..Config::default()
        };
        let edges = tree(&config);
        let mut known = vec![WORLD.to_owned()];
        for edge in &edges {
            assert!(known.contains(&edge.parent), "{edge:?}");
            assert!(!known.contains(&edge.child), "{edge:?}");
            known.push(edge.child.clone());
        }
        let of = |child: &str| edges.iter().find(|edge| edge.child == child).unwrap();
        assert_eq!((of("car").parent.as_str(), of("car").fixed), ("world", None));
        // Turned to the left: what is ahead of the camera is to the left of the car.
        let front = of("front").fixed.unwrap();
        let ahead = front.rotation * DVec3::X * 2.0 + front.translation_m.unwrap();
        assert!((ahead - DVec3::new(1.0, 2.0, 0.5)).length() < 1e-12);
        // What a lens sees ahead (z) is ahead of the body (x); where the lens is, nobody has said.
        let lens = of("front/optical").fixed.unwrap();
        assert!((lens.rotation * DVec3::Z - DVec3::X).length() < 1e-12);
        assert_eq!(lens.translation_m, None);
        assert_eq!(of("hand").fixed, None);
    }
}
