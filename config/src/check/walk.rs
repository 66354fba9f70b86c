//! Compares a parsed file with the key table: names, types, ranges.

use toml::de::{DeTable, DeValue};
use toml::{Spanned, Table, Value};

use super::report::Report;
use crate::keys::{Key, Schema, Section, Shape, join, nearest, quote, split, type_name};

/// Most lists that are taken of one kind (cameras, faults, disturbances).
const MAX_LIST_LEN: usize = 64;

/// Checks every key of a file. Gives the file without spans, with stand-ins for wrong values, so
/// that the rules between keys can be checked all the same.
pub(crate) fn walk(schema: &Schema, report: &mut Report, root: &DeTable<'_>) -> Table {
    let mut walk = Walk { schema, report };
    schema.section("").map_or_else(Table::new, |section| walk.table(section, "", root))
}

struct Walk<'a> {
    schema: &'a Schema,
    report: &'a mut Report,
}

impl Walk<'_> {
    /// Checks a table that stands at `place`.
    fn table(&mut self, section: &Section, place: &str, table: &DeTable<'_>) -> Table {
        let mut clean = Table::new();
        for (name, value) in table {
            let here = join(place, name.get_ref());
            self.report.locate(&here, name.span().start);
            if let Some(checked) = self.entry(section, name.get_ref(), &here, value) {
                clean.insert(name.get_ref().to_string(), checked);
            }
        }
        self.add_missing(section, place, &mut clean);
        clean
    }

    /// Checks a key or a table in a table; `None` if it is unknown.
    fn entry(
        &mut self,
        section: &Section,
        name: &str,
        place: &str,
        value: &Spanned<DeValue<'_>>,
    ) -> Option<Value> {
        if let Some(key) = section.key(name) {
            return Some(self.value(key, place, value.get_ref()));
        }
        match self.schema.section(&join(section.path, name)) {
            Some(child) if child.shape == Shape::List => Some(self.list(child, place, value)),
            Some(child) => Some(self.child(child, place, value.get_ref())),
            None => {
                self.unknown(section, name, place);
                None
            }
        }
    }

    fn value(&mut self, key: &Key, place: &str, value: &DeValue<'_>) -> Value {
        key.kind.check(value).unwrap_or_else(|problem| {
            self.report.faulty(place, problem, key.allowed());
            key.kind.stand_in()
        })
    }

    fn child(&mut self, section: &Section, place: &str, value: &DeValue<'_>) -> Value {
        if let Some(table) = value.as_table() {
            return Value::Table(self.table(section, place, table));
        }
        let problem = format!("is {}", type_name(value));
        let allowed = format!("a table, written {}", section.header());
        self.report.faulty(place, problem, allowed);
        Value::Table(section.required_stand_ins())
    }

    fn list(&mut self, section: &Section, place: &str, value: &Spanned<DeValue<'_>>) -> Value {
        let allowed = || format!("a list of tables, each headed {}", section.header());
        let Some(elements) = value.get_ref().as_array() else {
            let problem = format!("is {}", type_name(value.get_ref()));
            self.report.faulty(place, problem, allowed());
            return Value::Array(Vec::new());
        };
        if elements.len() > MAX_LIST_LEN {
            let problem = format!("has {} elements", elements.len());
            self.report.faulty(place, problem, format!("at most {MAX_LIST_LEN}"));
        }
        let mut clean = Vec::new();
        for (index, element) in elements.iter().enumerate() {
            let here = format!("{place}[{index}]");
            self.report.locate(&here, element.span().start);
            clean.push(self.child(section, &here, element.get_ref()));
        }
        Value::Array(clean)
    }

    /// Reports required keys that are not there, and puts stand-ins in their place.
    fn add_missing(&mut self, section: &Section, place: &str, clean: &mut Table) {
        for key in section.keys {
            if key.required && !clean.contains_key(key.name) {
                self.report.faulty(&join(place, key.name), "is missing".into(), key.allowed());
                clean.insert(key.name.into(), key.kind.stand_in());
            }
        }
    }

    fn unknown(&mut self, section: &Section, name: &str, place: &str) {
        let known = self.schema.names_in(section);
        let problem = match self.proposal(section, &known, name) {
            Some(proposal) => format!("unknown key; did you mean {proposal}?"),
            None => "unknown key".into(),
        };
        self.report.faulty(&printable(place), problem, known.join(", "));
    }

    /// What a mistyped or misplaced name may have meant.
    fn proposal(&self, section: &Section, known: &[&'static str], name: &str) -> Option<String> {
        if let Some(near) = nearest(name, known.iter().copied()) {
            return Some(join(section.path, near));
        }
        let elsewhere = self.schema.paths().find(|path| split(path).1 == name);
        elsewhere.or_else(|| {
            let sections = self.schema.sections.iter().map(|section| section.path);
            sections.filter(|path| split(path).1 == name).map(String::from).next()
        })
    }
}

/// A place whose last name may hold anything, fit for one line of a message.
fn printable(place: &str) -> String {
    let plain = place.len() <= 100 && !place.chars().any(|c| c.is_control() || c.is_whitespace());
    if plain { place.into() } else { quote(place) }
}
