//! The covariance of a magnetometer's calibration.

use toml::Value;
use toml::de::DeValue;

use super::kind::mismatch;
use super::number;
use super::range::plus_minus;

/// Soft iron and hard iron; with the slope of the hard iron.
const SIZES: [usize; 2] = [12, 15];
/// No element is larger: (1000 µT)².
const LARGEST: f64 = 1e6;
/// Both sides of the diagonal agree to this part of the variances.
const SYMMETRY: f64 = 1e-6;

pub(super) const ALLOWED: &str = "12 or 15 rows of as many numbers, the same on both sides of the diagonal, which is not negative";

/// Takes a covariance, row by row.
pub(super) fn check(value: &DeValue<'_>) -> Result<Value, String> {
    let rows = value.as_array().ok_or_else(|| mismatch(value))?;
    let size = rows.len();
    if !SIZES.contains(&size) {
        return Err(format!("has {size} rows, not 12 or 15"));
    }
    let mut matrix = Vec::with_capacity(size);
    for (row, index) in rows.iter().zip(1..) {
        let row = check_row(row.get_ref(), size);
        matrix.push(row.map_err(|problem| format!("row {index}: {problem}"))?);
    }
    if !is_covariance(&matrix) {
        return Err("is no covariance: not symmetric, or a variance is negative".into());
    }
    Ok(to_value(&matrix))
}

/// No correlation at all.
pub(super) fn stand_in() -> Value {
    let row = |i: usize| (0..SIZES[0]).map(|j| if i == j { 1.0 } else { 0.0 }).collect();
    to_value(&(0..SIZES[0]).map(row).collect::<Vec<_>>())
}

fn check_row(value: &DeValue<'_>, size: usize) -> Result<Vec<f64>, String> {
    let row = value.as_array().ok_or_else(|| mismatch(value))?;
    if row.len() != size {
        return Err(format!("has {} elements, not {size}", row.len()));
    }
    row.iter().map(|element| number::check(element.get_ref(), plus_minus(LARGEST))).collect()
}

fn is_covariance(matrix: &[Vec<f64>]) -> bool {
    let variance = |i: usize| matrix[i][i];
    let near = |i: usize, j: usize| {
        let scale = (variance(i) * variance(j)).sqrt();
        (matrix[i][j] - matrix[j][i]).abs() <= SYMMETRY * scale
            && matrix[i][j].abs() <= (1.0 + SYMMETRY) * scale
    };
    let size = matrix.len();
    (0..size).all(|i| variance(i) >= 0.0) && (0..size).all(|i| (0..i).all(|j| near(i, j)))
}

fn to_value(matrix: &[Vec<f64>]) -> Value {
    let row = |row: &Vec<f64>| Value::Array(row.iter().copied().map(Value::Float).collect());
    Value::Array(matrix.iter().map(row).collect())
}
