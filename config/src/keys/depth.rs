//! Every key of a synthetic depth source.

use super::Kind::{Number, Whole};
use super::range::{above_zero_to, from_to};
use super::{Key, key};

pub(super) const DEPTH: &[Key] = &[
    key("width", Whole(16, 4096), "points", "Points in a row."),
    key("height", Whole(16, 4096), "rows", "Rows."),
    key(
        "rate_hz",
        Number(from_to(0.1, 120.0)),
        "Hz",
        "Clouds per second. Large: processor time, about 4 ms for each cloud of 100,000 points.",
    ),
    key(
        "field_of_view_deg",
        Number(from_to(10.0, 150.0)),
        "°",
        "Horizontal field of view; pixels are square. A ZED 2 has up to 110°, without distortion 90°.",
    ),
    key(
        "sigma_per_m",
        Number(from_to(0.0, 0.1)),
        "1/m",
        "Standard deviation of depth over its square, which for stereo is that of the disparity over \
         focal length and baseline. 0.0032, as of a ZED 2: 29 mm at 3 m.",
    ),
    key("min_m", Number(from_to(0.0, 100.0)), "m", "Least depth; what is nearer has none."),
    key("max_m", Number(above_zero_to(1000.0)), "m", "Greatest depth; what is farther has none."),
    key(
        "rolling_shutter_s",
        Number(from_to(0.0, 0.2)),
        "s",
        "Time from the first row to the last. 0: all points at once, and without times of their own.",
    ),
    key(
        "drop_probability",
        Number(from_to(0.0, 1.0)),
        "",
        "Probability that a point has no depth, for want of anything to match.",
    ),
    key(
        "grazing_deg",
        Number(from_to(0.0, 45.0)),
        "°",
        "Least angle between ray and surface at which there is depth.",
    ),
    key("seed", Whole(0, i64::MAX), "", "Seed of noise and of points without depth."),
];
