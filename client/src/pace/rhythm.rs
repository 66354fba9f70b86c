//! The publisher's rhythm, from the times at which it published.

/// Poses from which the rhythm is learnt.
pub(crate) const OBSERVED: usize = 64;
/// Fewer moments than these tell no rhythm.
const LEAST: usize = 8;
/// Poses published closer together come with one sample, ns: the first of them is what is waited for.
const BURST_NS: i64 = 100_000;

/// Moments on a lattice: `phase + n · period`, each off by an offset of its own.
///
/// A pose is published when a sample arrives, so the lattice is that of the samples, whose
/// rate is not quite the step rate: now and then a moment is missing, or brings two poses. Jitter
/// is mostly delay, by milliseconds at times, so period and phase come from medians, which single late
/// ones do not move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rhythm {
    period_ns: f64,
    /// The lattice's moment after the newest pose, `CLOCK_MONOTONIC`, ns.
    next_ns: i64,
    /// When the newest pose was published, ns.
    newest_ns: i64,
    offsets: Offsets,
}

/// Offsets of the moments observed from their place on the lattice, ns, in ascending order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Offsets {
    sorted_ns: [f64; OBSERVED],
    len: usize,
}

/// A moment after the first, and its number on the lattice.
#[derive(Clone, Copy, Default)]
struct Moment {
    after_ns: f64,
    number: f64,
}

impl Rhythm {
    /// Learns from times of publication, oldest first; of more than [`OBSERVED`] the first count.
    /// Nothing if there are too few, or they run backwards.
    pub(crate) fn learn(stamps: impl Iterator<Item = i64>) -> Option<Self> {
        let mut times = [0_i64; OBSERVED];
        let len = without_bursts(stamps, &mut times);
        let times = times.get(..len).filter(|times| times.len() >= LEAST)?;
        let (first_ns, newest_ns) = (*times.first()?, *times.last()?);
        let mut moments = [Moment::default(); OBSERVED];
        let moments = moments.get_mut(..len)?;
        let rough_ns = number(times, moments)?;
        let period_ns = rough_ns + slope(moments, rough_ns);
        let offsets = Offsets::of(moments.iter().map(|m| m.after_ns - m.number * period_ns));
        let next = moments.last()?.number + 1.0;
        let next_ns = first_ns.saturating_add((next * period_ns) as i64);
        (period_ns >= 1.0).then_some(Self { period_ns, next_ns, newest_ns, offsets })
    }

    /// Between two moments, ns.
    pub(crate) const fn period_ns(&self) -> f64 {
        self.period_ns
    }

    /// The lattice's moment after the newest pose, ns.
    pub(crate) const fn next_ns(&self) -> i64 {
        self.next_ns
    }

    /// When the newest pose was published, ns.
    pub(crate) const fn newest_ns(&self) -> i64 {
        self.newest_ns
    }

    /// How far from the lattice poses came.
    pub(crate) const fn offsets(&self) -> &Offsets {
        &self.offsets
    }
}

/// The first time of each burst; how many there are.
fn without_bursts(stamps: impl Iterator<Item = i64>, times: &mut [i64; OBSERVED]) -> usize {
    let (mut len, mut last) = (0, None::<i64>);
    for stamp in stamps.take(OBSERVED) {
        if last.is_none_or(|last| stamp.saturating_sub(last) >= BURST_NS) {
            times[len] = stamp;
            len += 1;
        }
        last = Some(stamp);
    }
    len
}

/// Numbers the moments by the median step between them, which it returns.
fn number(times: &[i64], moments: &mut [Moment]) -> Option<f64> {
    let first_ns = *times.first()?;
    let steps = times.windows(2).map(|pair| pair[1].saturating_sub(pair[0]) as f64);
    let rough_ns = Offsets::of(steps.clone()).median();
    let mut number = 0.0;
    for ((moment, time), step) in
        moments.iter_mut().zip(times).zip(core::iter::once(0.0).chain(steps))
    {
        number += if step > 0.0 { (step / rough_ns).round().max(1.0) } else { 0.0 };
        *moment = Moment { after_ns: time.saturating_sub(first_ns) as f64, number };
    }
    (rough_ns >= 1.0).then_some(rough_ns)
}

/// What a step is longer than assumed, from the medians of the first and the last third.
fn slope(moments: &[Moment], step_ns: f64) -> f64 {
    let third = moments.len() / 3;
    let (early, late) = (&moments[..third], &moments[moments.len() - third..]);
    let off = |part: &[Moment]| {
        Offsets::of(part.iter().map(|m| m.after_ns - m.number * step_ns)).median()
    };
    let number = |part: &[Moment]| Offsets::of(part.iter().map(|m| m.number)).median();
    let numbers = number(late) - number(early);
    if numbers > 0.0 { (off(late) - off(early)) / numbers } else { 0.0 }
}

