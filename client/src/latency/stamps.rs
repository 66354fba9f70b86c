//! The stamps of one sample's way, and the stages between them.

use lodestone_schema::Pose;

/// A part of the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The driver reads and hands on.
    ArrivalToRing,
    /// The sample waits for the loop.
    RingToStep,
    /// Grid and filter.
    Step,
    /// The pose is made and copied.
    StepToPublished,
    /// Shared memory, the consumer's look, its checks.
    PublishedToSeen,
    /// The whole way.
    ArrivalToSeen,
}

impl Stage {
    /// Every stage in the order of the way; the whole comes last.
    pub const ALL: [Self; 6] = [
        Self::ArrivalToRing,
        Self::RingToStep,
        Self::Step,
        Self::StepToPublished,
        Self::PublishedToSeen,
        Self::ArrivalToSeen,
    ];

    /// What a person calls it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::ArrivalToRing => "arrival → ring",
            Self::RingToStep => "ring → step start",
            Self::Step => "step start → step end",
            Self::StepToPublished => "step end → published",
            Self::PublishedToSeen => "published → seen",
            Self::ArrivalToSeen => "arrival → seen",
        }
    }

    /// Its name in machine-readable output.
    pub const fn key(self) -> &'static str {
        match self {
            Self::ArrivalToRing => "arrival_to_ring",
            Self::RingToStep => "ring_to_step_start",
            Self::Step => "step_start_to_step_end",
            Self::StepToPublished => "step_end_to_published",
            Self::PublishedToSeen => "published_to_seen",
            Self::ArrivalToSeen => "arrival_to_seen",
        }
    }
}

/// When one sample was where, `CLOCK_MONOTONIC`, ns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stamps {
    /// It reached the computer.
    pub arrival_ns: i64,
    /// The driver put it into the ring.
    pub ring_ns: i64,
    /// The loop took it.
    pub step_start_ns: i64,
    /// The filter was done.
    pub step_end_ns: i64,
    /// The pose was handed to the transport.
    pub published_ns: i64,
    /// The consumer had it, checked.
    pub seen_ns: i64,
}

impl Stamps {
    /// The stamps of a pose that was seen at a time.
    pub const fn of(pose: &Pose, seen_ns: i64) -> Self {
        Self {
            arrival_ns: pose.arrival_time_ns,
            ring_ns: pose.ring_time_ns,
            step_start_ns: pose.step_start_time_ns,
            step_end_ns: pose.step_end_time_ns,
            published_ns: pose.published_time_ns,
            seen_ns,
        }
    }

    /// How long a stage took, ns; negative only if stamps are not in order.
    pub const fn span_ns(&self, stage: Stage) -> i64 {
        let (from, to) = match stage {
            Stage::ArrivalToRing => (self.arrival_ns, self.ring_ns),
            Stage::RingToStep => (self.ring_ns, self.step_start_ns),
            Stage::Step => (self.step_start_ns, self.step_end_ns),
            Stage::StepToPublished => (self.step_end_ns, self.published_ns),
            Stage::PublishedToSeen => (self.published_ns, self.seen_ns),
            Stage::ArrivalToSeen => (self.arrival_ns, self.seen_ns),
        };
        to.saturating_sub(from)
    }

    /// Whether no stage ends before it begins. Stamps of one computer's clock always are.
    pub fn are_in_order(&self) -> bool {
        Stage::ALL.iter().all(|stage| self.span_ns(*stage) >= 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::samples::still;

    #[test]
    fn stages_lie_end_to_end_and_make_the_whole() {
        let pose = Pose {
            arrival_time_ns: 100,
            ring_time_ns: 110,
            step_start_time_ns: 130,
            step_end_time_ns: 170,
            published_time_ns: 250,
            ..still(0, 0)
        };
        let stamps = Stamps::of(&pose, 410);
        let spans = Stage::ALL.map(|stage| stamps.span_ns(stage));
        assert_eq!(spans, [10, 20, 40, 80, 160, 310]);
        assert_eq!(spans[..5].iter().sum::<i64>(), spans[5]);
        assert!(stamps.are_in_order());
        assert!(!Stamps { ring_ns: 99, ..stamps }.are_in_order());
    }
}
