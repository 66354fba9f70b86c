//! From text to checked types, with everything that is wrong in one go.

mod report;
mod rules;
mod scene;
mod walk;

use serde::de::DeserializeOwned;
use toml::Table;
use toml::de::DeTable;

use crate::calibration::{self, Calibration};
use crate::error::ConfigErrors;
use crate::kept_world::{self, KeptWorld};
use crate::keys::{CALIBRATION, CONFIG, KEPT_WORLD, Schema};
use crate::model::Config;
pub(crate) use report::Report;

impl Config {
    /// Reads a configuration from text, and checks every key and every rule between keys.
    ///
    /// `source_name` stands in the messages where a file's name would.
    ///
    /// ```
    /// use lodestone_config::Config;
    /// let text = "[[camera]]\nname = \"front\"\nserail = 7\n";
    /// let errors = Config::from_toml("rig.toml", text).unwrap_err();
    /// assert!(errors.to_string().starts_with(
    ///     "rig.toml:1: camera.serial: is missing, and driver \"zed2\" finds the camera by it"
    /// ));
    /// assert!(errors.to_string().contains(
    ///     "rig.toml:3: camera.serail: unknown key; did you mean camera.serial?"
    /// ));
    /// ```
    ///
    /// # Errors
    ///
    /// Everything that is wrong, each with line, key and what is allowed.
    pub fn from_toml(source_name: &str, text: &str) -> Result<Self, ConfigErrors> {
        read(&CONFIG, source_name, text, rules::check)
    }
}

impl Calibration {
    /// Reads a calibration from text, and checks every key.
    ///
    /// # Errors
    ///
    /// Everything that is wrong, each with line, key and what is allowed.
    pub fn from_toml(source_name: &str, text: &str) -> Result<Self, ConfigErrors> {
        read(&CALIBRATION, source_name, text, calibration::check)
    }
}

impl KeptWorld {
    /// Reads a kept world from text, and checks every key.
    ///
    /// # Errors
    ///
    /// Everything that is wrong, each with line, key and what is allowed.
    pub fn from_toml(source_name: &str, text: &str) -> Result<Self, ConfigErrors> {
        read(&KEPT_WORLD, source_name, text, kept_world::check)
    }
}

/// Reads one kind of file: syntax, then every key, then the rules between keys.
fn read<T: DeserializeOwned>(
    schema: &Schema,
    source_name: &str,
    text: &str,
    rules: fn(&T, &mut Report),
) -> Result<T, ConfigErrors> {
    let mut report = Report::new(source_name, text);
    let (root, errors) = DeTable::parse_recoverable(text);
    if !errors.is_empty() {
        return Err(syntax_errors(report, &errors));
    }
    let clean = walk::walk(schema, &mut report, root.get_ref());
    deserialise(report, clean, rules)
}

fn deserialise<T: DeserializeOwned>(
    mut report: Report,
    clean: Table,
    rules: fn(&T, &mut Report),
) -> Result<T, ConfigErrors> {
    match clean.try_into::<T>() {
        Ok(value) => {
            rules(&value, &mut report);
            report.finish(value)
        }
        // The key table has checked every type; a test holds table and types together. Should
        // they differ all the same, the message is worse, but the file is still refused.
        Err(error) => {
            report.syntax(0, error.message().to_string(), "what `check --explain` prints");
            Err(report.into_errors())
        }
    }
}

/// After a syntax error the parser guesses: what it guessed is not checked, and of the errors that
/// one slip causes in its line only the first is shown.
fn syntax_errors(mut report: Report, errors: &[toml::de::Error]) -> ConfigErrors {
    for error in errors {
        let offset = error.span().map_or(0, |span| span.start);
        let problem = format!("not TOML: {}", error.message());
        report.syntax(offset, problem, "`key = value`, `[table]` or `[[list of tables]]`");
    }
    report.into_errors()
}
