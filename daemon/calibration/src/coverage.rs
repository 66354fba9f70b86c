//! Which movements were seen: cheap enough for every sample.

/// The movement of a recording so far. Independent of the fit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coverage {
    /// Usable samples, s.
    pub duration_s: f64,
    /// Part of the full circle of headings seen, degrees, 0 to 360.
    pub circle_deg: f64,
    /// Turns about the vertical, left and right alike, in whole turns.
    pub turns: f64,
    /// Tilt from the mean direction, root mean square, degrees.
    pub tilt_deg: f64,
    /// Longest rest, s.
    pub rest_s: f64,
    /// Readings of the magnetometer.
    pub mag_readings: usize,
}
