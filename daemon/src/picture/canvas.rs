//! A picture in memory, and the few shapes that are drawn into it.

use glam::{Vec2, Vec3};

/// Colours in linear light, row by row from the top left; x to the right, y down, in pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<Vec3>,
}

/// A colour of the screen (sRGB, 0 to 255) in linear light, each component 0 to 1.
pub(super) fn linear([red, green, blue]: [u8; 3]) -> Vec3 {
    let one = |value: u8| {
        let value = f32::from(value) / 255.0;
        if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
    };
    Vec3::new(one(red), one(green), one(blue))
}

/// A colour in linear light as the screen shows it (sRGB, IEC 61966-2-1); what is too bright is white.
pub(super) fn screen(colour: Vec3) -> [u8; 3] {
    let one = |value: f32| {
        let value = value.clamp(0.0, 1.0);
        let shown = if value <= 0.003_130_8 {
            12.92 * value
        } else {
            1.055 * value.powf(1.0 / 2.4) - 0.055
        };
        (255.0 * shown).round() as u8
    };
    colour.to_array().map(one)
}

impl Canvas {
    /// One colour all over.
    pub fn new(width: usize, height: usize, colour: Vec3) -> Self {
        Self { width, height, pixels: vec![colour; width * height] }
    }

    /// Pixels in a row.
    pub const fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub const fn height(&self) -> usize {
        self.height
    }

    /// The colour at a pixel, in linear light; black outside.
    pub fn at(&self, x: usize, y: usize) -> Vec3 {
        if x < self.width {
            self.pixels.get(y * self.width + x).copied().unwrap_or_default()
        } else {
            Vec3::ZERO
        }
    }

    /// All pixels, row by row.
    pub fn pixels_mut(&mut self) -> &mut [Vec3] {
        &mut self.pixels
    }

    /// Rows of red, green, blue, as a file has them.
    pub fn to_rgb(&self) -> Vec<u8> {
        self.pixels.iter().flat_map(|colour| screen(*colour)).collect()
    }

    /// Lays another picture on this one; what would be outside is cut off.
    pub fn paste(&mut self, other: &Self, left: usize, top: usize) {
        let columns = other.width.min(self.width.saturating_sub(left));
        for row in 0..other.height.min(self.height.saturating_sub(top)) {
            let (to, from) = ((top + row) * self.width + left, row * other.width);
            self.pixels[to..to + columns].copy_from_slice(&other.pixels[from..from + columns]);
        }
    }

    /// The picture in half the size: each pixel the mean of four. An odd last row or column is lost.
    #[must_use]
    pub fn halved(&self) -> Self {
        let (width, height) = (self.width / 2, self.height / 2);
        let mean = |x: usize, y: usize| {
            let four = [(0, 0), (1, 0), (0, 1), (1, 1)];
            four.iter().map(|(i, j)| self.at(2 * x + i, 2 * y + j)).sum::<Vec3>() / 4.0
        };
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Self { width, height, pixels: pixels.map(|(x, y)| mean(x, y)).collect() }
    }

    /// A straight line with round ends.
    pub fn line(&mut self, [from, to]: [Vec2; 2], width: f32, (colour, opacity): (Vec3, f32)) {
        let along = to - from;
        let distance = |point: Vec2| {
            let share = (point - from).dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
            (point - from - along * share.clamp(0.0, 1.0)).length() - width / 2.0
        };
        let margin = Vec2::splat(width / 2.0);
        self.fill([from.min(to) - margin, from.max(to) + margin], distance, (colour, opacity));
    }

    /// A line through several points.
    pub fn polyline(&mut self, points: &[Vec2], width: f32, paint: (Vec3, f32)) {
        for pair in points.windows(2) {
            self.line([pair[0], pair[1]], width, paint);
        }
    }

    /// A filled disc.
    pub fn disc(&mut self, centre: Vec2, radius: f32, paint: (Vec3, f32)) {
        let reach = Vec2::splat(radius);
        let distance = |point: Vec2| (point - centre).length() - radius;
        self.fill([centre - reach, centre + reach], distance, paint);
    }

