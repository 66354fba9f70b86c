//! Colours of surfaces: a pattern, and light from above.

use lodestone_config::model::{self, Pattern};

/// Faces of a solid by the axis of their normal: −x, +x, −y, +y, −z, +z.
const FACES: usize = 6;
/// Shades of a pattern.
const SHADES: usize = 4;
/// Light on each face: from above, and unlike on neighbouring sides, so that edges show.
const LIGHT: [f64; FACES] = [0.74, 0.80, 0.90, 0.86, 0.55, 1.0];
/// Shades of boards, and of squares by turns.
const BOARDS: [f64; SHADES] = [1.0, 0.90, 0.95, 0.84];
const SQUARES: [f64; SHADES] = [1.0, 0.82, 1.0, 0.82];

/// Red, green, blue, opacity.
pub(super) type Colour = [u8; 4];

/// The colours of every face, worked out beforehand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Palette {
    faces: [Face; FACES],
    /// Squares or boards per metre.
    per_m: f32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Face {
    pattern: Pattern,
    shades: [Colour; SHADES],
}

impl Palette {
    /// All faces alike, but for the light.
    pub(super) fn new(colour: [f64; 3], pattern: Pattern, pattern_m: f64) -> Self {
        let faces = LIGHT.map(|light| Face::new(colour, pattern, light));
        Self { faces, per_m: pattern_m.recip() as f32 }
    }

    /// Walls, floor and ceiling of a room, whose light is seen from inside.
    pub(super) fn of_room(room: &model::Room) -> Self {
        let wall = |light| Face::new(room.wall_colour, room.wall_pattern, light);
        let [west, east, south, north, ..] = LIGHT;
        let floor = Face::new(room.floor_colour, room.floor_pattern, 1.0);
        let ceiling = Face::new(room.ceiling_colour, Pattern::Plain, 1.0);
        let faces = [wall(west), wall(east), wall(south), wall(north), floor, ceiling];
        Self { faces, per_m: room.pattern_m.recip() as f32 }
    }

    /// The colour at a place on a face, along its two axes, m.
    pub(super) fn colour(&self, face: usize, along: f32, across: f32) -> Colour {
        let face = &self.faces[face];
        // Patterns are whole numbers of squares from the centre; floor without a call to libm.
        let index = |v: f32| (v * self.per_m + 16_384.0) as u32;
        let shade = match face.pattern {
            Pattern::Plain => 0,
            Pattern::Checks => (index(along) + index(across)) & 1,
            // Neighbouring boards differ, and the order is not seen.
            Pattern::Planks => index(across).wrapping_mul(0x9E37_79B1) >> 30,
        };
        face.shades[shade as usize]
    }
}

impl Face {
    fn new(colour: [f64; 3], pattern: Pattern, light: f64) -> Self {
        let shades = match pattern {
            Pattern::Planks => BOARDS,
            Pattern::Plain | Pattern::Checks => SQUARES,
        };
        let shade = |scale: f64| {
            let [r, g, b] = colour.map(|c| (c * light * scale).round() as u8);
            [r, g, b, u8::MAX]
        };
        Self { pattern, shades: shades.map(shade) }
    }
}