impl Offsets {
    pub(crate) fn of(values: impl Iterator<Item = f64>) -> Self {
        let (mut sorted_ns, mut len) = ([0.0; OBSERVED], 0);
        for value in values.take(OBSERVED) {
            sorted_ns[len] = value;
            len += 1;
        }
        sorted_ns[..len].sort_unstable_by(f64::total_cmp);
        Self { sorted_ns, len }
    }

    /// In ascending order, ns.
    pub(crate) fn sorted(&self) -> &[f64] {
        &self.sorted_ns[..self.len]
    }

    /// The value below which this part of all lie; 0 of none.
    pub(crate) fn quantile(&self, part: f64) -> f64 {
        let last = self.len.saturating_sub(1);
        let at = (part * last as f64).round() as usize;
        self.sorted().get(at.min(last)).copied().unwrap_or(0.0)
    }

    fn median(&self) -> f64 {
        self.quantile(0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const BEGIN_NS: i64 = 1_000_000_000;
    const PERIOD_NS: i64 = 2_500_000;

    fn lattice(numbers: impl Iterator<Item = i64>) -> impl Iterator<Item = i64> {
        numbers.map(|n| BEGIN_NS + n * PERIOD_NS)
    }

    fn near(a: i64, b: i64, tolerance_ns: i64) {
        assert!((a - b).abs() <= tolerance_ns, "{a} is not {b}");
    }

    #[test]
    fn the_next_moment_follows_a_steady_publisher() {
        let rhythm = Rhythm::learn(lattice(0..64)).unwrap();
        near(rhythm.next_ns(), BEGIN_NS + 64 * PERIOD_NS, 1);
        assert!((rhythm.period_ns() - PERIOD_NS as f64).abs() < 1e-3);
    }

    #[test]
    fn single_late_poses_move_nothing() {
        // Given every tenth pose late by up to 1 ms, the newest too
        let late = |(n, time)| if n % 10 == 3 { time + 1_000_000 } else { time };
        let rhythm = Rhythm::learn(lattice(0..64).enumerate().map(late)).unwrap();
        near(rhythm.next_ns(), BEGIN_NS + 64 * PERIOD_NS, 100);
        assert!((rhythm.offsets().quantile(1.0) - 1e6).abs() < 1e3);
    }

    #[test]
    fn missing_moments_count_and_bursts_are_one() {
        let numbers = (0..50).filter(|n| n % 7 != 5);
        let with_bursts = lattice(numbers).flat_map(|time| [time, time + 8_000]);
        let rhythm = Rhythm::learn(with_bursts).unwrap();
        // 64 stamps are 32 moments, of which the last is number 36.
        near(rhythm.next_ns(), BEGIN_NS + 37 * PERIOD_NS, 1);
    }

    #[test]
    fn too_few_poses_and_times_that_stand_still_tell_nothing() {
        assert_eq!(Rhythm::learn(lattice(0..7)), None);
        assert_eq!(Rhythm::learn(core::iter::repeat_n(BEGIN_NS, 64)), None);
        assert_eq!(Rhythm::learn(lattice((0..64).rev())), None);
    }

    proptest! {
        #[test]
        fn any_period_is_found_under_one_sided_jitter(
            period_ns in 400_000_i64..50_000_000,
            jitter in prop::collection::vec(0.0..0.1_f64, OBSERVED),
        ) {
            let at = |(n, part): (usize, &f64)| {
                BEGIN_NS + n as i64 * period_ns + (part * period_ns as f64) as i64
            };
            let rhythm = Rhythm::learn(jitter.iter().enumerate().map(at)).unwrap();
            prop_assert!((rhythm.period_ns() / period_ns as f64 - 1.0).abs() < 0.01);
            // Where it is looked for overlaps where the next comes. The medians of first and last third,
            // 42 moments apart, differ by jitter at most, and lead from the middle to the next.
            let next = BEGIN_NS + OBSERVED as i64 * period_ns;
            let of_period = |ns: f64| ns / period_ns as f64;
            let offset = |part: f64| rhythm.offsets().quantile(part);
            let lattice = (rhythm.next_ns() - next) as f64;
            let (earliest, latest) =
                (of_period(lattice + offset(0.0)), of_period(lattice + offset(1.0)));
            prop_assert!(earliest < 0.18 && latest > -0.08, "{earliest} {latest}");
        }

        #[test]
        fn whatever_the_stamps_nothing_panics(stamps in prop::collection::vec(any::<i64>(), 0..100)) {
            if let Some(rhythm) = Rhythm::learn(stamps.into_iter()) {
                prop_assert!(rhythm.period_ns().is_finite());
            }
        }
    }
}
