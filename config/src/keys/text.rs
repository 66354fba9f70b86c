//! Rules for keys whose value is text.

use std::path::Path;

/// What a text means, which says what it may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Text {
    /// The name of a camera or of a body.
    CameraName,
    /// First part of file names in shared memory.
    Prefix,
    /// An absolute directory.
    Directory,
    /// A recording's path.
    Recording,
    /// A calibration file's path.
    CalibrationFile,
    /// The path of the file that keeps the world.
    WorldFile,
    /// Words for people.
    Description,
}

/// Longest path, bytes: iceoryx2 refuses paths above 255 and appends names of its own.
const MAX_DIRECTORY_LEN: usize = 128;
const MAX_PREFIX_LEN: usize = 32;
const MAX_PATH_LEN: usize = 4096;
const MAX_DESCRIPTION_LEN: usize = 500;

impl Text {
    /// Whether the text follows the rule.
    pub(crate) fn accepts(self, text: &str) -> bool {
        match self {
            Self::CameraName => lodestone_schema::is_camera_name(text),
            Self::Prefix => is_prefix(text),
            Self::Directory => is_directory(text),
            Self::Recording => is_path(text) && has_ending(text, &[".csv", ".csv.zst"]),
            Self::CalibrationFile | Self::WorldFile => {
                is_path(text) && has_ending(text, &[".toml"])
            }
            Self::Description => is_description(text),
        }
    }

    /// The rule in words.
    pub(crate) fn allowed(self) -> String {
        match self {
            Self::CameraName => format!(
                "1 to {} of a-z 0-9 _ -, a letter or digit first",
                lodestone_schema::MAX_CAMERA_NAME_LEN
            ),
            Self::Prefix => format!("1 to {MAX_PREFIX_LEN} of a-z A-Z 0-9 _ -"),
            Self::Directory => format!(
                "an absolute path without `..`, of a-z A-Z 0-9 . _ - /, at most {MAX_DIRECTORY_LEN} bytes"
            ),
            Self::Recording => "a path that ends in .csv or .csv.zst".into(),
            Self::CalibrationFile | Self::WorldFile => "a path that ends in .toml".into(),
            Self::Description => format!("1 to {MAX_DESCRIPTION_LEN} characters"),
        }
    }
}

fn is_prefix(text: &str) -> bool {
    let allowed = |b: u8| b.is_ascii_alphanumeric() || b == b'_' || b == b'-';
    (1..=MAX_PREFIX_LEN).contains(&text.len()) && text.bytes().all(allowed)
}

fn is_directory(text: &str) -> bool {
    let allowed = |b: u8| b.is_ascii_alphanumeric() || b"._-/".contains(&b);
    text.starts_with('/')
        && text.len() <= MAX_DIRECTORY_LEN
        && text.bytes().all(allowed)
        && text.split('/').any(|part| !part.is_empty())
        && text.split('/').all(|part| part != "..")
}

fn is_path(text: &str) -> bool {
    let named = Path::new(text).file_stem().is_some_and(|stem| !stem.is_empty());
    named && text.len() <= MAX_PATH_LEN && !text.contains('\0')
}

fn has_ending(text: &str, endings: &[&str]) -> bool {
    endings.iter().any(|ending| text.len() > ending.len() && text.ends_with(ending))
}

fn is_description(text: &str) -> bool {
    !text.trim().is_empty() && text.chars().count() <= MAX_DESCRIPTION_LEN
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directories_are_absolute_and_stay_where_they_say() {
        assert!(Text::Directory.accepts("/dev/shm/lodestone/"));
        for text in ["", "/", "//", "lodestone", "/dev/../etc", "/dev/shm/a b", "/dev/\0"] {
            assert!(!Text::Directory.accepts(text), "{text:?}");
        }
    }

    #[test]
    fn files_need_their_ending_and_a_name() {
        assert!(Text::Recording.accepts("walks/a.csv.zst"));
        assert!(Text::Recording.accepts("/data/a.csv"));
        for text in ["", ".csv", "a.bag", "a.csv/", "a\0.csv"] {
            assert!(!Text::Recording.accepts(text), "{text:?}");
        }
    }

    #[test]
    fn prefixes_are_short_and_plain() {
        assert!(Text::Prefix.accepts("lodestone_"));
        for text in ["", "a/b", "ä", &"x".repeat(33)] {
            assert!(!Text::Prefix.accepts(text), "{text:?}");
        }
    }
}
