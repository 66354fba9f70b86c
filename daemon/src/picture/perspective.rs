//! Points as seen from somewhere, the near ones in front.
//!
//! Each point is a disc as large as its surface appears; what is behind is hidden by a depth buffer; edges and
//! folds are shaded by how much closer the neighbourhood is (eye-dome lighting: Boucheny 2009), because points
//! have no normals. Drawn twice as large and averaged.

use glam::{DVec2, DVec3, Vec2, Vec3};

use super::canvas::{Canvas, linear};
use super::dot::{Bounds, Dot};

/// Drawn larger by this.
const OVERSAMPLED: usize = 2;
/// Strength of the shading.
const SHADING: f32 = 14.0;
/// Reach of the shading, pixels of the finished picture.
const SHADING_REACH: usize = 2;
/// How often the eye is moved to have what it looks at in the middle; the last move is far below a pixel.
const CENTRINGS: usize = 12;
/// Share of the picture's width or height that is filled.
const FILLED: f64 = 0.96;
/// Between the near plane and the eye, m.
const NEAR_M: f64 = 0.1;

/// An eye in the world and what it looks at: a pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Eye {
    position: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Pixels per unit of tangent.
    focal: f64,
    size: [usize; 2],
}

/// From where to look at something.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::struct_field_names, reason = "each carries its unit")]
pub(super) struct Direction {
    /// To the eye, clockwise from north, rad.
    pub(super) azimuth_rad: f64,
    /// To the eye, above the horizon, rad.
    pub(super) elevation_rad: f64,
    /// The eye's horizontal field of view, rad.
    pub(super) view_rad: f64,
}

impl Eye {
    /// An eye in a direction, as close as it can be with the whole box in view.
    pub(super) fn on(bounds: Bounds, direction: Direction, size: [usize; 2]) -> Self {
        let Direction { azimuth_rad, elevation_rad, view_rad } = direction;
        let level = DVec3::new(azimuth_rad.sin(), azimuth_rad.cos(), 0.0);
        let back = level * elevation_rad.cos() + DVec3::Z * elevation_rad.sin();
        let right = DVec3::Z.cross(level);
        let up = back.cross(right);
        let [width, height] = size.map(|pixels| pixels as f64);
        let tangent = (view_rad / 2.0).tan();
        let wide = tangent * FILLED;
        let high = wide * height / width;
        let focal = width / 2.0 / tangent;
        let mut eye = Self { position: DVec3::ZERO, right, up, forward: -back, focal, size };
        let mut middle = bounds.centre();
        for _ in 0..CENTRINGS {
            let needed = |corner: &DVec3| {
                let from = *corner - middle;
                let [x, y] = [from.dot(right).abs() / wide, from.dot(up).abs() / high];
                from.dot(back) + x.max(y)
            };
            let away = bounds.corners().iter().map(needed).fold(NEAR_M, f64::max);
            eye.position = middle + back * away;
            let off = eye.middle_of(&bounds.corners()) * (away / focal);
            middle += right * off.x - up * off.y;
        }
        eye
    }

    /// Where the middle of what is seen of some points is, from the middle of the picture, pixels.
    fn middle_of(&self, points: &[DVec3]) -> DVec2 {
        let seen = points.iter().filter_map(|point| self.project(*point));
        let seen: Vec<Vec2> = seen.map(|(at, _)| at).collect();
        let low = seen.iter().copied().fold(Vec2::INFINITY, Vec2::min);
        let high = seen.iter().copied().fold(Vec2::NEG_INFINITY, Vec2::max);
        let [width, height] = self.size.map(|pixels| pixels as f64);
        ((low + high) / 2.0).as_dvec2() - DVec2::new(width, height) / 2.0
    }

    /// Where a point appears (x right, y down, pixels) and its depth, m; `None` behind the eye.
    pub(super) fn project(&self, point: DVec3) -> Option<(Vec2, f64)> {
        let from = point - self.position;
        let depth = from.dot(self.forward);
        let [width, height] = self.size.map(|pixels| pixels as f64);
        let scale = self.focal / depth;
        let x = width / 2.0 + from.dot(self.right) * scale;
        let y = height / 2.0 - from.dot(self.up) * scale;
        (depth > NEAR_M).then_some((Vec2::new(x as f32, y as f32), depth))
    }

