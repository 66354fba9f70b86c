//! The line below all arrivals.

/// Intervals of sensor time of which the least delayed sample is kept.
const BUCKETS: usize = 64;

/// Width of a bucket at first, ns: so narrow that the drift is known after a tenth of a second.
const FIRST_WIDTH_NS: f64 = 20e6;

/// Width at which buckets stop growing, ns; 64 of them remember 20 s.
const LAST_WIDTH_NS: f64 = 320e6;

/// Least number of points that say something about the drift.
const LEAST_POINTS: usize = 4;

/// A line through a point, ns over ns.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Line {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) slope: f64,
}

impl Line {
    pub(super) fn at(self, x: f64) -> f64 {
        self.y + self.slope * (x - self.x)
    }

    /// Lowers the line so that it is not above a point.
    pub(super) fn lower_to(&mut self, x: f64, y: f64) {
        self.y -= (self.at(x) - y).max(0.0);
    }
}

/// The least delayed sample of a bucket.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Point {
    /// Sensor time, ns.
    x: f64,
    /// Arrival against the nominal rate, ns.
    y: f64,
}

/// Keeps the least delayed sample of each of the last intervals of sensor time.
///
/// Buckets begin narrow. When all are in use, neighbours are merged and the width doubles, until
/// it is at its last; from then on the oldest is forgotten.
#[derive(Clone, Debug)]
pub(super) struct Envelope {
    closed: [Point; BUCKETS],
    count: usize,
    /// The bucket that is being filled, its point and the end of its interval.
    open: Option<(Point, f64)>,
    width_ns: f64,
}

impl Default for Envelope {
    fn default() -> Self {
        Self { closed: [Point::default(); BUCKETS], count: 0, open: None, width_ns: FIRST_WIDTH_NS }
    }
}

impl Envelope {
    /// Closed buckets, oldest first.
    fn points(&self) -> &[Point] {
        &self.closed[..self.count]
    }

    /// Takes a sample not older than those before; the best line whenever a bucket is full.
    ///
    /// Which of a bucket's samples has the least delay is judged against `guess`.
    pub(super) fn add(&mut self, x: f64, y: f64, guess: Line) -> Option<Line> {
        let sample = Point { x, y };
        match &mut self.open {
            Some((best, end)) if x < *end => {
                *best = less_delayed(*best, sample, guess);
                return None;
            }
            open => {
                let full = open.replace((sample, x + self.width_ns));
                self.close(full?.0, guess);
            }
        }
        (self.count >= LEAST_POINTS).then(|| self.line())
    }

    fn close(&mut self, point: Point, guess: Line) {
        if self.count == BUCKETS {
            self.make_room(guess);
        }
        self.closed[self.count] = point;
        self.count += 1;
    }

    fn make_room(&mut self, guess: Line) {
        if self.width_ns >= LAST_WIDTH_NS {
            self.closed.copy_within(1.., 0);
            self.count -= 1;
            return;
        }
        for pair in 0..BUCKETS / 2 {
            self.closed[pair] =
                less_delayed(self.closed[2 * pair], self.closed[2 * pair + 1], guess);
        }
        self.count = BUCKETS / 2;
        self.width_ns *= 2.0;
    }

    /// The highest line of a given slope that is below all points.
    pub(super) fn line_of_slope(&self, slope: f64) -> Line {
        let offset = |p: &Point| p.y - slope * p.x;
        let y = self.points().iter().map(offset).fold(f64::INFINITY, f64::min);
        Line { x: 0.0, y, slope }
    }

    /// The line below all points with the least sum of distances: it carries the edge of their
    /// lower convex hull that spans the mean of x (Moon, Skelly and Towsley 1999, section IV).
    fn line(&self) -> Line {
        let points = self.points();
        let mean = points.iter().map(|p| p.x).sum::<f64>() / points.len() as f64;
        let mut hull = [Point::default(); BUCKETS];
        let mut corners = 0;
        for &point in points {
            while corners >= 2 && !turns_left(hull[corners - 2], hull[corners - 1], point) {
                corners -= 1;
            }
            hull[corners] = point;
            corners += 1;
        }
        let hull = &hull[..corners];
        let right = hull.iter().position(|p| p.x >= mean).unwrap_or(corners - 1).max(1);
        let (a, b) = (hull[right - 1], hull[right]);
        Line { x: b.x, y: b.y, slope: (b.y - a.y) / (b.x - a.x) }
    }
}

fn less_delayed(a: Point, b: Point, guess: Line) -> Point {
    if b.y - guess.at(b.x) < a.y - guess.at(a.x) { b } else { a }
}

fn turns_left(a: Point, b: Point, c: Point) -> bool {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) > 0.0
}
