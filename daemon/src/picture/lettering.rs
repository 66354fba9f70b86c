//! Text in a picture, drawn as with a pen: no font file is needed, and it is sharp in every size.

use glam::Vec2;
use glam::Vec3;

use super::canvas::Canvas;
use super::glyphs::glyph;

/// Height of a capital on the glyphs' grid.
const CAPITAL: f32 = 9.0;
/// Between two letters, on the grid.
const GAP: f32 = 2.6;
/// Width of the pen, on the grid.
const PEN: f32 = 1.05;
/// How often a curve's corners are cut; each time halves what is left of them.
const CUTS: usize = 4;

/// How text looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lettering {
    /// Height of a capital letter, pixels.
    pub(super) height: f32,
    /// Width of the pen against the normal one.
    pub(super) weight: f32,
    /// In linear light.
    pub(super) colour: Vec3,
}

impl Lettering {
    /// Normal weight.
    pub(super) const fn new(height: f32, colour: Vec3) -> Self {
        Self { height, weight: 1.0, colour }
    }

    /// The same, bold.
    #[must_use]
    pub(super) const fn bold(self) -> Self {
        Self { weight: 1.5, ..self }
    }

    /// Width of a line of text, pixels.
    pub(super) fn width(&self, text: &str) -> f32 {
        let advance: f32 = text.chars().map(|c| f32::from(glyph(c).0) + GAP).sum();
        (advance - GAP).max(0.0) * self.unit()
    }

    /// Draws a line of text whose first letter begins at `left` and stands on `line` (y of the line).
    pub(super) fn draw(&self, canvas: &mut Canvas, [left, line]: [f32; 2], text: &str) {
        let unit = self.unit();
        let mut at = Vec2::new(left, line - self.height);
        for character in text.chars() {
            let (width, strokes) = glyph(character);
            for stroke in strokes.split(';') {
                let points: Vec<Vec2> = path(stroke).iter().map(|p| at + *p * unit).collect();
                canvas.polyline(&points, PEN * self.weight * unit, (self.colour, 1.0));
            }
            at.x += (f32::from(width) + GAP) * unit;
        }
    }

    /// Draws a line of text whose middle is at `middle`.
    pub(super) fn draw_centred(&self, canvas: &mut Canvas, [middle, line]: [f32; 2], text: &str) {
        self.draw(canvas, [middle - self.width(text) / 2.0, line], text);
    }

    fn unit(&self) -> f32 {
        self.height / CAPITAL
    }
}

/// The points of a stroke on the grid.
fn path(stroke: &str) -> Vec<Vec2> {
    let (kind, pairs) = stroke.split_at(stroke.len() - stroke.trim_start_matches(['~', '@']).len());
    let points: Vec<Vec2> = pairs.split_whitespace().filter_map(point).collect();
    match kind {
        "~" => (0..CUTS).fold(points, |points, _| cut(&points)),
        "@" => {
            let mut points = (0..CUTS).fold(points, |points, _| cut_closed(&points));
            points.extend(points.first().copied());
            points
        }
        _ => points,
    }
}

fn point(pair: &str) -> Option<Vec2> {
    let mut digits = pair.chars().map(|digit| digit.to_digit(16));
    let [x, y] = [digits.next()??, digits.next()??];
    Some(Vec2::new(x as f32, y as f32))
}

/// Cuts the corners between two ends that stay (Chaikin 1974): what it tends to is a quadratic B-spline.
fn cut(points: &[Vec2]) -> Vec<Vec2> {
    let [first, .., last] = points else { return points.to_vec() };
    let inner = points.windows(2).flat_map(|pair| quarters(pair[0], pair[1]));
    let inner: Vec<Vec2> = inner.collect();
    let kept = &inner[1..inner.len() - 1];
    [&[*first], kept, &[*last]].concat()
}

fn cut_closed(points: &[Vec2]) -> Vec<Vec2> {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).flat_map(|(a, b)| quarters(*a, *b)).collect()
}

fn quarters(a: Vec2, b: Vec2) -> [Vec2; 2] {
    [a.lerp(b, 0.25), a.lerp(b, 0.75)]
}

#[cfg(test)]
mod tests {
    use super::*;

    const PRINTED: &str = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789\
                           .,:;-–+±×=/()%°<>≤≥_'\"!?·";

    fn drawn(text: &str) -> Canvas {
        let mut canvas = Canvas::new(40, 40, Vec3::ZERO);
        Lettering::new(18.0, Vec3::ONE).draw(&mut canvas, [8.0, 30.0], text);
        canvas
    }

    #[test]
    fn every_printed_character_is_drawn_unlike_any_other() {
        let all: Vec<(char, Canvas)> =
            PRINTED.chars().chain(['\u{fffd}']).map(|c| (c, drawn(&c.to_string()))).collect();
        let blank = drawn(" ");
        for (index, (character, canvas)) in all.iter().enumerate() {
            assert!(*canvas != blank, "{character} is invisible");
            let alike = all[..index].iter().find(|(_, other)| other == canvas);
            // A bar is a bar.
            let bars = alike.is_some_and(|(other, _)| "Il".contains(*other) && *character == 'l');
            assert!(alike.is_none() || bars, "{character} looks like {:?}", alike.map(|a| a.0));
        }
    }

    #[test]
    fn text_keeps_to_its_line_and_its_width() {
        let style = Lettering::new(18.0, Vec3::ONE);
        let mut canvas = Canvas::new(400, 60, Vec3::ZERO);
        style.draw(&mut canvas, [10.0, 40.0], "HIT 0.5");
        let right = 10.0 + style.width("HIT 0.5");
        for (y, x) in (0..60).flat_map(|y| (0..400).map(move |x| (y, x))) {
            let inside = (20..=42).contains(&y) && (8.0..right + 2.0).contains(&(x as f32));
            assert!(inside || canvas.at(x, y) == Vec3::ZERO, "{x} {y}");
        }
    }

    #[test]
    fn a_curve_keeps_its_ends() {
        let curve = path("~00 50 59");
        assert_eq!(curve.first(), Some(&Vec2::ZERO));
        assert_eq!(curve.last(), Some(&Vec2::new(5.0, 9.0)));
        assert!(curve.len() > 16);
    }
}
