//! The configuration as types. Every field carries its unit in its name; ranges and meanings of
//! all keys stand in one table, [`crate::keys`], that `lodestoned check --explain` prints.
//!
//! The types alone check only names and types of keys. Use [`Config::load`] or
//! [`Config::from_toml`], which check every value.

mod body;
mod camera;
mod depth;
mod estimator;
mod lane;
mod realtime;
mod scene;
mod synthetic;

pub use body::RigidBody;
pub use camera::{
    AxisMap, Camera, CameraModel, DriverKind, Fault, FaultKind, Mounting, Noise, Replay,
    SignedAxis, Start,
};
pub use depth::Depth;
pub use estimator::{Estimator, HeadingMode, Preset, ValidityBounds};
pub use lane::{Lane, SharedMemory, Threads};
pub use realtime::{Policy, Realtime};
pub use scene::{Cylinder, MoverShape, Pattern, Room, Scene, SceneBox, SceneMover};
pub use synthetic::{
    Disturbance, Instrument, MagneticDistortion, Motor, SensorErrors, Synthetic, TrajectoryKind,
    Transport,
};

use serde::{Deserialize, Serialize};

/// The whole configuration of one daemon.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// The world frame.
    pub world: World,
    /// Where and how poses are laid in shared memory.
    pub shared_memory: SharedMemory,
    /// How every camera's lane runs.
    pub lane: Lane,
    /// How the lanes' threads are scheduled.
    pub realtime: Realtime,
    /// The filter, one set of parameters for all cameras.
    pub estimator: Estimator,
    /// What synthetic cameras see; none if absent.
    pub scene: Option<Scene>,
    /// Rigid bodies that carry cameras.
    pub body: Vec<RigidBody>,
    /// The cameras, at least one.
    pub camera: Vec<Camera>,
}

/// Cameras that are mounted on one body: one lane, one motion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rig {
    /// Index of the body in [`Config::body`].
    pub body: usize,
    /// Indices of its cameras in [`Config::camera`], at least two.
    pub members: Vec<usize>,
}

impl Config {
    /// The bodies that carry several cameras, in their order. A single camera on a body is a camera
    /// like any other.
    pub fn rigs(&self) -> Vec<Rig> {
        let members = |name: &String| {
            let on_it = |camera: &Camera| camera.body.as_ref() == Some(name);
            let cameras = self.camera.iter().enumerate();
            cameras.filter(|(_, camera)| on_it(camera)).map(|(index, _)| index).collect()
        };
        let rigs = self.body.iter().enumerate();
        let rigs = rigs.map(|(body, rigid)| Rig { body, members: members(&rigid.name) });
        rigs.filter(|rig| rig.members.len() > 1).collect()
    }

    /// Name and serial number of what a lane's index stands for: a camera, or behind the cameras a body,
    /// which has no serial number.
    pub fn published_as(&self, index: usize) -> (&str, u64) {
        let bodies = || &self.body[index - self.camera.len()].name;
        self.camera.get(index).map_or_else(|| (bodies().as_str(), 0), |c| (&c.name, c.serial))
    }

    /// The camera whose simulated motion a camera rides on: the first of its body, else itself.
    pub fn leader_of<'a>(&'a self, camera: &'a Camera) -> &'a Camera {
        let first = |name: &String| {
            let on_it = |other: &&Camera| other.body.as_ref() == Some(name);
            self.camera.iter().find(on_it)
        };
        camera.body.as_ref().and_then(first).unwrap_or(camera)
    }

    /// The body that a camera sits on, if it names one.
    pub fn body_of(&self, camera: &Camera) -> Option<&RigidBody> {
        let name = camera.body.as_ref()?;
        self.body.iter().find(|body| body.name == *name)
    }
}

/// Which way the world's y axis points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum North {
    /// Along the horizontal magnetic field.
    #[default]
    Magnetic,
    /// True north, by the declination of the World Magnetic Model.
    True,
}

impl North {
    /// Its word in a configuration.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Magnetic => "magnetic",
            Self::True => "true",
        }
    }
}

/// The world frame and the place that fixes the earth's field in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct World {
    /// Which north.
    pub north: North,
    /// Geodetic latitude, degrees, north positive.
    pub latitude_deg: f64,
    /// Longitude, degrees, east positive.
    pub longitude_deg: f64,
    /// Height above the WGS 84 ellipsoid, m.
    pub altitude_m: f64,
    /// Decimal year for the World Magnetic Model; today if absent.
    pub year: Option<f64>,
    /// File in which the world is kept from one run to the next, relative to this configuration's
    /// directory; not kept if absent.
    pub keep: Option<String>,
    /// How far a camera may have been moved while the daemon did not run, 1σ, m, per axis.
    pub moved_sigma_m: f64,
    /// Speed with which a camera may have been moved while its lane could not see it, 1σ, m/s.
    pub unseen_speed_m_s: f64,
    /// How long the first camera is waited for before the next one fixes the world, s.
    pub patience_s: f64,
    /// Magnetised steel in the simulated world.
    pub steel: Vec<Steel>,
}

/// A piece of magnetised steel that stands still, as a dipole.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Steel {
    /// Where it stands in the world, m.
    pub position_m: [f64; 3],
    /// Its dipole moment in the world, A m².
    pub moment_a_m2: [f64; 3],
}

impl Default for World {
    fn default() -> Self {
        // Garching near Munich, where the paper was written.
        Self {
            north: North::Magnetic,
            latitude_deg: 48.262,
            longitude_deg: 11.668,
            altitude_m: 480.0,
            year: None,
            keep: None,
            moved_sigma_m: 0.3,
            unseen_speed_m_s: 0.3,
            patience_s: 10.0,
            steel: Vec::new(),
        }
    }
}
