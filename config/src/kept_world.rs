//! The file in which the daemon keeps the world from one run to the next.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::check::Report;
use crate::error::LoadError;
use crate::load::read_text;
use crate::model::North;

/// The format that is written and read.
pub const KEPT_WORLD_FORMAT: u32 = 1;

/// The world as it was fixed, and where each camera was last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeptWorld {
    /// [`KEPT_WORLD_FORMAT`].
    pub format: u32,
    /// Epoch of the world.
    pub epoch: u32,
    /// When it was fixed, ns since the UNIX epoch.
    pub t0_unix_ns: i64,
    /// Which north its y axis points to.
    pub north: North,
    /// The camera or body that fixed it.
    pub first_camera: String,
    /// Whether configured starts are places in it.
    pub starts_hold: bool,
    /// The first camera's rotation at t0, body to world, as a rotation vector, rad.
    pub rotation_rad: [f64; 3],
    /// Standard deviation of its heading, rad.
    pub heading_sigma_rad: f64,
    /// Standard deviation of its tilt, rad.
    pub tilt_sigma_rad: f64,
    /// Field at t0 in the world, µT, if there was a magnetometer.
    pub field_ut: Option<[f64; 3]>,
    /// The magnetometer at the origin, in the first camera's axes, m.
    pub magnetometer_position_m: [f64; 3],
    /// Where cameras and bodies were last, as far as it was known.
    #[serde(default)]
    pub camera: Vec<KeptCamera>,
}

/// Where a camera or body was last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeptCamera {
    /// Its name.
    pub name: String,
    /// Position in the world, m.
    pub position_m: [f64; 3],
    /// Standard deviation per axis, m.
    pub sigma_m: [f64; 3],
    /// Where the position was known from.
    pub source: KeptSource,
}

/// Where a position is known from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum KeptSource {
    /// A place that was configured, and the motion since.
    CommonStart,
    /// Clouds laid over each other.
    CloudRegistration,
    /// The field's gradient.
    MagneticGradient,
    /// A fix of position or pose.
    PositionFix,
}

impl KeptWorld {
    /// Loads the file; `None` if there is none.
    ///
    /// # Errors
    /// The file cannot be read, something in it is wrong, or its north is not the configured one.
    pub fn load(path: impl AsRef<Path>, north: North) -> Result<Option<Self>, LoadError> {
        let path = path.as_ref();
        let text = match read_text(path) {
            Err(LoadError::NotFound { .. }) => return Ok(None),
            text => text?,
        };
        let kept = Self::from_toml(&path.display().to_string(), &text)?;
        if kept.north == north {
            return Ok(Some(kept));
        }
        Err(LoadError::OtherNorth { path: path.into(), found: kept.north, expected: north })
    }

    /// The text of the file.
    ///
    /// # Errors
    /// A time after the year 2262, which TOML cannot write.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        let head = "# The world that lodestoned keeps. Remove this file to begin a new one.\n";
        Ok(format!("{head}{}", toml::to_string(self)?))
    }
}

/// Checks the rules between keys.
pub(crate) fn check(kept: &KeptWorld, report: &mut Report) {
    for (index, camera) in kept.camera.iter().enumerate() {
        if kept.camera[..index].iter().any(|other| other.name == camera.name) {
            let problem = format!("\"{}\" stands here twice", camera.name);
            let place = format!("camera[{index}].name");
            report.conflict(&place, &[], problem, "each camera and body once");
        }
    }
}
