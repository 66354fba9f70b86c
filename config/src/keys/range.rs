//! Ranges of numbers.

use std::fmt;

/// A finite range of numbers with its ends, the lower of which may be left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Range {
    min: f64,
    max: f64,
    min_excluded: bool,
}

/// The numbers from `min` to `max`, both included.
pub(crate) const fn from_to(min: f64, max: f64) -> Range {
    Range { min, max, min_excluded: false }
}

/// The positive numbers up to `max`.
pub(crate) const fn above_zero_to(max: f64) -> Range {
    Range { min: 0.0, max, min_excluded: true }
}

/// The numbers from `-max` to `max`.
pub(crate) const fn plus_minus(max: f64) -> Range {
    from_to(-max, max)
}

impl Range {
    /// Whether the range holds a number; false for one that is not a number.
    pub(crate) fn holds(self, number: f64) -> bool {
        let above = if self.min_excluded { number > self.min } else { number >= self.min };
        above && number <= self.max
    }

    /// A number in the range: its upper end.
    pub(crate) const fn any(self) -> f64 {
        self.max
    }
}

impl fmt::Display for Range {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.min_excluded {
            write!(out, "above {} up to {}", self.min, self.max)
        } else {
            write!(out, "from {} to {}", self.min, self.max)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lower_end_counts_only_where_it_is_included() {
        assert!(from_to(0.0, 1.0).holds(0.0));
        assert!(!above_zero_to(1.0).holds(0.0));
        assert!(above_zero_to(1.0).holds(f64::MIN_POSITIVE));
        assert!(plus_minus(1.0).holds(-1.0));
    }

    #[test]
    fn what_is_not_finite_is_in_no_range() {
        for number in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(!plus_minus(f64::MAX).holds(number));
        }
    }
}
