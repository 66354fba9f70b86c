//! The files that are shipped.

use crate::model::Config;

/// The configuration that `lodestoned` runs without `--config`, as text: two synthetic cameras
/// carried through a room.
pub const EMBEDDED: &str = include_str!("../shipped/default.toml");

impl Config {
    /// The configuration that `lodestoned` runs without `--config`: [`EMBEDDED`], checked.
    ///
    /// # Panics
    ///
    /// Never in a build whose tests pass: they read the same text.
    pub fn embedded() -> Self {
        match Self::from_toml("embedded configuration", EMBEDDED) {
            Ok(config) => config,
            Err(errors) => unreachable!("{errors}"),
        }
    }
}
