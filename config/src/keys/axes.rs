//! Axis maps.

use toml::Value;
use toml::de::DeValue;

use super::kind::{mismatch, quote};
use super::number;

pub(super) const ALLOWED: &str = "3 of \"x\", \"-x\", \"y\", \"-y\", \"z\", \"-z\", each axis \
                                  once and right-handed ([\"z\", \"y\", \"-x\"] for a ZED 2)";

/// Takes an axis map: the sensor axis that is forward, left and up.
pub(super) fn check(value: &DeValue<'_>) -> Result<Value, String> {
    let mut axes = Vec::with_capacity(3);
    for element in number::check_three(value)? {
        axes.push(element.as_str().ok_or_else(|| mismatch(element))?);
    }
    let mut map = [(0, false); 3];
    for (slot, axis) in map.iter_mut().zip(&axes) {
        *slot = parse(axis).ok_or_else(|| format!("{} is no axis", quote(axis)))?;
    }
    check_handedness(map)?;
    Ok(to_value(&axes))
}

pub(super) fn stand_in() -> Value {
    to_value(&["z", "y", "-x"])
}

fn to_value(axes: &[&str]) -> Value {
    Value::Array(axes.iter().map(|&axis| Value::String(axis.into())).collect())
}

/// Index of the axis and whether its sign is turned.
fn parse(axis: &str) -> Option<(usize, bool)> {
    let name = axis.strip_prefix('-').unwrap_or(axis);
    let index = ["x", "y", "z"].iter().position(|&known| known == name)?;
    Some((index, name.len() < axis.len()))
}

fn check_handedness(map: [(usize, bool); 3]) -> Result<(), String> {
    let [a, b, c] = map.map(|(index, _)| index);
    if a == b || b == c || a == c {
        return Err("names one axis twice".into());
    }
    // An even permutation (x y z, y z x, z x y) is right-handed; each turned sign mirrors it.
    let even = (a + 1) % 3 == b;
    let turned = map.iter().filter(|(_, turned)| *turned).count();
    if even == turned.is_multiple_of(2) { Ok(()) } else { Err("is left-handed".into()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(axes: [&str; 3]) -> Result<(), String> {
        check_handedness(axes.map(|axis| parse(axis).expect("an axis")))
    }

    /// The sign of the determinant, worked out without permutations.
    fn determinant(axes: [&str; 3]) -> f64 {
        let row = |axis: &str| {
            let (index, turned) = parse(axis).expect("an axis");
            let mut row = [0.0; 3];
            row[index] = if turned { -1.0 } else { 1.0 };
            row
        };
        let [a, b, c] = axes.map(row);
        let cross =
            [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        a.iter().zip(cross).map(|(a, x)| a * x).sum()
    }

    #[test]
    fn of_all_maps_exactly_those_with_determinant_one_pass() {
        const AXES: [&str; 6] = ["x", "-x", "y", "-y", "z", "-z"];
        let mut good = 0;
        for (a, b, c) in
            AXES.iter().flat_map(|a| AXES.iter().flat_map(move |b| AXES.map(|c| (*a, *b, c))))
        {
            let passes = verdict([a, b, c]).is_ok();
            assert_eq!(passes, determinant([a, b, c]) > 0.5, "{a} {b} {c}");
            good += usize::from(passes);
        }
        assert_eq!(good, 24, "as many as a cube has rotations");
    }

    #[test]
    fn what_is_no_axis_is_none() {
        for text in ["", "-", "w", "--x", "X", "x "] {
            assert_eq!(parse(text), None, "{text:?}");
        }
    }
}
