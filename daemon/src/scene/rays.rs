//! Rays against the scene, some at a time, so that the compiler can work on them side by side.

use glam::Vec3;

use super::paint::Colour;
use super::view::{Kind, SeenSolid, View};

/// Rays in a packet: four registers of four.
pub(super) const LANES: usize = 16;

/// Directions in the room frame, scaled so that a ray's parameter is the depth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Packet {
    x: [f32; LANES],
    y: [f32; LANES],
    z: [f32; LANES],
}

/// What each ray of a packet meets first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hits {
    /// Depth, m.
    pub(super) depth_m: [f32; LANES],
    /// Index of the solid, or [`ROOM`].
    solid: [u32; LANES],
}

const ROOM: u32 = u32::MAX;

/// What is seen where a ray ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) colour: Colour,
    /// The ray's direction along the surface's normal; its sign means nothing.
    pub(super) along_normal: f32,
    /// Whether there is a surface: a room may have no ceiling.
    pub(super) is_there: bool,
}

impl Packet {
    /// The rays of a row, `row` down and `across` to the right for each metre of depth.
    pub(super) fn new(view: &View<'_>, across: &[f32; LANES], row: f32) -> Self {
        let axes = &view.room_from_optical;
        let (right, base) = (axes.x_axis, axes.y_axis * row + axes.z_axis);
        Self {
            x: across.map(|u| right.x * u + base.x),
            y: across.map(|u| right.y * u + base.y),
            z: across.map(|u| right.z * u + base.z),
        }
    }

