//! Checks of numbers and of lists of three.

use toml::Value;
use toml::de::{DeInteger, DeValue};

use super::kind::mismatch;
use super::range::Range;

/// Takes a number, written as one or as a whole number.
pub(super) fn check(value: &DeValue<'_>, range: Range) -> Result<f64, String> {
    let number = match value {
        DeValue::Float(float) => float.as_str().parse::<f64>().map_err(|_| mismatch(value))?,
        DeValue::Integer(integer) => whole(integer)? as f64,
        _ => return Err(mismatch(value)),
    };
    if !number.is_finite() {
        return Err("is not a finite number".into());
    }
    if range.holds(number) { Ok(number) } else { Err(format!("{number} is out of range")) }
}

/// Takes a whole number from `min` to `max`.
pub(super) fn check_whole(value: &DeValue<'_>, min: i64, max: i64) -> Result<i64, String> {
    let number = match value {
        DeValue::Integer(integer) => whole(integer)?,
        DeValue::Float(float) => return Err(format!("{} is not a whole number", float.as_str())),
        _ => return Err(mismatch(value)),
    };
    if (min..=max).contains(&number) {
        Ok(number)
    } else {
        Err(format!("{number} is out of range"))
    }
}

/// Takes a list of three numbers.
pub(super) fn check_vector(value: &DeValue<'_>, range: Range) -> Result<[f64; 3], String> {
    let mut vector = [0.0; 3];
    for (slot, element) in vector.iter_mut().zip(check_three(value)?) {
        *slot = check(element, range)?;
    }
    Ok(vector)
}

/// Takes a list of three values.
pub(super) fn check_three<'v, 'i>(
    value: &'v DeValue<'i>,
) -> Result<impl Iterator<Item = &'v DeValue<'i>>, String> {
    let list = value.as_array().ok_or_else(|| mismatch(value))?;
    match list.len() {
        3 => Ok(list.iter().map(toml::Spanned::get_ref)),
        1 => Err("has 1 element, not 3".into()),
        count => Err(format!("has {count} elements, not 3")),
    }
}

/// Three numbers as a TOML value.
pub(super) fn to_value(vector: [f64; 3]) -> Value {
    Value::Array(vector.into_iter().map(Value::Float).collect())
}

fn whole(integer: &DeInteger<'_>) -> Result<i64, String> {
    i64::from_str_radix(integer.as_str(), integer.radix())
        .map_err(|_| format!("{} is out of range", super::kind::quote(integer.as_str())))
}
