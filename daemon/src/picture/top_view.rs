//! Clouds from straight above, true to scale, each camera's points as light of its own colour.
//!
//! The light adds up: where the clouds of two cameras lie on each other, colours that complement each other make
//! white, and where they do not, each shows beside the other. A column of points is brighter than a single one, so
//! walls stand out from the floor.

use glam::{DVec3, Vec2, Vec3};

use super::canvas::{Canvas, linear};
use super::dot::{Bounds, Dot, Viewer};
use super::lettering::Lettering;

/// Colours of the cameras' points; the first two make white together.
const LIGHTS: [[u8; 3]; 4] = [[255, 150, 40], [20, 214, 252], [90, 220, 90], [230, 90, 220]];
/// Points above each other that make most of the full brightness.
const BRIGHT_COLUMN: f32 = 7.0;
/// How far a camera's drawn view reaches, m.
const VIEW_M: f64 = 0.9;
/// Most of the panel's width that the scale bar takes.
const BAR_SHARE: f64 = 0.25;

/// The colour of a camera's points, in linear light.
pub(super) fn light_of(camera: usize) -> Vec3 {
    linear(LIGHTS[camera % LIGHTS.len()])
}

/// A map of a box: true to scale, north up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plan {
    bounds: Bounds,
    /// Pixels per metre.
    scale: f64,
    size: [usize; 2],
}

impl Plan {
    /// The map of a box, as wide as a panel.
    pub(super) fn of(bounds: Bounds, width: usize) -> Self {
        let scale = width as f64 / bounds.size().x.max(f64::MIN_POSITIVE);
        let height = (bounds.size().y * scale).round().clamp(1.0, 2.0 * width as f64);
        Self { bounds, scale, size: [width, height as usize] }
    }

    /// Width and height, pixels.
    pub(super) const fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Where a point is on the map, pixels, x right, y down.
    pub(super) fn project(&self, point: DVec3) -> Vec2 {
        let [width, height] = self.size.map(|pixels| pixels as f64);
        let from = (point - self.bounds.centre()) * self.scale;
        Vec2::new((width / 2.0 + from.x) as f32, (height / 2.0 - from.y) as f32)
    }

    /// A length on the map, pixels.
    pub(super) fn length(&self, length_m: f64) -> f32 {
        (length_m * self.scale) as f32
    }
}

/// Draws what is in the plan's box (what is above it is cut away), each point as a square of a size, m.
pub(super) fn draw(dots: &[Dot], size_m: f64, plan: &Plan, ground: Vec3) -> Canvas {
    let [width, height] = plan.size;
    let mut canvas = Canvas::new(width, height, ground);
    for camera in 0..LIGHTS.len() {
        let seen = dots.iter().filter(|dot| dot.seen_by >> camera & 1 == 1);
        let within =
            seen.filter(|dot| (plan.bounds.low.z..=plan.bounds.high.z).contains(&dot.position_m.z));
        let columns = columns(within, plan.length(size_m), plan);
        let colour = light_of(camera);
        for (pixel, points) in canvas.pixels_mut().iter_mut().zip(columns) {
            *pixel += colour * (1.0 - (-points / BRIGHT_COLUMN).exp());
        }
    }
    canvas
}

/// How many points are above each other at each pixel.
fn columns<'a>(dots: impl Iterator<Item = &'a Dot>, size: f32, plan: &Plan) -> Vec<f32> {
    let [width, height] = plan.size;
    let mut columns = vec![0.0; width * height];
    // Where points lie closer than pixels, a column is what one point's square would hold.
    let side = size.max(1.0);
    let share = (size * size).min(1.0);
    for dot in dots {
        let low = plan.project(dot.position_m) - Vec2::splat(side / 2.0);
        for (y, high_share) in overlaps(low.y, side, height) {
            for (x, wide_share) in overlaps(low.x, side, width) {
                columns[y * width + x] += share * high_share * wide_share;
            }
        }
    }
    columns
}

/// The pixels that a stretch meets, and how much of each it covers.
fn overlaps(begin: f32, length: f32, size: usize) -> impl Iterator<Item = (usize, f32)> {
    let end = begin + length;
    let (first, last) = (begin.floor().max(0.0) as usize, (end.ceil().max(0.0) as usize).min(size));
    (first..last).map(move |pixel| {
        let at = pixel as f32;
        (pixel, (end.min(at + 1.0) - begin.max(at)).max(0.0))
    })
}

/// Draws a camera: where it is, how far it looks to the sides, and its name.
pub(super) fn draw_viewer(
    canvas: &mut Canvas,
    plan: &Plan,
    viewer: &Viewer,
    colour: Vec3,
    text: f32,
) {
    let at = plan.project(viewer.position_m);
    let bearing = viewer.forward.y.atan2(viewer.forward.x);
    let edge = |turn: f64| {
        let (sin, cos) = (bearing + turn).sin_cos();
        plan.project(viewer.position_m + DVec3::new(cos, sin, 0.0) * VIEW_M)
    };
    let half = viewer.half_view_rad;
    // Turning to the left runs against the clock.
    let arc: Vec<Vec2> = (0..=8).map(|n| edge(half - f64::from(n) / 4.0 * half)).collect();
    let fan: Vec<Vec2> = std::iter::once(at).chain(arc).collect();
    canvas.polygon(&fan, (colour, 0.3));
    for side in [fan[1], fan[9]] {
        canvas.line([at, side], 2.0, (colour, 0.9));
    }
    canvas.disc(at, text * 0.42, (Vec3::ONE, 1.0));
    canvas.disc(at, text * 0.30, (colour, 1.0));
    let ahead = Vec2::new(bearing.cos() as f32, -bearing.sin() as f32);
    let label = at - ahead * text * 1.7 + Vec2::new(0.0, text / 2.0);
    Lettering::new(text, Vec3::ONE).bold().draw_centred(canvas, label.to_array(), &viewer.name);
}

