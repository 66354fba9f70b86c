//! No text makes the reader panic, and what it accepts is in its ranges.

use lodestone_config::{Calibration, Config, EMBEDDED, keys};
use proptest::prelude::*;

const SHIPPED: [&str; 3] = [
    EMBEDDED,
    include_str!("../shipped/zed2-vehicle.toml"),
    include_str!("../shipped/replay.toml"),
];

/// Values of every type and many sizes, right and wrong.
const VALUES: [&str; 24] = [
    "0",
    "-1",
    "1",
    "400",
    "1e308",
    "-1e400",
    "nan",
    "-inf",
    "9223372036854775807",
    "18446744073709551616",
    "0xffff_ffff",
    "true",
    "\"\"",
    "\"walk\"",
    "\"replay\"",
    "'x'",
    "2026-05-04",
    "[]",
    "[1, 2, 3]",
    "[[1,0,0],[0,1,0],[0,0,1]]",
    "{}",
    "{ at_s = 1 }",
    "[{ kind = \"drop\", at_s = 1, duration_s = 1 }]",
    "\"\\u0000\"",
];

/// Reads a text as both kinds of file. Whatever comes of it, messages keep their form, and what is
/// accepted is accepted again after it was written.
fn survives(text: &str) {
    let _ = Calibration::from_toml("a.toml", text);
    match Config::from_toml("a.toml", text) {
        Ok(config) => {
            let written = toml::to_string(&config).expect("serialises");
            assert_eq!(Config::from_toml("b.toml", &written), Ok(config));
        }
        Err(errors) => {
            let lines = text.lines().count() + 1;
            for error in &errors {
                assert!((1..=lines).contains(&error.line), "{error}");
                assert!(!error.to_string().contains('\n'), "{error:?}");
                assert!(!error.allowed.is_empty());
            }
            assert!(errors.to_string().lines().count() >= 1);
        }
    }
}

/// A shipped file with bytes removed, doubled, or put in from another place.
fn mutated() -> impl Strategy<Value = String> {
    let edit = (any::<prop::sample::Index>(), any::<prop::sample::Index>(), 0..4_u8, 0..40_usize);
    (0..SHIPPED.len(), prop::collection::vec(edit, 1..6)).prop_map(|(file, edits)| {
        let mut text: Vec<char> = SHIPPED[file].chars().collect();
        for (at, from, what, length) in edits {
            let at = at.index(text.len() + 1);
            let piece: Vec<char> = {
                let from = from.index(text.len() + 1);
                text[from..].iter().take(length).copied().collect()
            };
            let end = (at + length).min(text.len());
            match what {
                0 => drop(text.drain(at..end)),
                1 => drop(text.splice(at..at, piece)),
                2 => drop(text.splice(at..end, piece)),
                _ => text.truncate(at),
            }
        }
        text.into_iter().collect()
    })
}

/// A line of a shipped file with another value, and lines with any key at all.
fn other_values() -> impl Strategy<Value = String> {
    let paths: Vec<String> = keys().into_iter().map(|key| key.key).collect();
    let path = prop::sample::select(paths);
    let value = prop::sample::select(VALUES.to_vec());
    prop::collection::vec((path, value), 1..8).prop_map(|pairs| {
        let (mut text, mut camera) =
            (String::new(), String::from("[[camera]]\nname = \"front\"\n"));
        for (path, value) in pairs {
            let (part, path) = match path.strip_prefix("camera.") {
                Some(inside) => (&mut camera, inside),
                None => (&mut text, path.as_str()),
            };
            part.extend([path, " = ", value, "\n"]);
        }
        text + &camera
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_text(text in "\\PC*") {
        survives(&text);
    }

    #[test]
    fn any_text_of_toml_letters(text in "[\\[\\]{}a-c_.=\"'#\n\r\t ,0-9eE+:-]{0,200}") {
        survives(&text);
    }

    #[test]
    fn any_control_character(text in prop::collection::vec(any::<char>(), 0..200)) {
        survives(&text.into_iter().collect::<String>());
    }

    #[test]
    fn any_mutation_of_a_shipped_file(text in mutated()) {
        survives(&text);
    }

    #[test]
    fn any_value_at_any_key(text in other_values()) {
        survives(&text);
    }

    #[test]
    fn any_rest_is_taken_exactly_if_it_is_in_its_range(rest_s in any::<f64>()) {
        let text = format!(
            "[[camera]]\nname = \"a\"\ndriver = \"synthetic\"\nsynthetic.rest_s = {rest_s:?}\n"
        );
        let accepted = Config::from_toml("a.toml", &text);
        prop_assert_eq!(accepted.is_ok(), (0.0..=3600.0).contains(&rest_s), "{}", text);
    }
}

#[test]
fn nesting_beyond_all_measure_is_refused() {
    survives(&format!("camera = {}", "[".repeat(100_000)));
    survives(&format!("world = {}", "{a=".repeat(100_000)));
    survives(&format!("{}a = 1", "a.".repeat(100_000)));
    survives(&format!("[{}a]\nb = 1", "a.".repeat(100_000)));
}

#[test]
fn many_errors_are_counted_and_not_all_printed() {
    let lines: Vec<String> = (0..5000).map(|index| format!("key{index} = 1")).collect();
    let errors = Config::from_toml("a.toml", &lines.join("\n")).expect_err("unknown keys");
    assert_eq!(errors.len(), 5001, "every key, and no camera");
    assert!(errors.to_string().ends_with("and 4901 more errors"));
    assert_eq!(errors.to_string().lines().count(), 101);
}

#[test]
fn long_nonsense_is_refused() {
    for line in ["=\n", "a\n", "[[camera]]\n", "[[\n", "\"\n", "camera.x.y = 1\n"] {
        survives(&line.repeat((1 << 15) / line.len()));
    }
}
