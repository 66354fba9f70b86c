//! Numbers as they stand in tables.

use super::super::scale::signed;
use crate::evaluation::statistics::Quantiles;

/// A length with its unit and about three digits: 0.12 mm, 0.139 m, 24.8 m, 2295 m.
pub(in crate::report) fn length(metres: f64) -> String {
    match metres.abs() {
        m if m < 9.95e-4 => format!("{} mm", signed(1000.0 * metres, 2)),
        m if m < 9.95e-3 => format!("{} mm", signed(1000.0 * metres, 1)),
        m if m < 0.995 => format!("{} m", signed(metres, 3)),
        m if m < 9.95 => format!("{} m", signed(metres, 2)),
        m if m < 99.5 => format!("{} m", signed(metres, 1)),
        _ => format!("{} m", signed(metres, 0)),
    }
}

/// The median, and in small letters what nine of ten runs lie above and below.
pub(super) fn lengths(q: &Quantiles) -> String {
    format!("{} <small>{} … {}</small>", length(q.median), bare(q.low, q.high), length(q.high))
}

/// The lower end without its unit where that is the upper end's.
fn bare(low: f64, high: f64) -> String {
    let (low, high) = (length(low), length(high));
    match (low.split_once(' '), high.split_once(' ')) {
        (Some((number, a)), Some((_, b))) if a == b => number.into(),
        _ => low,
    }
}

/// The same of plain numbers.
pub(super) fn numbers(q: &Quantiles, decimals: usize) -> String {
    let [low, median, high] = [q.low, q.median, q.high].map(|x| signed(x, decimals));
    format!("{median} <small>{low} … {high}</small>")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_three_digits_and_a_unit() {
        let shown = [1.2e-4, 4.44e-3, 0.1391, 1.407, 24.766, 2295.3].map(length);
        assert_eq!(shown, ["0.12 mm", "4.4 mm", "0.139 m", "1.41 m", "24.8 m", "2295 m"]);
        let q = Quantiles { low: 0.5, median: 1.0, high: 20.0 };
        assert_eq!(lengths(&q), "1.00 m <small>0.500 … 20.0 m</small>");
        let q = Quantiles { low: 1e-4, median: 1.0, high: 20.0 };
        assert_eq!(lengths(&q), "1.00 m <small>0.10 mm … 20.0 m</small>");
    }
}
