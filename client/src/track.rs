//! What was lost and where a run ended, by publisher and sequence.

/// What a stream has seen since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Messages received.
    pub received: u64,
    /// Messages missing by their sequence, within one run of the daemon.
    pub lost: u64,
    /// Restarts of the publisher; what was lost across one is unknown.
    pub restarts: u64,
    /// Messages that failed their checks.
    pub invalid: u64,
    /// Times the service was opened.
    pub connections: u64,
}

/// How a message follows the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Arrival {
    /// The same run goes on, perhaps with messages lost between.
    Next,
    /// Another run begins.
    Restart,
    /// It was delivered before: the history that a late consumer gets.
    Again,
}

#[derive(Clone, Copy, Debug)]
struct Last {
    publisher: u128,
    sequence: u64,
    time_ns: i64,
}

/// Follows one camera's messages.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tracker {
    last: Option<Last>,
    replaying: bool,
    pub(crate) counts: Counts,
}

impl Tracker {
    /// The service was opened: what was seen before may be delivered again.
    pub(crate) const fn connected(&mut self) {
        self.replaying = true;
        self.counts.connections += 1;
    }

    /// Time of the last message, `CLOCK_MONOTONIC`, ns.
    pub(crate) fn last_time_ns(&self) -> Option<i64> {
        self.last.map(|last| last.time_ns)
    }

    /// Takes note of a message; the publisher is the transport's id, new with each run.
    pub(crate) fn observe(&mut self, publisher: u128, sequence: u64, time_ns: i64) -> Arrival {
        let arrival = self.classify(publisher, sequence, time_ns);
        if arrival == Arrival::Again {
            return arrival;
        }
        if let (Arrival::Next, Some(last)) = (arrival, self.last) {
            let missing = sequence - last.sequence - 1;
            self.counts.lost = self.counts.lost.saturating_add(missing);
        }
        self.counts.restarts += u64::from(arrival == Arrival::Restart);
        self.counts.received += 1;
        self.replaying = false;
        self.last = Some(Last { publisher, sequence, time_ns });
        arrival
    }

    const fn classify(&self, publisher: u128, sequence: u64, time_ns: i64) -> Arrival {
        match self.last {
            None => Arrival::Next,
            Some(last) if last.publisher != publisher => Arrival::Restart,
            Some(last) if sequence > last.sequence => Arrival::Next,
            Some(last) if self.replaying && time_ns <= last.time_ns => Arrival::Again,
            Some(_) => Arrival::Restart,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: u128 = 1;
    const B: u128 = 2;

    #[test]
    fn a_jump_in_the_sequence_is_counted_as_lost() {
        let mut tracker = Tracker::default();
        assert_eq!(tracker.observe(A, 7, 70), Arrival::Next);
        assert_eq!(tracker.observe(A, 8, 80), Arrival::Next);
        assert_eq!(tracker.observe(A, 12, 120), Arrival::Next);
        assert_eq!(tracker.counts.lost, 3);
        assert_eq!(tracker.counts.received, 3);
    }

    #[test]
    fn another_publisher_is_a_restart_even_if_the_sequence_goes_on() {
        let mut tracker = Tracker::default();
        tracker.observe(A, 7, 70);
        assert_eq!(tracker.observe(B, 900, 9000), Arrival::Restart);
        assert_eq!(tracker.counts, Counts { received: 2, restarts: 1, ..Counts::default() });
    }

    #[test]
    fn a_sequence_that_runs_back_is_a_restart() {
        // Given a bridge from another host, whose own publisher outlives the daemon it mirrors.
        let mut tracker = Tracker::default();
        tracker.observe(A, 7, 70);
        assert_eq!(tracker.observe(A, 0, 90), Arrival::Restart);
    }

    #[test]
    fn history_delivered_again_after_reopening_is_neither_loss_nor_restart() {
        let mut tracker = Tracker::default();
        for sequence in 0..5 {
            tracker.observe(A, sequence, 10 * sequence as i64);
        }
        tracker.connected();
        for sequence in 2..5 {
            assert_eq!(tracker.observe(A, sequence, 10 * sequence as i64), Arrival::Again);
        }
        assert_eq!(tracker.observe(A, 5, 50), Arrival::Next);
        assert_eq!(tracker.counts.received, 6);
        assert_eq!((tracker.counts.lost, tracker.counts.restarts), (0, 0));
    }
}
