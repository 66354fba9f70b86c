//! Collects what is wrong, with the line it stands in.

use std::collections::{BTreeMap, BTreeSet};

use crate::error::{ConfigError, ConfigErrors};

/// Errors of one file and the lines of everything in it.
///
/// A *place* is a path with list indices, such as `camera[1].fault[0].at_s`.
#[derive(Debug)]
pub(crate) struct Report {
    file: String,
    /// Offset of each line's first byte.
    line_starts: Vec<usize>,
    /// Offset of each place that the file names.
    offsets: BTreeMap<String, usize>,
    /// Places whose value is missing or wrong.
    faulty: BTreeSet<String>,
    errors: Vec<ConfigError>,
}

impl Report {
    pub(crate) fn new(file: &str, text: &str) -> Self {
        let after_breaks =
            text.bytes().zip(1..).filter_map(|(b, next)| (b == b'\n').then_some(next));
        Self {
            file: file.into(),
            line_starts: std::iter::once(0).chain(after_breaks).collect(),
            offsets: BTreeMap::new(),
            faulty: BTreeSet::new(),
            errors: Vec::new(),
        }
    }

    /// Remembers where a place is.
    pub(crate) fn locate(&mut self, place: &str, offset: usize) {
        self.offsets.insert(place.into(), offset);
    }

    /// The line of a place, or of the innermost table around it that the file names.
    pub(crate) fn line(&self, place: &str) -> usize {
        let mut place = place;
        loop {
            if let Some(&offset) = self.offsets.get(place) {
                return self.line_at(offset);
            }
            match place.rfind(['.', '[']) {
                Some(end) => place = &place[..end],
                None => return 1,
            }
        }
    }

    /// A syntax error; of errors in one line that follow each other only the first counts.
    pub(crate) fn syntax(&mut self, offset: usize, problem: String, allowed: &str) {
        let line = self.line_at(offset);
        if self.errors.last().is_none_or(|last| last.line != line) {
            self.push(line, None, problem, allowed.into());
        }
    }

    /// A value that is missing or wrong by itself.
    pub(crate) fn faulty(&mut self, place: &str, problem: String, allowed: String) {
        self.faulty.insert(place.into());
        self.push(self.line(place), Some(place), problem, allowed);
    }

    /// Values that are each right, but not together. Says nothing if one of the values, or a table
    /// around it, was already found faulty.
    pub(crate) fn conflict(
        &mut self,
        place: &str,
        others: &[&str],
        problem: String,
        allowed: &str,
    ) {
        let known = std::iter::once(&place).chain(others).any(|place| self.is_faulty(place));
        if !known {
            self.push(self.line(place), Some(place), problem, allowed.into());
        }
    }

    /// The value if nothing is wrong, and everything that is wrong otherwise.
    pub(crate) fn finish<T>(self, value: T) -> Result<T, ConfigErrors> {
        if self.errors.is_empty() { Ok(value) } else { Err(self.into_errors()) }
    }

    /// What is wrong, for a caller that has reported something.
    pub(crate) fn into_errors(self) -> ConfigErrors {
        ConfigErrors::new(self.errors)
    }

    fn is_faulty(&self, place: &str) -> bool {
        let ends = place.match_indices(['.', '[']).map(|(end, _)| end);
        ends.chain([place.len()]).any(|end| self.faulty.contains(&place[..end]))
    }

    fn line_at(&self, offset: usize) -> usize {
        self.line_starts.partition_point(|&start| start <= offset)
    }

    fn push(&mut self, line: usize, place: Option<&str>, problem: String, allowed: String) {
        let key = place.map(without_indices);
        self.errors.push(ConfigError { file: self.file.clone(), line, key, problem, allowed });
    }
}

/// `camera[1].fault[0].at_s` as it stands in the key table: `camera.fault.at_s`.
fn without_indices(place: &str) -> String {
    let mut inside = false;
    place
        .chars()
        .filter(|&c| {
            inside |= c == '[';
            let kept = !inside;
            inside &= c != ']';
            kept
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_counted_from_one_and_end_with_their_break() {
        let report = Report::new("x.toml", "a\nbc\n\nd");
        let lines: Vec<usize> = (0..7).map(|offset| report.line_at(offset)).collect();
        assert_eq!(lines, [1, 1, 2, 2, 2, 3, 4]);
    }

    #[test]
    fn a_place_the_file_does_not_name_is_where_its_table_is() {
        let mut report = Report::new("x.toml", "\n[[camera]]\n\n");
        report.locate("camera[0]", 1);
        assert_eq!(report.line("camera[0].replay.file"), 2);
        assert_eq!(report.line("lane.threads"), 1);
    }

    #[test]
    fn a_conflict_with_a_faulty_value_is_not_reported_twice() {
        let mut report = Report::new("x.toml", "");
        report.faulty("camera[0].fault[1]", "is text".into(), "a table".into());
        report.conflict("camera[0].fault[1].at_s", &[], "late".into(), "early");
        report.conflict("camera[0].serial", &["camera[0].fault[1].kind"], "odd".into(), "even");
        report.conflict("camera[0].serial", &["camera[1].serial"], "twice".into(), "once");
        let errors = report.finish(()).expect_err("two errors");
        let keys: Vec<_> = errors.iter().filter_map(|error| error.key.as_deref()).collect();
        assert_eq!(keys, ["camera.fault", "camera.serial"]);
    }
}
