//! Which world the map is of.

/// Clouds of an earlier world are still on their way for less than this, ns.
const STRAGGLING_NS: i64 = 5_000_000_000;

/// What a cloud of some world means for the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Turn {
    /// It is of the map's world.
    Same,
    /// It is of a later one: the map begins anew.
    Anew,
    /// It is of an earlier one: too late.
    Past,
}

/// The world that the map is of. Poses of different worlds do not compare.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Epoch {
    /// Number, and time of the last cloud in it, `CLOCK_MONOTONIC`, ns.
    current: Option<(u32, i64)>,
}

impl Epoch {
    /// The number; `None` before the first cloud.
    pub(super) fn number(self) -> Option<u32> {
        self.current.map(|(number, _)| number)
    }

    /// Takes note of a cloud's world.
    pub(super) fn observe(&mut self, number: u32, now_ns: i64) -> Turn {
        let turn = match self.current {
            None => Turn::Same,
            Some((ours, _)) if ours == number => Turn::Same,
            Some((ours, _)) if number > ours => Turn::Anew,
            // A daemon that knows nothing of earlier worlds counts from 1 again.
            Some((_, seen_ns)) if now_ns.saturating_sub(seen_ns) > STRAGGLING_NS => Turn::Anew,
            Some(_) => Turn::Past,
        };
        if turn != Turn::Past {
            self.current = Some((number, now_ns));
        }
        turn
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: i64 = 1_000_000_000;

    #[test]
    fn a_later_world_begins_the_map_anew_and_stragglers_do_not_bring_the_old_one_back() {
        let mut epoch = Epoch::default();
        assert_eq!(epoch.observe(3, 0), Turn::Same);
        assert_eq!(epoch.observe(4, S), Turn::Anew);
        // Given a second camera whose last clouds of the old world come late
        assert_eq!(epoch.observe(3, 2 * S), Turn::Past);
        assert_eq!(epoch.observe(4, 3 * S), Turn::Same);
        assert_eq!(epoch.number(), Some(4));
    }

    #[test]
    fn a_daemon_that_counts_from_one_again_is_followed_once_the_old_world_is_silent() {
        let mut epoch = Epoch::default();
        epoch.observe(9, 0);
        assert_eq!(epoch.observe(1, 4 * S), Turn::Past);
        assert_eq!(epoch.observe(1, 6 * S), Turn::Anew);
        assert_eq!(epoch.number(), Some(1));
    }
}