    /// A filled convex polygon, its corners clockwise as seen on the screen.
    pub fn polygon(&mut self, corners: &[Vec2], paint: (Vec3, f32)) {
        let Some(first) = corners.first() else { return };
        let low = corners.iter().fold(*first, |low, corner| low.min(*corner));
        let high = corners.iter().fold(*first, |high, corner| high.max(*corner));
        let distance = |point: Vec2| {
            let next = corners.iter().cycle().skip(1);
            let outside = corners.iter().zip(next).map(|(a, b)| {
                // Clockwise with y down: the inside is to the right of each edge.
                -(point - *a).dot((*b - *a).perp().normalize_or_zero())
            });
            outside.fold(f32::NEG_INFINITY, f32::max)
        };
        self.fill([low, high], distance, paint);
    }

    /// Paints where a signed distance (pixels, negative inside) is below zero, its edge smooth.
    fn fill(
        &mut self,
        [low, high]: [Vec2; 2],
        distance: impl Fn(Vec2) -> f32,
        (colour, opacity): (Vec3, f32),
    ) {
        let begin = |low: f32| (low - 1.0).max(0.0) as usize;
        let end = |high: f32, size: usize| ((high + 2.0).max(0.0) as usize).min(size);
        for y in begin(low.y)..end(high.y, self.height) {
            for x in begin(low.x)..end(high.x, self.width) {
                let centre = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                let covered = (0.5 - distance(centre)).clamp(0.0, 1.0) * opacity;
                let pixel = &mut self.pixels[y * self.width + x];
                *pixel = pixel.lerp(colour, covered);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: (Vec3, f32) = (Vec3::ONE, 1.0);

    fn lit(canvas: &Canvas) -> f32 {
        canvas.pixels.iter().map(|pixel| pixel.x).sum()
    }

    #[test]
    fn every_screen_colour_survives_linear_light() {
        for value in 0..=255 {
            assert_eq!(screen(linear([value; 3])), [value; 3]);
        }
    }

    #[test]
    fn a_disc_and_a_square_cover_their_areas_wherever_they_lie() {
        for shift in [0.0, 0.3, 0.5] {
            let mut canvas = Canvas::new(40, 40, Vec3::ZERO);
            canvas.disc(Vec2::splat(20.0 + shift), 8.0, WHITE);
            let expected = std::f32::consts::PI * 64.0;
            assert!((lit(&canvas) / expected - 1.0).abs() < 0.01, "{}", lit(&canvas));

            let mut canvas = Canvas::new(40, 40, Vec3::ZERO);
            let [a, b] = [10.0 + shift, 25.0 + shift];
            let square = [Vec2::new(a, a), Vec2::new(b, a), Vec2::new(b, b), Vec2::new(a, b)];
            canvas.polygon(&square, WHITE);
            assert!((lit(&canvas) / 225.0 - 1.0).abs() < 0.02, "{}", lit(&canvas));
        }
    }

    #[test]
    fn shapes_beyond_the_edge_are_cut_off() {
        let mut canvas = Canvas::new(10, 10, Vec3::ZERO);
        canvas.disc(Vec2::new(-50.0, 5.0), 3.0, WHITE);
        canvas.line([Vec2::new(5.0, -99.0), Vec2::new(5.0, 99.0)], 2.0, WHITE);
        assert!((lit(&canvas) - 20.0).abs() < 0.1, "{}", lit(&canvas));
        let mut other = Canvas::new(4, 4, Vec3::ZERO);
        other.paste(&canvas, 2, 3);
        assert_eq!(other.at(0, 0), Vec3::ZERO);
        assert_eq!(other.at(2, 3), canvas.at(0, 0));
    }

    #[test]
    fn halving_keeps_the_light() {
        let mut canvas = Canvas::new(40, 40, Vec3::ZERO);
        canvas.disc(Vec2::splat(20.0), 8.0, WHITE);
        let half = canvas.halved();
        assert_eq!((half.width(), half.height()), (20, 20));
        assert!((4.0 * lit(&half) / lit(&canvas) - 1.0).abs() < 1e-5);
    }
}
