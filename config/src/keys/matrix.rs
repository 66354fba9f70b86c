//! Soft-iron matrices.

use toml::Value;
use toml::de::DeValue;

use super::number;
use super::range::Range;

type Matrix = [[f64; 3]; 3];

const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Least determinant of a matrix, against that of a multiple of the identity of the same norm.
///
/// Steel near a sensor changes the field by tens of percent, which leaves this figure above 0.1;
/// below 0.001 one direction of the field is as good as lost.
const MIN_DETERMINANT: f64 = 1e-3;

/// Takes a soft-iron matrix, row by row.
pub(super) fn check(value: &DeValue<'_>, range: Range) -> Result<Value, String> {
    let mut matrix = [[0.0; 3]; 3];
    for ((row, element), index) in matrix.iter_mut().zip(number::check_three(value)?).zip(1..) {
        *row = number::check_vector(element, range)
            .map_err(|problem| format!("row {index}: {problem}"))?;
    }
    if is_usable(&matrix) {
        Ok(to_value(matrix))
    } else {
        Err("does not turn every field into another one: its determinant is too small or negative"
            .into())
    }
}

pub(super) fn allowed(range: Range) -> String {
    format!(
        "3 rows of 3 numbers, each {range}, whose determinant is positive and not near zero \
         (identity: [[1, 0, 0], [0, 1, 0], [0, 0, 1]])"
    )
}

pub(super) fn identity() -> Value {
    to_value(IDENTITY)
}

fn to_value(matrix: Matrix) -> Value {
    Value::Array(matrix.into_iter().map(number::to_value).collect())
}

fn is_usable(matrix: &Matrix) -> bool {
    let norm = matrix.iter().flatten().map(|m| m * m).sum::<f64>().sqrt();
    let scale = norm / 3.0_f64.sqrt();
    norm > 0.0 && determinant(matrix) >= MIN_DETERMINANT * scale.powi(3)
}

fn determinant([a, b, c]: &Matrix) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_is_usable_if_it_keeps_every_direction() {
        assert!(is_usable(&IDENTITY));
        assert!(is_usable(&[[1.2, 0.1, 0.0], [0.1, 0.8, -0.1], [0.0, -0.1, 1.05]]));
        assert!(is_usable(&[[1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0], [0.0, 0.0, 1e-3]]));
    }

    #[test]
    fn a_matrix_that_flattens_or_mirrors_is_not() {
        assert!(!is_usable(&[[0.0; 3]; 3]));
        assert!(!is_usable(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]));
        assert!(!is_usable(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]));
    }

    #[test]
    fn the_determinant_is_that_of_a_worked_example() {
        let matrix = [[2.0, -1.0, 3.0], [0.0, 4.0, 1.0], [5.0, 2.0, -2.0]];
        assert!((determinant(&matrix) - -85.0).abs() < 1e-12);
    }
}
