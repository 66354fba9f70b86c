//! The key table: what every key means and may be. It drives validation and [`crate::explain`].

mod axes;
mod body;
mod calibration;
mod camera;
mod config;
mod covariance;
mod depth;
mod kept_world;
mod kind;
mod matrix;
mod number;
mod range;
mod realtime;
mod scene;
mod text;

pub(crate) use calibration::CALIBRATION;
pub(crate) use config::CONFIG;
pub(crate) use kept_world::KEPT_WORLD;
pub(crate) use kind::{Kind, quote, type_name};

/// One key of a table.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Key {
    /// Name inside its table.
    pub(crate) name: &'static str,
    /// What its value may be.
    pub(crate) kind: Kind,
    /// Unit, empty where there is none.
    pub(crate) unit: &'static str,
    /// One sentence or two: what it means, and what small and large values do.
    pub(crate) meaning: &'static str,
    /// Whether a table without it is refused.
    pub(crate) required: bool,
}

impl Key {
    /// The same key, which must not be left out.
    const fn required(mut self) -> Self {
        self.required = true;
        self
    }

    /// What is allowed, in words.
    pub(crate) fn allowed(&self) -> String {
        self.kind.allowed(self.unit)
    }
}

/// A key that may be left out.
const fn key(name: &'static str, kind: Kind, unit: &'static str, meaning: &'static str) -> Key {
    Key { name, kind, unit, meaning, required: false }
}

/// How often a table stands in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shape {
    /// The file itself.
    Root,
    /// Once; left out, its keys have their defaults.
    Table,
    /// Once; left out, there is none of it.
    Optional,
    /// Any number of times.
    List,
}

/// A table of keys.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Section {
    /// Dotted path from the root; empty for the root.
    pub(crate) path: &'static str,
    /// How often it stands in the file.
    pub(crate) shape: Shape,
    /// What it is.
    pub(crate) meaning: &'static str,
    /// Its keys, without the tables in it.
    pub(crate) keys: &'static [Key],
}

impl Section {
    /// The header that begins it in a file.
    pub(crate) fn header(&self) -> String {
        match self.shape {
            Shape::Root => "at the top of the file".into(),
            Shape::Table | Shape::Optional => format!("[{}]", self.path),
            Shape::List => format!("[[{}]]", self.path),
        }
    }

    /// The key of that name.
    pub(crate) fn key(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|key| key.name == name)
    }

    /// The table with nothing but its required keys, each with a value that is allowed.
    pub(crate) fn required_stand_ins(&self) -> toml::Table {
        let required = self.keys.iter().filter(|key| key.required);
        required.map(|key| (key.name.into(), key.kind.stand_in())).collect()
    }
}

/// All tables of one kind of file, the root first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Schema {
    /// The tables, each after the one it is in.
    pub(crate) sections: &'static [Section],
}

impl Schema {
    /// The table at a dotted path.
    pub(crate) fn section(&self, path: &str) -> Option<&'static Section> {
        self.sections.iter().find(|section| section.path == path)
    }

    /// The tables that stand directly in another one.
    pub(crate) fn children(&self, parent: &str) -> impl Iterator<Item = &'static Section> {
        self.sections
            .iter()
            .filter(move |child| split(child.path).0 == parent && !child.path.is_empty())
    }

    /// Names of the keys and tables that may stand in a table.
    pub(crate) fn names_in(&self, section: &Section) -> Vec<&'static str> {
        let keys = section.keys.iter().map(|key| key.name);
        keys.chain(self.children(section.path).map(|child| split(child.path).1)).collect()
    }

    /// Dotted paths of all keys.
    pub(crate) fn paths(&self) -> impl Iterator<Item = String> {
        let sections = self.sections.iter();
        sections.flat_map(|section| section.keys.iter().map(|key| join(section.path, key.name)))
    }
}

/// Joins a table's path and a name in it.
pub(crate) fn join(path: &str, name: &str) -> String {
    if path.is_empty() { name.into() } else { format!("{path}.{name}") }
}

/// Splits a path into the table's path and the name in it.
pub(crate) fn split(path: &str) -> (&str, &str) {
    path.rsplit_once('.').unwrap_or(("", path))
}

/// The known name that a mistyped one comes nearest to, if any is near.
pub(crate) fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Where clap draws the line too: below it, proposals are more puzzling than helpful.
    const NEAR: f64 = 0.8;
    known
        .into_iter()
        .map(|candidate| (strsim::jaro_winkler(name, candidate), candidate))
        .filter(|(nearness, _)| *nearness > NEAR)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}
