//! Lodestone's configuration: typed, checked, explained.
//!
//! [`Config::load`] reads a file and either gives a configuration in which every value is in its
//! range, or everything that is wrong with the file, each with line, key and what is allowed:
//!
//! ```text
//! rig.toml:12: camera.synthetic.rest_s: -1 is out of range; allowed: a number from 0 to 3600 s
//! ```
//!
//! One key table drives these checks and [`explain`]; a test holds it and the types of [`model`]
//! together. [`Calibration`] is the file that belongs to one camera.

mod calibration;
mod check;
mod error;
mod explain;
mod kept_world;
mod keys;
mod load;
pub mod model;
mod shipped;
mod summary;

pub use calibration::{
    AccelerometerCalibration, Calibration, Date, GyroCalibration, MagnetometerCalibration,
    TemperatureRange,
};
pub use error::{ConfigError, ConfigErrors, LoadError};
pub use explain::{KeyInfo, calibration_keys, explain, explain_calibration, keys};
pub use kept_world::{KEPT_WORLD_FORMAT, KeptCamera, KeptSource, KeptWorld};
pub use load::{Loaded, MAX_FILE_BYTES};
pub use model::Config;
pub use shipped::{DEMO, DYNAMIC_SCENARIO, EMBEDDED, STATIC_SCENARIOS};
