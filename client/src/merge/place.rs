//! A cloud's points in the world, each by the pose at its own time.

use glam::{DVec3, Vec3};
use lodestone_schema::{CloudFrame, CloudPoint};

use crate::cloud::{CloudInfo, MOST_OFFSET_NS, Motion};
use crate::pose::CameraPose;

/// How far from the sensor a point may be, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Nearer points are dropped; default 0.1 m, where some sources put what has no depth.
    pub min_m: f32,
    /// Farther points are dropped; default 40 m, twice of what a ZED 2 is made for.
    pub max_m: f32,
}

impl Default for Range {
    fn default() -> Self {
        Self { min_m: 0.1, max_m: 40.0 }
    }
}

/// A point in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedPoint {
    /// In the world's axes, from the cloud's origin, m.
    pub offset_m: [f32; 3],
    /// Red, green, blue, opacity.
    pub colour: [u8; 4],
}

/// What became of a cloud's points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PointCounts {
    /// Placed in the world.
    pub placed: u64,
    /// Without depth: a coordinate that is not finite.
    pub without_depth: u64,
    /// Too near or too far.
    pub out_of_range: u64,
    /// Whose time is too far from the cloud's.
    pub out_of_time: u64,
}

impl PointCounts {
    /// Adds those of another cloud.
    pub(super) const fn add(&mut self, other: Self) {
        self.placed += other.placed;
        self.without_depth += other.without_depth;
        self.out_of_range += other.out_of_range;
        self.out_of_time += other.out_of_time;
    }
}

/// A cloud in the world, ready to be looked at, corrected and inserted.
#[derive(Clone, Debug)]
pub struct PlacedCloud {
    camera: usize,
    info: CloudInfo,
    motion: Motion,
    points: Vec<PlacedPoint>,
    counts: PointCounts,
}

impl PlacedCloud {
    /// Places a cloud's points by a sensor's motion, with the buffer of an earlier one.
    ///
    /// ```
    /// use lodestone_client::{CloudHeader, CloudInfo, CloudPoint};
    /// // A header comes with as many points as it says.
    /// let header = CloudHeader { width: 1, time_ns: 5, ..CloudHeader::default() };
    /// assert!(CloudInfo::check(&header, [CloudPoint::default()].len()).is_ok());
    /// ```
    pub fn place(
        camera: usize,
        (info, cloud): (&CloudInfo, &[CloudPoint]),
        motion: Motion,
        range: Range,
        mut buffer: Vec<PlacedPoint>,
    ) -> Self {
        buffer.clear();
        buffer.reserve(cloud.len());
        let mut counts = PointCounts::default();
        if info.has_point_time() {
            let mut last = (0, motion.at(0));
            place_all(cloud, range, &mut buffer, &mut counts, |point, offset_ns| {
                // Points of one row mostly have one time.
                if last.0 != offset_ns {
                    last = (offset_ns, motion.at(offset_ns));
                }
                (i64::from(offset_ns).abs() <= MOST_OFFSET_NS).then(|| last.1.apply(point))
            });
        } else {
            let still = motion.at(0);
            place_all(cloud, range, &mut buffer, &mut counts, |point, _| Some(still.apply(point)));
        }
        counts.placed = buffer.len() as u64;
        Self { camera, info: *info, motion, points: buffer, counts }
    }

    /// Index of the camera in the merger.
    pub const fn camera(&self) -> usize {
        self.camera
    }

    /// What is true of the whole cloud.
    pub const fn info(&self) -> &CloudInfo {
        &self.info
    }

    /// The camera's pose at the cloud's time.
    pub const fn pose(&self) -> &CameraPose {
        self.motion.pose()
    }

    /// Where the sensor was at the cloud's time, in the world, m; the points count from here.
    pub const fn origin_m(&self) -> DVec3 {
        self.motion.origin_m()
    }

    /// The points that have a place, in the order of the cloud.
    pub fn points(&self) -> &[PlacedPoint] {
        &self.points
    }

    /// The points' places in the world, m.
    pub fn positions_m(&self) -> impl ExactSizeIterator<Item = DVec3> {
        let origin_m = self.origin_m();
        self.points.iter().map(move |p| origin_m + Vec3::from_array(p.offset_m).as_dvec3())
    }

    /// Which way the sensor looked at the cloud's time, in the world's axes.
    pub fn axis(&self) -> DVec3 {
        let axis = match self.info.frame() {
            CloudFrame::Optical => Vec3::Z,
            CloudFrame::Body => Vec3::X,
        };
        self.motion.at(0).turn(axis).as_dvec3()
    }

    /// The same cloud with so many of its points at most, evenly out of all.
    #[must_use]
    pub fn thinned(&self, points: usize) -> Self {
        let step = self.points.len().div_ceil(points.max(1)).max(1);
        let points = self.points.iter().step_by(step).copied().collect();
        Self { points, motion: self.motion.clone(), ..*self }
    }

    /// What became of the cloud's points.
    pub const fn counts(&self) -> PointCounts {
        self.counts
    }

    /// The points, whose memory may serve the next cloud.
    pub fn into_points(self) -> Vec<PlacedPoint> {
        self.points
    }
}

fn place_all(
    cloud: &[CloudPoint],
    range: Range,
    placed: &mut Vec<PlacedPoint>,
    counts: &mut PointCounts,
    mut to_world: impl FnMut(Vec3, i32) -> Option<Vec3>,
) {
    let (least, most) = (range.min_m * range.min_m, range.max_m * range.max_m);
    for point in cloud {
        let position = Vec3::from_array(point.position_m);
        let square = position.length_squared();
        if !(square >= least && square <= most) {
            // A finite point so far out that its square is not is out of range all the same.
            let count = if position.is_finite() {
                &mut counts.out_of_range
            } else {
                &mut counts.without_depth
            };
            *count += 1;
            continue;
        }
        match to_world(position, point.time_offset_ns) {
            Some(offset) => {
                placed.push(PlacedPoint { offset_m: offset.to_array(), colour: point.colour });
            }
            None => counts.out_of_time += 1,
        }
    }
}

/// First and last offset of a cloud's points from its time, ns, its own time included; what is further off
/// than [`MOST_OFFSET_NS`] is left out.
pub(super) fn span_ns(info: &CloudInfo, cloud: &[CloudPoint]) -> (i64, i64) {
    if !info.has_point_time() {
        return (0, 0);
    }
    let most = MOST_OFFSET_NS as i32;
    let (first, last) = cloud.iter().fold((0, 0), |(first, last), point| {
        let offset = point.time_offset_ns;
        let offset = if (-most..=most).contains(&offset) { offset } else { 0 };
        (offset.min(first), offset.max(last))
    });
    (i64::from(first), i64::from(last))
}

#[cfg(test)]
mod tests;
