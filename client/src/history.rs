//! The last poses of one camera, and what was between them.

use std::collections::VecDeque;

use core::time::Duration;
use lodestone_schema::Validity;

use crate::error::LookupError;
use crate::interpolate::between;
use crate::limits::LookupLimits;
use crate::pose::CameraPose;
use crate::predict::predict;
use crate::time::Time;

/// Orientation at a known time: the least that makes a pose worth having.
const LEAST: Validity = Validity::TILT.union(Validity::TIME);

/// A fixed number of poses, newest last, and lookups among them.
///
/// Poses of different runs or on different sides of a re-initialisation do not share a history: a
/// lookup sees only what came since the last such break. A [`crate::PoseStream`] keeps one of
/// these; it also stands alone, for poses read from a recording:
///
/// ```
/// use lodestone_client::{CameraPose, History, LookupError, LookupLimits, Time};
/// # use lodestone_client::{Pose, Validity};
/// # fn pose(time_ns: i64, x: f64) -> CameraPose {
/// #     let valid = Validity::TILT | Validity::HEADING | Validity::POSITION | Validity::TIME;
/// #     let pose = Pose {
/// #         sequence: (time_ns / 1_000_000) as u64, camera_id: 0, reset_counter: 0, status: 1,
/// #         validity: valid.bits(), heading_source: 1, position_source: 5, aids_used: 0, aids_refused: 0,
/// #         world_epoch: 1,
/// #         sensor_time_ns: time_ns, time_ns, arrival_time_ns: time_ns,
/// #         ring_time_ns: time_ns, step_start_time_ns: time_ns, step_end_time_ns: time_ns, published_time_ns: time_ns,
/// #         unix_offset_ns: 0, position_m: [x, 0.0, 0.0], velocity_m_s: [f64::NAN; 3],
/// #         orientation: [0.0, 0.0, 0.0, 1.0], angular_rate_rad_s: [f64::NAN; 3],
/// #         specific_force_m_s2: [f64::NAN; 3], position_covariance_m2: [0.0; 6],
/// #         velocity_covariance_m2_s2: [f64::NAN; 6], orientation_covariance_rad2: [0.0; 6],
/// #     };
/// #     CameraPose::try_from(pose).unwrap()
/// # }
/// let mut history = History::new(1000, LookupLimits::default());
/// // Two poses 10 ms apart; the camera moves 4 cm to the east between them.
/// history.push(pose(1_000_000_000, 2.00));
/// history.push(pose(1_010_000_000, 2.04));
///
/// let between = history.lookup(Time::Monotonic(1_005_000_000))?;
/// assert_eq!(between.position_m().unwrap().x, 2.02);
/// let before = history.lookup(Time::Monotonic(999_000_000));
/// assert!(matches!(before, Err(LookupError::TooOld { oldest_ns: 1_000_000_000, .. })));
/// # Ok::<(), LookupError>(())
/// ```
#[derive(Clone, Debug)]
pub struct History {
    poses: VecDeque<CameraPose>,
    capacity: usize,
    /// How many poses were ever taken; the newest has this number minus one.
    taken: u64,
    /// Number of the first pose since the last break.
    start: u64,
    limits: LookupLimits,
}

impl History {
    /// An empty history for so many poses (at least 2); it never grows beyond.
    pub fn new(capacity: usize, limits: LookupLimits) -> Self {
        let capacity = capacity.max(2);
        Self { poses: VecDeque::with_capacity(capacity), capacity, taken: 0, start: 0, limits }
    }

    /// Takes the next pose; the oldest makes room.
    ///
    /// A pose whose sequence or time runs back, or whose reset counter or world differs, begins a
    /// new history. A pose with the very time of the newest one replaces nothing and counts as newer.
    pub fn push(&mut self, pose: CameraPose) {
        let continues = self.newest().is_none_or(|newest| {
            pose.sequence() > newest.sequence()
                && pose.time_ns() >= newest.time_ns()
                && pose.reset_counter() == newest.reset_counter()
                && pose.world_epoch() == newest.world_epoch()
        });
        if !continues {
            self.break_off();
        }
        if self.poses.len() == self.capacity {
            self.poses.pop_front();
        }
        self.poses.push_back(pose);
        self.taken += 1;
    }

    /// Brings the place of the next pose into this core's cache, while there is time. A history is larger than
    /// the caches next to the core, and its oldest pose, which the next one replaces, was last touched
    /// seconds ago.
    pub(crate) fn make_ready(&self) {
        if self.poses.len() == self.capacity {
            core::hint::black_box(self.poses.front().copied());
        }
    }

    /// Begins a new history: lookups no longer see what came before.
    pub fn break_off(&mut self) {
        self.start = self.taken;
    }