    /// How large a length appears at a depth, pixels.
    pub(super) fn apparent(&self, length_m: f64, depth_m: f64) -> f64 {
        length_m * self.focal / depth_m
    }

    /// Whether a point is on the eye's side of one of a box's upright walls: what stands there hides the room.
    pub(super) fn is_behind_wall(&self, bounds: Bounds, point: DVec3) -> bool {
        let beyond = |eye: f64, low: f64, high: f64, at: f64| {
            (eye > high && at > high) || (eye < low && at < low)
        };
        let (eye, low, high) = (self.position, bounds.low, bounds.high);
        beyond(eye.x, low.x, high.x, point.x) || beyond(eye.y, low.y, high.y, point.y)
    }
}

/// Draws points as discs of a diameter, m.
pub(super) fn draw(
    dots: impl Iterator<Item = Dot>,
    diameter_m: f64,
    eye: &Eye,
    ground: Vec3,
) -> Canvas {
    let size = eye.size.map(|pixels| pixels * OVERSAMPLED);
    let close = Eye { focal: eye.focal * OVERSAMPLED as f64, size, ..*eye };
    let mut buffer = DepthBuffer::new(size, ground);
    for dot in dots {
        if let Some((centre, depth)) = close.project(dot.position_m) {
            let radius = close.apparent(diameter_m, depth) as f32 / 2.0;
            buffer.splat(centre, radius.max(0.5), depth as f32, linear(dot.colour));
        }
    }
    (1..OVERSAMPLED).fold(buffer.shaded(), |canvas, _| canvas.halved())
}

/// The nearest colour at each pixel, and how far it is.
struct DepthBuffer {
    canvas: Canvas,
    depth_m: Vec<f32>,
}

impl DepthBuffer {
    fn new([width, height]: [usize; 2], ground: Vec3) -> Self {
        let canvas = Canvas::new(width, height, ground);
        Self { canvas, depth_m: vec![f32::INFINITY; width * height] }
    }

    fn splat(&mut self, centre: Vec2, radius: f32, depth_m: f32, colour: Vec3) {
        let (width, height) = (self.canvas.width(), self.canvas.height());
        let range = |middle: f32, size: usize| {
            let begin = (middle - radius).round().max(0.0) as usize;
            begin..((middle + radius).round().max(0.0) as usize).min(size)
        };
        for y in range(centre.y, height) {
            for x in range(centre.x, width) {
                let from = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - centre;
                let index = y * width + x;
                if from.length_squared() <= (radius + 0.25).powi(2) && depth_m < self.depth_m[index]
                {
                    self.depth_m[index] = depth_m;
                    self.canvas.pixels_mut()[index] = colour;
                }
            }
        }
    }

