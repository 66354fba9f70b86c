//! All keys in words.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use crate::calibration::Calibration;
use crate::keys::{CALIBRATION, CONFIG, Key, Schema, Section, Shape, join, split};
use crate::model::{Camera, CameraModel, Config};

/// Width of the text, columns.
const WIDTH: usize = 96;

const INTRODUCTION: &str = "\
Lodestone's configuration is a TOML file. Every key may be left out unless it is required.
Each key: unit, default (- where there is none), what is allowed, what it means.
";

/// One key of a configuration or of a calibration file, as text.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct KeyInfo {
    /// Dotted path, such as `camera.synthetic.rest_s`.
    pub key: String,
    /// Unit; empty where there is none.
    pub unit: &'static str,
    /// Default as it would be written in the file; `None` where there is none.
    pub default: Option<String>,
    /// Whether a table without it is refused.
    pub required: bool,
    /// What is allowed, with the unit.
    pub allowed: String,
    /// What it means, and what small and large values do.
    pub meaning: &'static str,
}

/// Every key of a configuration, for programs; [`explain`] is for people.
pub fn keys() -> Vec<KeyInfo> {
    infos(&CONFIG, &config_defaults())
}

/// Every key of a calibration file.
pub fn calibration_keys() -> Vec<KeyInfo> {
    infos(&CALIBRATION, &defaults_of::<Calibration>(&CALIBRATION))
}

/// Every key of a configuration with unit, default, range and meaning, as text of 96 columns.
pub fn explain() -> String {
    format!("{INTRODUCTION}{}", sections(&CONFIG, &config_defaults()))
}

/// Every key of a calibration file with unit, default, range and meaning, as text of 96 columns.
pub fn explain_calibration() -> String {
    sections(&CALIBRATION, &defaults_of::<Calibration>(&CALIBRATION))
}

fn infos(schema: &Schema, defaults: &BTreeMap<String, Value>) -> Vec<KeyInfo> {
    let sections = schema.sections.iter();
    sections
        .flat_map(|section| section.keys.iter().map(|key| info(section, key, defaults)))
        .collect()
}

fn info(section: &Section, key: &Key, defaults: &BTreeMap<String, Value>) -> KeyInfo {
    let path = join(section.path, key.name);
    KeyInfo {
        default: defaults.get(&path).map(ToString::to_string),
        key: path,
        unit: key.unit,
        required: key.required,
        allowed: key.allowed(),
        meaning: key.meaning,
    }
}

/// The defaults of all keys of a configuration; those of `camera.noise` are the model's figures,
/// that of `camera.axis_map` is the default driver's.
fn config_defaults() -> BTreeMap<String, Value> {
    let mut defaults = defaults_of::<Config>(&CONFIG);
    if let Ok(noise) = Value::try_from(CameraModel::default().noise()) {
        flatten(&CONFIG, "camera.noise", noise, &mut defaults);
    }
    if let Ok(axes) = Value::try_from(Camera::default().axes()) {
        defaults.insert("camera.axis_map".into(), axes);
    }
    defaults
}

/// The defaults of all keys that are not required, read off the types: what a file that says only
/// what it must is understood to say.
fn defaults_of<T: Serialize + DeserializeOwned>(schema: &Schema) -> BTreeMap<String, Value> {
    let mut defaults = BTreeMap::new();
    let least = schema.section("").map(|root| least(schema, root)).unwrap_or_default();
    if let Some(value) = least.try_into::<T>().ok().and_then(|typed| Value::try_from(typed).ok()) {
        flatten(schema, "", value, &mut defaults);
    }
    for section in schema.sections {
        for key in section.keys.iter().filter(|key| key.required) {
            defaults.remove(&join(section.path, key.name));
        }
    }
    defaults
}

/// A table with every table in it once, but only the required keys.
fn least(schema: &Schema, section: &Section) -> Table {
    let mut table = section.required_stand_ins();
    for child in schema.children(section.path) {
        let inner = Value::Table(least(schema, child));
        let value = if child.shape == Shape::List { Value::Array(vec![inner]) } else { inner };
        table.insert(split(child.path).1.into(), value);
    }
    table
}

/// Puts every value that is not a table of keys under its dotted path.
fn flatten(schema: &Schema, path: &str, value: Value, into: &mut BTreeMap<String, Value>) {
    let is_section = schema.section(path).is_some();
    match value {
        Value::Table(table) => {
            for (name, value) in table {
                flatten(schema, &join(path, &name), value, into);
            }
        }
        Value::Array(elements) if is_section => {
            for element in elements {
                flatten(schema, path, element, into);
            }
        }
        value => {
            into.insert(path.into(), value);
        }
    }
}

fn sections(schema: &Schema, defaults: &BTreeMap<String, Value>) -> String {
    let mut out = String::new();
    for section in schema.sections.iter().filter(|section| !section.keys.is_empty()) {
        out.push('\n');
        out.push_str(&title(section));
        out.push('\n');
        wrap(&mut out, section.meaning, 2);
        let infos: Vec<KeyInfo> =
            section.keys.iter().map(|key| info(section, key, defaults)).collect();
        describe_keys(&mut out, section, &infos);
    }
    out
}

fn title(section: &Section) -> String {
    let note = match section.shape {
        Shape::Root | Shape::Table => "",
        Shape::Optional => "  (may be left out)",
        Shape::List => "  (any number)",
    };
    format!("{}{note}", section.header())
}

fn describe_keys(out: &mut String, section: &Section, infos: &[KeyInfo]) {
    let names = section.keys.iter().map(|key| key.name.len());
    let name_width = names.max().unwrap_or(0);
    let unit_width = infos.iter().map(|info| columns(info.unit)).max().unwrap_or(0);
    let default_width = infos.iter().map(|info| columns(default_word(info))).max().unwrap_or(0);
    for (key, info) in section.keys.iter().zip(infos) {
        let head = format!(
            "  {:name_width$}  {:unit_width$}  {:default_width$}  ",
            key.name,
            info.unit,
            default_word(info)
        );
        head_and_allowed(out, &head, &key.kind.allowed(""));
        wrap(out, info.meaning, 6);
    }
}

fn default_word(info: &KeyInfo) -> &str {
    match &info.default {
        Some(default) => default,
        None if info.required => "required",
        None => "-",
    }
}

/// Writes a key's line; what is allowed goes on its own lines if it does not fit.
fn head_and_allowed(out: &mut String, head: &str, allowed: &str) {
    if columns(head) + columns(allowed) <= WIDTH {
        let _ = writeln!(out, "{head}{allowed}");
    } else {
        let _ = writeln!(out, "{}", head.trim_end());
        wrap(out, allowed, 6);
    }
}

/// Writes a text in lines of at most [`WIDTH`] columns, where words permit.
fn wrap(out: &mut String, text: &str, indent: usize) {
    let mut column = 0;
    for word in text.split_whitespace() {
        if column > 0 && column + 1 + columns(word) > WIDTH {
            out.push('\n');
            column = 0;
        }
        let space = if column == 0 { indent } else { 1 };
        let _ = write!(out, "{:space$}{word}", "");
        column += space + columns(word);
    }
    if column > 0 {
        out.push('\n');
    }
}

/// Columns a text takes on a terminal; all our units and words are of single width.
fn columns(text: &str) -> usize {
    text.chars().count()
}