    fn direction(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    /// Casts the rays against the room and those solids that may be in their way.
    pub(super) fn cast(&self, view: &View<'_>, candidates: &[u32]) -> Hits {
        let mut hits = self.leave_room(view);
        for &index in candidates {
            let seen = &view.solids[index as usize];
            match seen.kind {
                Kind::Box { half_m } => self.meet_box(seen, half_m, index, &mut hits),
                Kind::Cylinder { radius_m, half_height_m } => {
                    self.meet_cylinder(seen, (radius_m, half_height_m), index, &mut hits);
                }
                Kind::Ball { radius_m } => self.meet_ball(seen, radius_m, index, &mut hits),
            }
        }
        hits
    }

    /// Where rays that begin inside leave the room.
    fn leave_room(&self, view: &View<'_>) -> Hits {
        let (half, origin) = (view.half_m, view.origin_m);
        let mut depth_m = [0.0; LANES];
        for (lane, depth) in depth_m.iter_mut().enumerate() {
            let leave = |half: f32, origin: f32, d: f32| (half.copysign(d) - origin) / d;
            let x = leave(half.x, origin.x, self.x[lane]);
            let y = leave(half.y, origin.y, self.y[lane]);
            *depth = min(min(x, y), leave(half.z, origin.z, self.z[lane]));
        }
        Hits { depth_m, solid: [ROOM; LANES] }
    }

    /// The slab method (Kay and Kajiya, SIGGRAPH 1986), about the box's middle.
    fn meet_box(&self, seen: &SeenSolid, half: Vec3, index: u32, hits: &mut Hits) {
        let ((cos, sin), o) = (seen.turn, seen.origin_m);
        for lane in 0..LANES {
            let (x, y) = (self.x[lane], self.y[lane]);
            let (x, y) = (cos * x - sin * y, sin * x + cos * y);
            let (x, y, z) = (inverse(x), inverse(y), inverse(self.z[lane]));
            let (mid_x, span_x) = (-o.x * x, half.x * x.abs());
            let (mid_y, span_y) = (-o.y * y, half.y * y.abs());
            let (mid_z, span_z) = (-o.z * z, half.z * z.abs());
            let near = max(max(mid_x - span_x, mid_y - span_y), mid_z - span_z);
            let far = min(min(mid_x + span_x, mid_y + span_y), mid_z + span_z);
            hits.take(lane, near, far, index);
        }
    }

    /// The stretch inside the endless cylinder, cut by the slab between its ends.
    fn meet_cylinder(
        &self,
        seen: &SeenSolid,
        (radius, half_height): (f32, f32),
        index: u32,
        hits: &mut Hits,
    ) {
        let o = seen.origin_m;
        for lane in 0..LANES {
            let (x, y, z) = (self.x[lane], self.y[lane], inverse(self.z[lane]));
            // Upright rays stay in it for ever, which this makes a very long way.
            let a = max(x * x + y * y, 1e-12);
            let b = o.x * x + o.y * y;
            let c = o.x * o.x + o.y * o.y - radius * radius;
            let root = (b * b - a * c).sqrt();
            let (mid_z, span_z) = (-o.z * z, half_height * z.abs());
            let near = max((-b - root) / a, mid_z - span_z);
            let far = min((root - b) / a, mid_z + span_z);
            // A ray that passes by has a root that is not a number.
            hits.take(lane, near, if root >= 0.0 { far } else { f32::NEG_INFINITY }, index);
        }
    }

    fn meet_ball(&self, seen: &SeenSolid, radius: f32, index: u32, hits: &mut Hits) {
        let ((cos, sin), o) = (seen.turn, seen.origin_m);
        let c = o.length_squared() - radius * radius;
        for lane in 0..LANES {
            let (x, y, z) = (self.x[lane], self.y[lane], self.z[lane]);
            let (x, y) = (cos * x - sin * y, sin * x + cos * y);
            let a = x * x + y * y + z * z;
            let b = o.x * x + o.y * y + o.z * z;
            let root = (b * b - a * c).sqrt();
            let far = if root >= 0.0 { (root - b) / a } else { f32::NEG_INFINITY };
            hits.take(lane, (-b - root) / a, far, index);
        }
    }

    /// What a ray sees where it ends.
    pub(super) fn look(&self, view: &View<'_>, hits: &Hits, lane: usize) -> Seen {
        let (direction, depth) = (self.direction(lane), hits.depth_m[lane]);
        let index = hits.solid[lane];
        if index == ROOM {
            return look_at_room(view, direction, depth);
        }
        let seen = &view.solids[index as usize];
        let direction = seen.local(direction);
        let place = seen.origin_m + direction * depth;
        let (face, along_normal) = match seen.kind {
            Kind::Box { half_m } => {
                let axis = nearest_face(place, half_m);
                (face(axis, place), direction[axis])
            }
            Kind::Cylinder { radius_m, half_height_m } => {
                on_cylinder(place, direction, radius_m, half_height_m)
            }
            Kind::Ball { radius_m } => {
                (face(nearest_face(place, Vec3::ZERO), place), place.dot(direction) / radius_m)
            }
        };
        let (along, across) = on_face(face, place);
        let colour = seen.solid.palette.colour(face, along, across);
        Seen { colour, along_normal, is_there: true }
    }
}

impl Hits {
    /// Takes a stretch inside a solid if it begins ahead of the eye and before what was met so far.
    #[allow(clippy::needless_bitwise_bool, reason = "lanes side by side have no branches")]
    fn take(&mut self, lane: usize, near: f32, far: f32, index: u32) {
        let is_first = (near <= far) & (near > 0.0) & (near < self.depth_m[lane]);
        self.depth_m[lane] = if is_first { near } else { self.depth_m[lane] };
        self.solid[lane] = if is_first { index } else { self.solid[lane] };
    }
}

fn look_at_room(view: &View<'_>, direction: Vec3, depth: f32) -> Seen {
    let place = view.origin_m + direction * depth;
    let axis = nearest_face(place, view.half_m);
    let face = face(axis, place);
    let is_there = match face {
        4 => view.room.floor,
        5 => view.room.ceiling,
        _ => true,
    };
    let (along, across) = on_face(face, place);
    let colour = view.room.palette.colour(face, along, across);
    Seen { colour, along_normal: direction[axis], is_there }
}

/// The axis along which a place is farthest out.
fn nearest_face(place: Vec3, half: Vec3) -> usize {
    let beyond = place.abs() - half;
    if beyond.x > beyond.y && beyond.x > beyond.z {
        0
    } else if beyond.y > beyond.z {
        1
    } else {
        2
    }
}

fn face(axis: usize, place: Vec3) -> usize {
    2 * axis + usize::from(place[axis] > 0.0)
}

fn on_cylinder(place: Vec3, direction: Vec3, radius: f32, half_height: f32) -> (usize, f32) {
    let across = place.truncate();
    if place.z.abs() - half_height > across.length() - radius {
        return (face(2, place), direction.z);
    }
    let axis = usize::from(place.y.abs() > place.x.abs());
    (face(axis, place), across.dot(direction.truncate()) / radius)
}

/// Coordinates of a place on a face.
fn on_face(face: usize, place: Vec3) -> (f32, f32) {
    match face / 2 {
        0 => (place.y, place.z),
        1 => (place.x, place.z),
        _ => (place.x, place.y),
    }
}

/// The inverse of a direction's part; of one along a face, a number so large that it still counts.
fn inverse(part: f32) -> f32 {
    max(part.abs(), 1e-20).copysign(part).recip()
}

/// As the processor has it, without the care for what is not a number.
fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// As [`min`].
fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
