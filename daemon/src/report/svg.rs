//! Text and numbers as SVG and HTML want them.

use std::fmt::{self, Display, Write};

pub use lodestone_client::latency::Escaped;

/// A coordinate on the page: a tenth of a pixel is finer than anybody sees, and short.
#[derive(Clone, Copy, Debug)]
pub struct Px(pub f64);

impl Display for Px {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let tenths = (self.0 * 10.0).round();
        // Not "-0".
        let tenths = if tenths == 0.0 { 0.0 } else { tenths };
        write!(out, "{}", tenths / 10.0)
    }
}

/// Path data of separate dots; drawn as dots by a round line cap. Points at one place stand once.
pub fn dots(points: impl Iterator<Item = (f64, f64)>) -> String {
    let mut data = String::new();
    let mut seen = std::collections::BTreeSet::new();
    for (x, y) in points {
        // Half a pixel apart is one dot.
        if seen.insert(((2.0 * x).round() as i64, (2.0 * y).round() as i64)) {
            append(&mut data, format_args!("M{} {}h0", Px(x), Px(y)));
        }
    }
    data
}

/// Path data of one line through points.
pub fn polyline(points: impl Iterator<Item = (f64, f64)>) -> String {
    let mut data = String::new();
    for (x, y) in points {
        let step = if data.is_empty() { 'M' } else { 'L' };
        append(&mut data, format_args!("{step}{} {}", Px(x), Px(y)));
    }
    data
}

/// Appends to text, which cannot fail.
pub(super) fn append(text: &mut String, more: fmt::Arguments<'_>) {
    let _ = text.write_fmt(more);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_short() {
        let shown = [0.04, -0.04, 12.0, 2.71, -7.06].map(|x| Px(x).to_string());
        assert_eq!(shown, ["0", "0", "12", "2.7", "-7.1"]);
    }

    #[test]
    fn paths_begin_with_a_move_and_dots_do_not_repeat() {
        assert_eq!(polyline([(0.0, 1.0), (2.0, 3.0)].into_iter()), "M0 1L2 3");
        assert_eq!(dots([(5.0, 5.0), (5.1, 5.0), (9.0, 5.0)].into_iter()), "M5 5h0M9 5h0");
    }
}
