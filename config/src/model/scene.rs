//! What synthetic cameras see: a room with furniture and something that moves.

use serde::{Deserialize, Serialize};

/// The scene around synthetic cameras, in the world (x east, y north, z up), whose origin is where the
/// first camera begins.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Scene {
    /// The room.
    pub room: Room,
    /// Furniture with flat sides.
    #[serde(rename = "box")]
    pub boxes: Vec<SceneBox>,
    /// Round furniture and columns.
    pub cylinder: Vec<Cylinder>,
    /// What moves.
    pub mover: Option<SceneMover>,
}

/// How a surface is painted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Pattern {
    /// One colour.
    #[default]
    Plain,
    /// Squares, lighter and darker by turns.
    Checks,
    /// Boards side by side, each of a shade of its own.
    Planks,
}

/// A box that is seen from inside.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Room {
    /// Its centre, m.
    pub centre_m: [f64; 3],
    /// Its inner length, width and height, m; east, north, up while the heading is 0.
    pub size_m: [f64; 3],
    /// How far it is turned, clockwise seen from above, degrees.
    pub heading_deg: f64,
    /// Whether there is a floor.
    pub floor: bool,
    /// Whether there is a ceiling.
    pub ceiling: bool,
    /// Red, green, blue, 0 to 255.
    pub wall_colour: [f64; 3],
    /// How the walls are painted.
    pub wall_pattern: Pattern,
    /// Red, green, blue, 0 to 255.
    pub floor_colour: [f64; 3],
    /// How the floor is laid.
    pub floor_pattern: Pattern,
    /// Red, green, blue, 0 to 255.
    pub ceiling_colour: [f64; 3],
    /// Width of the squares or boards, m.
    pub pattern_m: f64,
}

impl Default for Room {
    /// 6 by 5 by 2.6 m, around a camera that is held 1.2 m above the floor.
    fn default() -> Self {
        Self {
            centre_m: [0.0, 0.0, 0.1],
            size_m: [6.0, 5.0, 2.6],
            heading_deg: 0.0,
            floor: true,
            ceiling: true,
            wall_colour: [226.0, 220.0, 205.0],
            wall_pattern: Pattern::Checks,
            floor_colour: [164.0, 120.0, 78.0],
            floor_pattern: Pattern::Planks,
            ceiling_colour: [240.0, 240.0, 240.0],
            pattern_m: 0.5,
        }
    }
}

/// A box: a table top, a shelf, a cupboard.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SceneBox {
    /// Its centre, m.
    pub centre_m: [f64; 3],
    /// Its length, width and height, m; east, north, up while the heading is 0.
    pub size_m: [f64; 3],
    /// How far it is turned, clockwise seen from above, degrees.
    pub heading_deg: f64,
    /// Red, green, blue, 0 to 255.
    pub colour: [f64; 3],
    /// How it is painted.
    pub pattern: Pattern,
    /// Width of the squares or boards, m.
    pub pattern_m: f64,
}

impl Default for SceneBox {
    /// Wood; place and size have no default.
    fn default() -> Self {
        Self {
            centre_m: [0.0; 3],
            size_m: [0.0; 3],
            heading_deg: 0.0,
            colour: WOOD,
            pattern: Pattern::Plain,
            pattern_m: PATTERN_M,
        }
    }
}

/// An upright cylinder: a column, a bin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Cylinder {
    /// Its centre, m.
    pub centre_m: [f64; 3],
    /// Its radius, m.
    pub radius_m: f64,
    /// Its height, m.
    pub height_m: f64,
    /// Red, green, blue, 0 to 255.
    pub colour: [f64; 3],
    /// How it is painted.
    pub pattern: Pattern,
    /// Width of the squares or boards, m.
    pub pattern_m: f64,
}

impl Default for Cylinder {
    /// Wood; place and size have no default.
    fn default() -> Self {
        Self {
            centre_m: [0.0; 3],
            radius_m: 0.0,
            height_m: 0.0,
            colour: WOOD,
            pattern: Pattern::Plain,
            pattern_m: PATTERN_M,
        }
    }
}

/// The shape of what moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MoverShape {
    /// A cube that does not turn.
    #[default]
    Cube,
    /// A ball.
    Ball,
}

/// Something that moves round an ellipse, on and on.
///
/// Its place is a function of `CLOCK_MONOTONIC` alone, so that processes agree on it without a word.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SceneMover {
    /// What it is.
    pub shape: MoverShape,
    /// Side of the cube or diameter of the ball, m.
    pub size_m: f64,
    /// Centre of its way, m.
    pub centre_m: [f64; 3],
    /// How far its way reaches to the east and to the west, m.
    pub reach_east_m: f64,
    /// How far its way reaches to the north and to the south, m.
    pub reach_north_m: f64,
    /// Time of one round, s.
    pub period_s: f64,
    /// Red, green, blue, 0 to 255.
    pub colour: [f64; 3],
    /// How it is painted.
    pub pattern: Pattern,
    /// Width of the squares or boards, m.
    pub pattern_m: f64,
}

impl Default for SceneMover {
    /// Half a metre large, round a circle of a metre in 12 s, at walking pace; where has no default.
    fn default() -> Self {
        Self {
            shape: MoverShape::Cube,
            size_m: 0.5,
            centre_m: [0.0; 3],
            reach_east_m: 1.0,
            reach_north_m: 1.0,
            period_s: 12.0,
            colour: [200.0, 60.0, 50.0],
            pattern: Pattern::Checks,
            pattern_m: PATTERN_M,
        }
    }
}

const WOOD: [f64; 3] = [150.0, 105.0, 65.0];
const PATTERN_M: f64 = 0.25;
