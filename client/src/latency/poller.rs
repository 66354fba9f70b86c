//! A consumer that never sleeps while a pose may come.

use lodestone_schema::Status;

use super::counts::Counted;
use super::gaps::Gap;
use super::record::Sighting;
use super::stamps::Stamps;
use crate::pose_stream::PoseStream;
use crate::time::monotonic_now_ns;

/// What one look brought.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seen {
    /// The newest pose that came in this look, if any did that counts.
    pub sighting: Option<Sighting>,
    /// What was left out.
    pub left_out: Counted,
}

/// Looks at the streams of several cameras in turn, and notes when it was itself kept from looking.
///
/// Between two empty looks lies nothing but a read of the clock and of an empty queue; so a gap there
/// is not the consumer's doing.
#[derive(Debug)]
pub struct Poller {
    streams: Vec<PoseStream>,
    /// Lost poses already reported, by stream.
    lost: Vec<u64>,
    threshold_ns: i64,
    begin_ns: i64,
    last_empty_ns: Option<i64>,
}

impl Poller {
    /// Poses that arrived before `begin_ns` count as warm-up; gaps longer than the threshold are noted.
    pub fn new(streams: Vec<PoseStream>, begin_ns: i64, threshold_ns: i64) -> Self {
        let lost = vec![0; streams.len()];
        Self { streams, lost, threshold_ns, begin_ns, last_empty_ns: None }
    }

    /// Looks at one camera.
    pub fn look(&mut self, camera: usize) -> Seen {
        let stream = &mut self.streams[camera];
        let mut newest = None;
        let (mut fresh, mut seen) = (0, Seen::default());
        for pose in stream.all() {
            if pose.message().arrival_time_ns < self.begin_ns {
                seen.left_out.warm_up += 1;
            } else if pose.status().contains(Status::SENSOR_STALE) {
                seen.left_out.repeated += 1;
            } else {
                (newest, fresh) = (Some(*pose.message()), fresh + 1);
            }
        }
        seen.sighting = newest.map(|pose| Sighting {
            stamps: Stamps::of(&pose, monotonic_now_ns()),
            in_one_look: fresh,
        });
        self.count_lost(camera, &mut seen.left_out);
        seen
    }

    /// Looks at every camera once. Gives the gap since the last look that found nothing, if it was one.
    pub fn round(&mut self, mut on_seen: impl FnMut(usize, &Seen)) -> Option<Gap> {
        let now_ns = monotonic_now_ns();
        let gap = self.last_empty_ns.map(|begin_ns| Gap { begin_ns, end_ns: now_ns });
        let mut empty = true;
        for camera in 0..self.streams.len() {
            let seen = self.look(camera);
            if seen != Seen::default() {
                empty = false;
                on_seen(camera, &seen);
            }
        }
        // After a look with something in it, the caller's own work is between this and the next.
        self.last_empty_ns = empty.then_some(now_ns);
        gap.filter(|gap| gap.span_ns() > self.threshold_ns)
    }

    /// A nap of the caller's is no gap.
    pub const fn forget_last_look(&mut self) {
        self.last_empty_ns = None;
    }

    /// The streams, in the order in which they were given.
    pub fn streams(&self) -> &[PoseStream] {
        &self.streams
    }

    /// What was lost before the measurement began is not counted.
    fn count_lost(&mut self, camera: usize, left_out: &mut Counted) {
        let lost = self.streams[camera].counts().lost;
        let before = std::mem::replace(&mut self.lost[camera], lost);
        if lost > before && monotonic_now_ns() >= self.begin_ns {
            left_out.lost += lost - before;
        }
    }
}
