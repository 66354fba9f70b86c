//! Broken configurations, made by hand: every message names line, key and what is allowed, and
//! nothing else is reported.
//!
//! The first lines of each file say what is expected, as `# expect: LINE: WHAT`.

use std::fs;
use std::path::{Path, PathBuf};

use lodestone_config::{Config, ConfigErrors, LoadError};

fn broken_files() -> Vec<PathBuf> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/broken");
    let entries = fs::read_dir(directory).expect("the directory is in the repository");
    let mut files: Vec<_> = entries.map(|entry| entry.expect("readable").path()).collect();
    files.sort();
    files
}

/// What the comments of a file ask for: `:LINE: WHAT`.
fn expectations(text: &str) -> Vec<String> {
    let comments = text.lines().filter_map(|line| line.strip_prefix("# expect: "));
    comments.map(|expected| format!(":{expected}")).collect()
}

fn errors_of(path: &Path) -> ConfigErrors {
    match Config::load(path) {
        Err(LoadError::Invalid(errors)) => errors,
        other => panic!("{}: {other:?}", path.display()),
    }
}

#[test]
fn each_broken_file_is_refused_for_its_reasons_and_no_others() {
    let files = broken_files();
    assert!(files.len() >= 20, "only {} broken files were found", files.len());
    for path in files {
        let expected = expectations(&fs::read_to_string(&path).expect("readable"));
        let errors = errors_of(&path);
        let messages: Vec<String> = errors.iter().map(ToString::to_string).collect();
        assert!(!expected.is_empty(), "{} expects nothing", path.display());
        assert_eq!(messages.len(), expected.len(), "{errors}");
        for expected in expected {
            let start = format!("{}{expected}", path.display());
            let found = messages.iter().any(|message| message.starts_with(&start));
            assert!(found, "expected {start}\ngot {errors}");
        }
    }
}

#[test]
fn each_message_is_one_line_that_ends_with_what_is_allowed() {
    for path in broken_files() {
        for error in &errors_of(&path) {
            let message = error.to_string();
            let (_, allowed) = message.split_once("; allowed: ").expect("says what is allowed");
            assert!(!allowed.trim().is_empty(), "{message}");
            assert!(!message.contains('\n'), "{message}");
            assert_eq!(error.key.is_none(), error.problem.starts_with("not TOML"), "{message}");
        }
    }
}

#[test]
fn errors_come_in_the_order_of_lines() {
    for path in broken_files() {
        let errors = errors_of(&path);
        assert!(errors.iter().is_sorted_by_key(|error| error.line), "{errors}");
    }
}