/// Draws a scale bar at the lower left and an arrow to the north at the upper right.
pub(super) fn draw_scale_and_north(canvas: &mut Canvas, plan: &Plan, text: f32) {
    let style = Lettering::new(text, Vec3::splat(0.75));
    let paint = (style.colour, 1.0);
    let (bar_m, height) = (bar_length_m(plan), canvas.height() as f32);
    let (left, line) = (text * 1.2, height - text * 1.2);
    let right = left + plan.length(bar_m);
    canvas.line([Vec2::new(left, line), Vec2::new(right, line)], 3.0, paint);
    for end in [left, right] {
        canvas.line(
            [Vec2::new(end, line - text * 0.4), Vec2::new(end, line + text * 0.4)],
            3.0,
            paint,
        );
    }
    style.draw(canvas, [right + text, line + text / 2.0], &format!("{bar_m} m"));

    let (x, top) = (canvas.width() as f32 - text * 1.8, text * 3.0);
    let tip = Vec2::new(x, top);
    let wing = |side: f32| Vec2::new(x + side * text * 0.6, top + text * 1.9);
    canvas.polygon(&[tip, wing(1.0), Vec2::new(x, top + text * 1.4), wing(-1.0)][..3], paint);
    canvas.polygon(&[tip, Vec2::new(x, top + text * 1.4), wing(-1.0)], paint);
    style.draw_centred(canvas, [x, top - text * 0.5], "N");
}

/// The longest of 1, 2, 5, 10 … m that leaves room.
fn bar_length_m(plan: &Plan) -> f64 {
    let most = plan.bounds.size().x * BAR_SHARE;
    let power = 10_f64.powf(most.log10().floor());
    [5.0, 2.0, 1.0].into_iter().map(|n| n * power).find(|length| *length <= most).unwrap_or(power)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: Bounds =
        Bounds { low: DVec3::new(-4.0, -3.0, 0.0), high: DVec3::new(4.0, 3.0, 2.0) };

    fn dot(x: f64, y: f64, z: f64, seen_by: u32) -> Dot {
        Dot { position_m: DVec3::new(x, y, z), colour: [0; 3], seen_by }
    }

    #[test]
    fn the_map_is_true_to_scale_with_north_up() {
        let plan = Plan::of(BOX, 400);
        assert_eq!(plan.size(), [400, 300]);
        let origin = plan.project(DVec3::ZERO);
        assert!(plan.project(DVec3::X).distance(origin + Vec2::new(50.0, 0.0)) < 1e-3);
        assert!(plan.project(DVec3::Y).distance(origin - Vec2::new(0.0, 50.0)) < 1e-3);
        assert!((plan.length(2.0) - 100.0).abs() < 1e-3);
    }

    #[test]
    fn a_bar_is_a_round_length_that_fits() {
        for (width_m, expected_m) in [(8.0, 2.0), (3.9, 0.5), (4.0, 1.0), (100.0, 20.0)] {
            let bounds = Bounds { low: DVec3::ZERO, high: DVec3::new(width_m, 1.0, 1.0) };
            assert!((bar_length_m(&Plan::of(bounds, 400)) - expected_m).abs() < 1e-9, "{width_m}");
        }
    }

    #[test]
    fn clouds_that_fit_are_white_and_others_show_both_colours() {
        let plan = Plan::of(BOX, 400);
        let column =
            |x: f64, seen_by: u32| (0..40).map(move |n| dot(x, 0.0, f64::from(n) * 0.05, seen_by));
        let dots: Vec<Dot> = column(-1.0, 3).chain(column(0.5, 1)).chain(column(1.0, 2)).collect();
        let canvas = draw(&dots, 0.05, &plan, Vec3::ZERO);
        let at = |x: f64| {
            let place = plan.project(DVec3::new(x, 0.0, 0.0));
            canvas.at(place.x as usize, place.y as usize)
        };
        let [both, first, second] = [at(-1.0), at(0.5), at(1.0)];
        assert!(both.min_element() > 0.9, "{both}");
        assert!(first.x > 3.0 * first.z && second.z > 3.0 * second.x, "{first} {second}");
    }

    #[test]
    fn what_is_above_the_box_is_cut_away() {
        let plan = Plan::of(BOX, 400);
        let ceiling: Vec<Dot> = (0..99).map(|_| dot(0.0, 0.0, 2.5, 3)).collect();
        assert_eq!(draw(&ceiling, 0.05, &plan, Vec3::ZERO), Canvas::new(400, 300, Vec3::ZERO));
    }

    #[test]
    fn a_camera_looks_where_it_looks() {
        let plan = Plan::of(BOX, 400);
        let mut canvas = Canvas::new(400, 300, Vec3::ZERO);
        let viewer = Viewer {
            name: String::new(),
            position_m: DVec3::ZERO,
            forward: DVec3::X,
            half_view_rad: 0.5,
        };
        draw_viewer(&mut canvas, &plan, &viewer, Vec3::ONE, 10.0);
        assert!(canvas.at(230, 150).x > 0.2, "to the east");
        for (x, y) in [(170, 150), (200, 120), (200, 180)] {
            assert_eq!(canvas.at(x, y), Vec3::ZERO, "{x} {y}");
        }
    }
}
