//! Marks that are more than points and lines: bands, arrows, words.

use super::super::svg::{Escaped, Px, append, polyline};
use super::{Plot, is_finite};

/// Length of an arrow's head, px.
const HEAD_PX: f64 = 4.0;

impl Plot {
    /// A band between two lines over the same places: `(x, low, high)`.
    pub fn band(&mut self, class: &str, points: &[(f64, f64, f64)]) {
        let upper = points.iter().map(|(x, _, high)| (*x, *high));
        let lower = points.iter().rev().map(|(x, low, _)| (*x, *low));
        let outline: Vec<_> =
            upper.chain(lower).map(|point| self.place(point)).filter(is_finite).collect();
        if outline.len() < 3 {
            return;
        }
        let data = polyline(outline.into_iter());
        append(&mut self.within, format_args!("<path class=\"band {class}\" d=\"{data}Z\"/>"));
    }

    /// Arrows from one point to another. Those that begin outside of the axes are left out.
    pub fn arrows(&mut self, class: &str, arrows: impl Iterator<Item = [(f64, f64); 2]>) {
        let mut data = String::new();
        for [from, to] in arrows {
            let Some(tail) = self.inside(from) else { continue };
            append_arrow(&mut data, tail, self.place(to));
        }
        append(&mut self.within, format_args!("<path class=\"line {class}\" d=\"{data}\"/>"));
    }

    /// A word at a point.
    pub fn word(&mut self, class: &str, point: (f64, f64), text: &str) {
        let Some((x, y)) = self.inside(point) else { return };
        let (x, y, text) = (Px(x), Px(y), Escaped(text));
        append(
            &mut self.within,
            format_args!(
                "<text class=\"{class}\" x=\"{x}\" y=\"{y}\" text-anchor=\"middle\">{text}</text>"
            ),
        );
    }
}

/// A shaft with two strokes for a head; a shaft that points at the reader has none.
fn append_arrow(data: &mut String, tail: (f64, f64), tip: (f64, f64)) {
    let (dx, dy) = (tip.0 - tail.0, tip.1 - tail.1);
    let length = dx.hypot(dy);
    append(data, format_args!("M{} {}L{} {}", Px(tail.0), Px(tail.1), Px(tip.0), Px(tip.1)));
    if length < HEAD_PX {
        return;
    }
    let (ux, uy) = (HEAD_PX * dx / length, HEAD_PX * dy / length);
    let side = |sign: f64| (tip.0 - ux - sign * 0.5 * uy, tip.1 - uy + sign * 0.5 * ux);
    let (left, right) = (side(1.0), side(-1.0));
    append(
        data,
        format_args!(
            "M{} {}L{} {}L{} {}",
            Px(left.0),
            Px(left.1),
            Px(tip.0),
            Px(tip.1),
            Px(right.0),
            Px(right.1)
        ),
    );
}

#[cfg(test)]
mod tests {
    use super::super::Plot;

    fn picture() -> Plot {
        Plot::picture("p", 104.0, ((0.0, 0.0), 50.0))
    }

    #[test]
    fn a_band_is_closed_and_an_empty_one_is_nothing() {
        let mut plot = picture();
        plot.band("ours", &[(0.0, -1.0, 1.0), (10.0, -2.0, 2.0)]);
        plot.band("none", &[]);
        plot.band("none", &[(f64::NAN, 0.0, 1.0)]);
        let markup = plot.finish();
        assert!(markup.contains("class=\"band ours\" d=\"M50 49L60 48L60 52L50 51Z\""), "{markup}");
        assert!(!markup.contains("none"));
    }

    #[test]
    fn an_arrow_has_its_head_where_it_points() {
        let mut plot = picture();
        let arrows = [[(0.0, 0.0), (20.0, 0.0)], [(90.0, 0.0), (95.0, 0.0)]];
        plot.arrows("ink", arrows.into_iter());
        let markup = plot.finish();
        assert!(markup.contains("d=\"M50 50L70 50M66 52L70 50L66 48\""), "{markup}");
    }

    #[test]
    fn words_are_text() {
        let mut plot = picture();
        plot.word("tick", (0.0, 0.0), "1 < 2");
        plot.word("tick", (0.0, 99.0), "outside");
        let markup = plot.finish();
        assert!(markup.contains(">1 &lt; 2</text>") && !markup.contains("outside"), "{markup}");
    }
}