    /// Darkens what lies behind its neighbourhood.
    fn shaded(self) -> Canvas {
        let (width, height) = (self.canvas.width(), self.canvas.height());
        let mut canvas = self.canvas.clone();
        let log: Vec<f32> = self.depth_m.iter().map(|depth| depth.log2()).collect();
        let reach = SHADING_REACH * OVERSAMPLED;
        for (index, pixel) in canvas.pixels_mut().iter_mut().enumerate() {
            let (x, y) = (index % width, index / width);
            if log[index].is_infinite() {
                continue;
            }
            let closer = |(i, j): (usize, usize)| {
                let inside =
                    (reach..width + reach).contains(&i) && (reach..height + reach).contains(&j);
                let neighbour = inside.then(|| log[(j - reach) * width + i - reach]);
                neighbour.map_or(0.0, |neighbour| (log[index] - neighbour).max(0.0))
            };
            let around = [(0, reach), (2 * reach, reach), (reach, 0), (reach, 2 * reach)];
            let sum: f32 = around.iter().map(|(i, j)| closer((x + i, y + j))).sum();
            *pixel *= (-SHADING * sum / around.len() as f32).exp();
        }
        canvas
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOM: Bounds =
        Bounds { low: DVec3::new(-3.0, -2.0, 0.0), high: DVec3::new(3.0, 2.0, 2.5) };

    fn from_south() -> Direction {
        Direction { azimuth_rad: std::f64::consts::PI, elevation_rad: 0.0, view_rad: 1.0 }
    }

    fn dot(position_m: DVec3, colour: [u8; 3]) -> Dot {
        Dot { position_m, colour, seen_by: 1 }
    }

    #[test]
    fn from_the_south_east_is_right_and_up_is_up() {
        let eye = Eye::on(ROOM, from_south(), [300, 200]);
        let (middle, depth) = eye.project(ROOM.centre()).unwrap();
        assert!(middle.distance(Vec2::new(150.0, 100.0)) < 1e-3);
        let step = |direction: DVec3| eye.project(ROOM.centre() + direction).unwrap().0 - middle;
        let expected = eye.apparent(1.0, depth) as f32;
        assert!(step(DVec3::X).distance(Vec2::new(expected, 0.0)) < 1e-3);
        assert!(step(DVec3::Z).distance(Vec2::new(0.0, -expected)) < 1e-3);
        assert!(eye.project(eye.position + DVec3::NEG_Y).is_none(), "behind the eye");
    }

    #[test]
    fn the_whole_box_is_in_view_and_fills_it() {
        for (azimuth_rad, elevation_rad) in [(0.3, 0.9), (2.0, 0.5), (4.0, 1.3)] {
            let direction = Direction { azimuth_rad, elevation_rad, view_rad: 0.7 };
            let eye = Eye::on(ROOM, direction, [320, 200]);
            let seen: Vec<Vec2> =
                ROOM.corners().iter().map(|c| eye.project(*c).unwrap().0).collect();
            let off = |at: &Vec2| (at.x / 160.0 - 1.0).abs().max((at.y / 100.0 - 1.0).abs());
            let farthest = seen.iter().map(off).fold(0.0, f32::max);
            assert!((f64::from(farthest) - FILLED).abs() < 1e-3, "{farthest}");
        }
    }

    #[test]
    fn a_point_in_front_covers_one_behind_in_any_order() {
        let eye = Eye::on(ROOM, from_south(), [60, 40]);
        let near = dot(DVec3::new(0.0, -1.0, 1.25), [255, 0, 0]);
        let far = dot(DVec3::new(0.0, 1.0, 1.25), [0, 0, 255]);
        for order in [[near, far], [far, near]] {
            let canvas = draw(order.into_iter(), 0.5, &eye, Vec3::ZERO);
            assert_eq!(canvas.at(30, 20), linear([255, 0, 0]));
        }
    }

    #[test]
    fn shading_darkens_what_is_behind_an_edge_and_leaves_a_plane_alone() {
        let eye = Eye::on(ROOM, from_south(), [60, 40]);
        let wall = |y: f64| {
            let row = move |n: i32| {
                dot(
                    DVec3::new(f64::from(n % 61 - 30) / 10.0, y, f64::from(n / 61) / 10.0),
                    [200; 3],
                )
            };
            (0..61 * 25).map(row)
        };
        let plain = draw(wall(1.0), 0.2, &eye, Vec3::ZERO);
        assert!((plain.at(30, 20).x - linear([200; 3]).x).abs() < 1e-3);
        let post = (0..25).map(|n| dot(DVec3::new(0.0, -1.0, f64::from(n) / 10.0), [200; 3]));
        let folded = draw(wall(1.0).chain(post), 0.2, &eye, Vec3::ZERO);
        let darkest = (25..36).map(|x| folded.at(x, 20).x).fold(f32::INFINITY, f32::min);
        assert!(darkest < 0.5 * plain.at(30, 20).x, "{darkest}");
    }

    #[test]
    fn walls_between_the_eye_and_the_room_are_told_from_the_others() {
        let eye = Eye::on(ROOM, from_south(), [60, 40]);
        let inner = ROOM.grown(-0.2);
        assert!(eye.is_behind_wall(inner, DVec3::new(0.0, -2.0, 1.0)));
        assert!(!eye.is_behind_wall(inner, DVec3::new(0.0, 2.0, 1.0)));
    }
}