    /// The newest pose since the last break.
    pub fn newest(&self) -> Option<&CameraPose> {
        self.poses.back().filter(|_| self.start < self.taken)
    }

    /// The oldest pose that lookups see.
    pub fn oldest(&self) -> Option<&CameraPose> {
        self.poses.get(self.visible_from()).filter(|_| self.start < self.taken)
    }

    /// Number of poses that lookups see.
    pub fn len(&self) -> usize {
        self.poses.len() - self.visible_from()
    }

    /// Whether lookups see no pose.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The pose at a time, with tilt and time known; see [`History::lookup_with`].
    ///
    /// # Errors
    /// [`LookupError`].
    pub fn lookup(&self, time: Time) -> Result<CameraPose, LookupError> {
        self.lookup_with(time, Validity::empty())
    }

    /// The pose at a time, with these fields known besides tilt and time.
    ///
    /// Between two poses: orientation by slerp, position by the cubic Hermite curve with the
    /// velocities (a straight line where a velocity is unknown), everything else linearly; valid is
    /// what is valid in both. After the newest: constant angular rate and constant acceleration in
    /// the world, with σ grown. A UNIX time is mapped with the newest pose's offset.
    ///
    /// # Errors
    /// [`LookupError`].
    pub fn lookup_with(&self, time: Time, fields: Validity) -> Result<CameraPose, LookupError> {
        let (Some(oldest), Some(newest)) = (self.oldest(), self.newest()) else {
            return Err(LookupError::Empty);
        };
        let asked_ns = time.to_monotonic_ns(newest.message().unix_offset_ns);
        let oldest_ns = oldest.time_ns();
        if asked_ns < oldest_ns {
            return Err(LookupError::TooOld { oldest_ns, asked_ns });
        }
        let pose = if asked_ns > newest.time_ns() {
            self.ahead(newest, asked_ns)?
        } else {
            self.inside(asked_ns)?
        };
        pose.require(LEAST | fields)?;
        Ok(pose)
    }

    fn ahead(&self, newest: &CameraPose, asked_ns: i64) -> Result<CameraPose, LookupError> {
        let (newest_ns, cap_ns) = (newest.time_ns(), nanos(self.limits.prediction));
        if asked_ns.saturating_sub(newest_ns) > cap_ns {
            return Err(LookupError::TooNew { newest_ns, asked_ns, cap_ns });
        }
        Ok(predict(newest, asked_ns, &self.limits.noise))
    }

    /// For a time from the oldest to the newest pose, both included.
    fn inside(&self, asked_ns: i64) -> Result<CameraPose, LookupError> {
        let visible = self.visible_from();
        // The first pose at or after the time; not before the first visible one.
        let after = visible + self.count_before(visible, asked_ns);
        let (later, earlier) =
            (&self.poses[after], &self.poses[after.saturating_sub(1).max(visible)]);
        let (before_ns, after_ns) = (earlier.time_ns(), later.time_ns());
        let limit_ns = nanos(self.limits.bridge);
        if asked_ns < after_ns && after_ns.saturating_sub(before_ns) > limit_ns {
            return Err(LookupError::Gap { before_ns, after_ns, asked_ns, limit_ns });
        }
        Ok(between(earlier, later, asked_ns))
    }

    /// Visible poses before a time; their times never decrease.
    fn count_before(&self, visible: usize, time_ns: i64) -> usize {
        let (mut low, mut high) = (visible, self.poses.len());
        while low < high {
            let middle = low.midpoint(high);
            if self.poses[middle].time_ns() < time_ns {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        low - visible
    }

    /// Index of the first pose since the last break.
    fn visible_from(&self) -> usize {
        let first_kept = self.taken - self.poses.len() as u64;
        self.start.saturating_sub(first_kept) as usize
    }

    /// The last so many poses that lookups see, oldest first.
    pub(crate) fn recent(&self, count: usize) -> impl Iterator<Item = &CameraPose> + Clone {
        let from = self.visible_from().max(self.poses.len().saturating_sub(count));
        self.poses.range(from..)
    }

    /// How many poses were ever taken.
    pub(crate) const fn taken(&self) -> u64 {
        self.taken
    }

    /// Poses from a number on, whatever breaks lie between, and how many of them are gone.
    pub(crate) fn since(&self, number: u64) -> (u64, impl ExactSizeIterator<Item = &CameraPose>) {
        let first_kept = self.taken - self.poses.len() as u64;
        let gone = first_kept.saturating_sub(number);
        let skip = number.saturating_sub(first_kept).min(self.poses.len() as u64);
        (gone, self.poses.range(skip as usize..))
    }
}

fn nanos(duration: Duration) -> i64 {
    i64::try_from(duration.as_nanos()).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests;
