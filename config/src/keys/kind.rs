//! What a key's value may be.

use toml::Value;
use toml::de::DeValue;

use super::axes;
use super::covariance;
use super::matrix;
use super::number;
use super::range::Range;
use super::text::Text;

/// What a key's value may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    /// A finite number.
    Number(Range),
    /// A whole number from the first to the second.
    Whole(i64, i64),
    /// `true` or `false`.
    Switch,
    /// One of a few words.
    Choice(&'static [&'static str]),
    /// Three finite numbers.
    Vector(Range),
    /// Three rows of three finite numbers that make a usable soft-iron matrix.
    SoftIron(Range),
    /// The covariance of a magnetometer's calibration.
    Covariance,
    /// Three signed axes, right-handed.
    Axes,
    /// Text with a meaning.
    Text(Text),
    /// A day.
    Date,
}

impl Kind {
    /// Checks a value. Gives it without spans, or says what is wrong with it.
    pub(crate) fn check(self, value: &DeValue<'_>) -> Result<Value, String> {
        match self {
            Self::Number(range) => number::check(value, range).map(Value::Float),
            Self::Whole(min, max) => number::check_whole(value, min, max).map(Value::Integer),
            Self::Switch => value.as_bool().map(Value::Boolean).ok_or_else(|| mismatch(value)),
            Self::Choice(words) => check_choice(value, words),
            Self::Vector(range) => number::check_vector(value, range).map(number::to_value),
            Self::SoftIron(range) => matrix::check(value, range),
            Self::Covariance => covariance::check(value),
            Self::Axes => axes::check(value),
            Self::Text(text) => check_text(value, text),
            Self::Date => check_date(value),
        }
    }

    /// What is allowed, in words, with the unit.
    pub(crate) fn allowed(self, unit: &str) -> String {
        let with_unit =
            |text: String| if unit.is_empty() { text } else { format!("{text} {unit}") };
        match self {
            Self::Number(range) => with_unit(format!("a number {range}")),
            Self::Whole(min, max) if max == i64::MAX => {
                with_unit(format!("a whole number from {min}"))
            }
            Self::Whole(min, max) => with_unit(format!("a whole number from {min} to {max}")),
            Self::Switch => "true or false".into(),
            Self::Choice(words) => list_words(words),
            Self::Vector(range) => with_unit(format!("3 numbers, each {range}")),
            Self::SoftIron(range) => matrix::allowed(range),
            Self::Covariance => covariance::ALLOWED.into(),
            Self::Axes => axes::ALLOWED.into(),
            Self::Text(text) => text.allowed(),
            Self::Date => "a day, written 2026-05-31".into(),
        }
    }

    /// Any value that is allowed, to stand in for a wrong one while the rest is checked.
    pub(crate) fn stand_in(self) -> Value {
        match self {
            Self::Number(range) => Value::Float(range.any()),
            Self::Whole(min, _) => Value::Integer(min),
            Self::Switch => Value::Boolean(false),
            Self::Choice(words) => Value::String(words.first().copied().unwrap_or("").into()),
            Self::Vector(range) => number::to_value([range.any(); 3]),
            Self::SoftIron(_) => matrix::identity(),
            Self::Covariance => covariance::stand_in(),
            Self::Axes => axes::stand_in(),
            Self::Text(_) => Value::String(String::new()),
            Self::Date => {
                Value::Datetime(toml::value::Date { year: 2000, month: 1, day: 1 }.into())
            }
        }
    }
}

fn check_choice(value: &DeValue<'_>, words: &[&str]) -> Result<Value, String> {
    let text = value.as_str().ok_or_else(|| mismatch(value))?;
    if words.contains(&text) {
        return Ok(Value::String(text.into()));
    }
    Err(match super::nearest(text, words.iter().copied()) {
        Some(word) => format!("{} is unknown; did you mean \"{word}\"?", quote(text)),
        None => format!("{} is unknown", quote(text)),
    })
}

fn check_text(value: &DeValue<'_>, rule: Text) -> Result<Value, String> {
    let text = value.as_str().ok_or_else(|| mismatch(value))?;
    if rule.accepts(text) {
        Ok(Value::String(text.into()))
    } else {
        Err(format!("{} cannot be used", quote(text)))
    }
}

/// Takes a local date; the parser has seen to it that the day exists.
fn check_date(value: &DeValue<'_>) -> Result<Value, String> {
    let date = value.as_datetime().ok_or_else(|| mismatch(value))?;
    match (date.date, date.time) {
        (Some(_), None) => Ok(Value::Datetime(*date)),
        _ => Err(format!("{date} is not a day")),
    }
}

/// Says that a value is of the wrong type.
pub(super) fn mismatch(value: &DeValue<'_>) -> String {
    format!("is {}", type_name(value))
}

/// A value's type in plain words.
pub(crate) fn type_name(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "text",
        DeValue::Integer(_) => "a whole number",
        DeValue::Float(_) => "a number",
        DeValue::Boolean(true) => "true",
        DeValue::Boolean(false) => "false",
        DeValue::Datetime(_) => "a date or time",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    }
}

/// A text as it may be shown in a message: quoted, one line, not long.
pub(crate) fn quote(text: &str) -> String {
    const SHOWN: usize = 60;
    let shown: String = text.chars().take(SHOWN).collect();
    let more = if shown.len() < text.len() { "…" } else { "" };
    format!("\"{}{more}\"", shown.escape_debug())
}

/// `"a", "b" or "c"`.
fn list_words(words: &[&str]) -> String {
    let quoted: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
    match quoted.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => quoted.join(""),
    }
}
