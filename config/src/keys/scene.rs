//! Every key of the scene.

use super::Kind::{Choice, Number, Switch, Vector};
use super::range::{Range, above_zero_to, from_to, plus_minus};
use super::{Key, key};

/// Far from where single precision would show.
const PLACE: Range = plus_minus(1e4);
const SIZE: Range = above_zero_to(1000.0);
const COLOUR: Range = from_to(0.0, 255.0);
const PATTERNS: &[&str] = &["plain", "checks", "planks"];

const CENTRE: Key = key("centre_m", Vector(PLACE), "m", "Its centre.");
const SIDES: Key = key(
    "size_m",
    Vector(SIZE),
    "m",
    "Length, width and height: east, north and up while heading_deg is 0.",
);
const HEADING: Key = key(
    "heading_deg",
    Number(plus_minus(360.0)),
    "°",
    "How far it is turned, clockwise seen from above.",
);
const PAINT: Key = key("colour", Vector(COLOUR), "", "Red, green, blue.");
const PATTERN: Key = key(
    "pattern",
    Choice(PATTERNS),
    "",
    "How it is painted: in one colour, in squares, in boards of different shades.",
);
const PATTERN_SIZE: Key =
    key("pattern_m", Number(above_zero_to(100.0)), "m", "Width of the squares or boards.");

pub(super) const ROOM: &[Key] = &[
    CENTRE,
    SIDES,
    HEADING,
    key("floor", Switch, "", "Whether there is a floor; without it a ray downward has no depth."),
    key("ceiling", Switch, "", "Whether there is a ceiling."),
    key("wall_colour", Vector(COLOUR), "", "Red, green, blue of the walls."),
    key("wall_pattern", Choice(PATTERNS), "", "How the walls are painted."),
    key("floor_colour", Vector(COLOUR), "", "Red, green, blue of the floor."),
    key("floor_pattern", Choice(PATTERNS), "", "How the floor is laid."),
    key("ceiling_colour", Vector(COLOUR), "", "Red, green, blue of the ceiling."),
    PATTERN_SIZE,
];

pub(super) const BOX: &[Key] =
    &[CENTRE.required(), SIDES.required(), HEADING, PAINT, PATTERN, PATTERN_SIZE];

pub(super) const CYLINDER: &[Key] = &[
    CENTRE.required(),
    key("radius_m", Number(SIZE), "m", "Its radius.").required(),
    key("height_m", Number(SIZE), "m", "Its height.").required(),
    PAINT,
    PATTERN,
    PATTERN_SIZE,
];

pub(super) const MOVER: &[Key] = &[
    key("shape", Choice(&["cube", "ball"]), "", "A cube that does not turn, or a ball."),
    key("size_m", Number(SIZE), "m", "Side of the cube or diameter of the ball."),
    key("centre_m", Vector(PLACE), "m", "Centre of its way.").required(),
    key(
        "reach_east_m",
        Number(from_to(0.0, 1000.0)),
        "m",
        "Half the way's length from east to west.",
    ),
    key(
        "reach_north_m",
        Number(from_to(0.0, 1000.0)),
        "m",
        "Half the way's length from north to south.",
    ),
    key(
        "period_s",
        Number(from_to(0.1, 86_400.0)),
        "s",
        "Time of one round. Small: points of a rolling shutter show it sheared.",
    ),
    PAINT,
    PATTERN,
    PATTERN_SIZE,
];
