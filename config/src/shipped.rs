//! The files that are shipped.

use crate::model::Config;

/// The configuration that `lodestoned` runs without `--config`, as text: two synthetic cameras
/// carried through a room.
pub const EMBEDDED: &str = include_str!("../shipped/default.toml");

/// The configuration of `lodestoned demo`, as text: two cameras that see the same room.
pub const DEMO: &str = include_str!("../shipped/demo.toml");

/// The places of the paper's static table, each a configuration with one synthetic camera: file
/// name in `config/scenarios` and text, in the paper's order.
pub const STATIC_SCENARIOS: [(&str, &str); 6] = [
    ("model.toml", include_str!("../scenarios/model.toml")),
    ("lab.toml", include_str!("../scenarios/lab.toml")),
    ("icev-centre.toml", include_str!("../scenarios/icev-centre.toml")),
    ("icev-front.toml", include_str!("../scenarios/icev-front.toml")),
    ("ev-centre.toml", include_str!("../scenarios/ev-centre.toml")),
    ("ev-front.toml", include_str!("../scenarios/ev-front.toml")),
];

/// The scenes of the paper's dynamic part, each a synthetic camera of one configuration: file name in
/// `config/scenarios` and text.
pub const DYNAMIC_SCENARIO: (&str, &str) =
    ("dynamic.toml", include_str!("../scenarios/dynamic.toml"));

impl Config {
    /// The configuration that `lodestoned` runs without `--config`: [`EMBEDDED`], checked.
    ///
    /// # Panics
    ///
    /// Never in a build whose tests pass: they read the same text.
    pub fn embedded() -> Self {
        Self::shipped("embedded configuration", EMBEDDED)
    }

    /// The configuration of `lodestoned demo`: [`DEMO`], checked.
    ///
    /// # Panics
    ///
    /// As [`Config::embedded`].
    pub fn demo() -> Self {
        Self::shipped("configuration of the demo", DEMO)
    }

    fn shipped(name: &str, text: &str) -> Self {
        match Self::from_toml(name, text) {
            Ok(config) => config,
            Err(errors) => unreachable!("{errors}"),
        }
    }
}
