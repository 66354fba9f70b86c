//! Voting: which members' inertial sensors count.
//!
//! What members read at the filter point, their usual offsets taken off, agrees up to noise, scale and
//! alignment. A member that does not is voted out by the median of three or more. Two members cannot
//! outvote each other: there the one whose own signal broke goes, the one that repeats itself or the one
//! that jumped. One that is out comes back after it has agreed for a while, each time a longer one.

use glam::DVec3;

use super::geometry::MAX_MEMBERS;
use super::virtual_imu::Inertial;

/// Parameters of the vote.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VotingParameters {
    /// Disagreement of rates that is usual, rad/s, and what is added to it for each rad/s of turning
    /// (scale, alignment). Small votes out sooner. Default 0.02 and 0.05.
    pub rate_rad_s: f64,
    /// See above.
    pub rate_share: f64,
    /// Disagreement of forces that is usual, m/s², and what is added for each m/s² beyond gravity's
    /// size and for each rad/s² (surveyed arms are good to centimetres). Default 0.4, 0.05, 0.03.
    pub force_m_s2: f64,
    /// See above.
    pub force_share: f64,
    /// See above.
    pub arm_error_m: f64,
    /// Time over which disagreement is averaged, s. Default 0.1.
    pub average_s: f64,
    /// Disagreement, in units of what is usual, that needs no average. Default 10.
    pub gross: f64,
    /// Missing steps after which a member counts as silent. Default 4.
    pub silent_steps: u32,
    /// Identical steps after which a member counts as stuck. Default 40.
    pub stuck_steps: u32,
    /// Agreement after which a member comes back, s; it doubles with each time, up to the limit. Default
    /// 3 and 60.
    pub return_s: f64,
    /// See above.
    pub return_limit_s: f64,
}

impl Default for VotingParameters {
    fn default() -> Self {
        Self {
            rate_rad_s: 0.02,
            rate_share: 0.05,
            force_m_s2: 0.4,
            force_share: 0.05,
            arm_error_m: 0.03,
            average_s: 0.1,
            gross: 10.0,
            silent_steps: 4,
            stuck_steps: 40,
            return_s: 3.0,
            return_limit_s: 60.0,
        }
    }
}

/// Why a member does not count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exclusion {
    /// It gives nothing.
    Silent,
    /// What it gives is not finite.
    Invalid,
    /// It gives the same again and again.
    Stuck,
    /// It is at the end of its range.
    Saturated,
    /// It disagrees with the others.
    Deviating,
}

/// What a member gave in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Given {
    /// At the filter point, offsets taken off; nothing if it is missing or not finite.
    pub(crate) centred: Option<Inertial>,
    pub(crate) present: bool,
    pub(crate) saturated: bool,
    /// Its usual offset is known by now.
    pub(crate) known: bool,
    /// From the filter point to its IMU, m.
    pub(crate) arm_m: f64,
}

/// What all members gave.
pub(crate) type AllGiven = [Given; MAX_MEMBERS];

#[derive(Clone, Copy, Debug, PartialEq)]
struct Candidate {
    exclusion: Option<Exclusion>,
    /// Mean disagreement in units of what is usual.
    strain: f64,
    /// Largest recent jump from step to step, in the same units, fading.
    jolt: f64,
    missing: u32,
    repeats: u32,
    last: Option<Inertial>,
    agreeing_s: f64,
    return_s: f64,
}

/// The state of the vote.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Voting {
    p: VotingParameters,
    candidates: [Candidate; MAX_MEMBERS],
    count: usize,
    /// Angular acceleration of late, rad/s².
    swing_rad_s2: f64,
    pub(crate) torn: bool,
}

/// How long a swing is remembered, s: its lever-arm terms err most when it turns round.
const SWING_S: f64 = 0.5;
/// Share of a lever-arm term that its lateness spoils.
const LATE: f64 = 0.25;
/// How long a jump is remembered, s: until the average has seen it.
const JOLT_S: f64 = 0.5;
/// Repetitions after which one of two counts as stuck, and how many times the other's jump is telling.
const REPEATS_OF_TWO: u32 = 8;
const TELLING: f64 = 3.0;

impl Voting {
    pub(crate) const fn new(count: usize, p: VotingParameters) -> Self {
        let fresh = Candidate {
            exclusion: None,
            strain: 0.0,
            jolt: 0.0,
            missing: 0,
            repeats: 0,
            last: None,
            agreeing_s: 0.0,
            return_s: p.return_s,
        };
        let candidates = [fresh; MAX_MEMBERS];
        Self { p, candidates, count, swing_rad_s2: 0.0, torn: false }
    }

    /// Holds the vote of one step, in which the rig's angular acceleration was `swing_rad_s2`; gives who
    /// counts in it.
    pub(crate) fn hold(
        &mut self,
        given: &AllGiven,
        swing_rad_s2: f64,
        span_s: f64,
    ) -> [bool; MAX_MEMBERS] {
        for (candidate, given) in self.candidates.iter_mut().zip(given).take(self.count) {
            candidate.look(given, &self.p);
        }
        let consensus = self.consensus(given);
        let motion = self.motion(&consensus, swing_rad_s2, span_s);
        for (candidate, given) in self.candidates.iter_mut().zip(given).take(self.count) {
            let usual = motion.usual(given.arm_m, &self.p);
            candidate.compare(given, &consensus, usual, span_s, &self.p);
        }
        self.judge(given, span_s);
        core::array::from_fn(|k| {
            let c = &self.candidates[k];
            let counts = c.exclusion.is_none() && given[k].centred.is_some();
            k < self.count && counts && !given[k].saturated && c.now_usual(&self.p)
        })
    }

    /// Why a member is out; nothing if it is in.
    pub(crate) const fn exclusion(&self, member: usize) -> Option<Exclusion> {
        self.candidates[member].exclusion
    }

    /// Nobody would be left: then everybody who gives anything counts again.
    pub(crate) fn pardon(&mut self) {
        for candidate in &mut self.candidates {
            candidate.exclusion = None;
            candidate.strain = 0.0;
        }
    }

    /// The median of those who count, by component; of two, the mean.
    fn consensus(&self, given: &AllGiven) -> Inertial {
        let voters = |k: &usize| {
            let in_order = self.candidates[*k].exclusion.is_none() && !given[*k].saturated;
            given[*k].centred.filter(|_| in_order)
        };
        let read = |of: fn(&Inertial) -> DVec3| {
            let mut axes = [0.0; 3];
            for (axis, value) in axes.iter_mut().enumerate() {
                let values = (0..self.count).filter_map(|k| voters(&k)).map(|i| of(&i)[axis]);
                *value = median(values);
            }
            DVec3::from_array(axes)
        };
        Inertial { rate: read(|i| i.rate), force: read(|i| i.force) }
    }

    /// What the rig does, as far as it makes sensors disagree.
    fn motion(&mut self, consensus: &Inertial, swing_rad_s2: f64, span_s: f64) -> Motion {
        let length = |v: DVec3| libm::sqrt(v.length_squared());
        let turning = length(consensus.rate);
        self.swing_rad_s2 = swing_rad_s2.max(self.swing_rad_s2 * (1.0 - span_s / SWING_S));
        Motion {
            turning,
            pushed: (length(consensus.force) - 9.81).abs(),
            swing: self.swing_rad_s2 + turning * turning,
            span_s,
        }
    }

    fn judge(&mut self, given: &AllGiven, span_s: f64) {
        let counting = |c: &Candidate| c.exclusion.is_none() && c.last.is_some();
        let electorate = self.candidates[..self.count].iter().filter(|c| counting(c)).count();
        let all_repeat = self.candidates[..self.count]
            .iter()
            .filter(|c| counting(c))
            .all(|c| c.repeats >= REPEATS_OF_TWO);
        self.torn = false;
        match electorate {
            0 | 1 => {}
            2 => self.judge_two(all_repeat),
            _ => {
                for (c, given) in self.candidates.iter_mut().zip(given).take(self.count) {
                    let gross = c.last.is_some() && c.strain > self.p.gross;
                    if c.exclusion.is_none() && (gross || (given.known && c.strain > 1.0)) {
                        c.exclude(Exclusion::Deviating);
                    }
                    if c.exclusion.is_none() && !all_repeat && c.repeats >= self.p.stuck_steps {
                        c.exclude(Exclusion::Stuck);
                    }
                }
            }
        }
        for c in self.candidates.iter_mut().take(self.count) {
            c.readmit(span_s, &self.p);
        }
    }

    /// Of two that disagree, the one whose own signal broke goes.
    fn judge_two(&mut self, all_repeat: bool) {
        let mut pair = (0..self.count).filter(|&k| {
            self.candidates[k].exclusion.is_none() && self.candidates[k].last.is_some()
        });
        let (Some(a), Some(b)) = (pair.next(), pair.next()) else { return };
        let (one, other) = (self.candidates[a], self.candidates[b]);
        // Each lies half the disagreement from the mean.
        if one.strain.max(other.strain) < 0.5 {
            return;
        }
        let stuck = |c: &Candidate| !all_repeat && c.repeats >= REPEATS_OF_TWO;
        let (out, why) = if stuck(&one) {
            (a, Exclusion::Stuck)
        } else if stuck(&other) {
            (b, Exclusion::Stuck)
        } else if one.jolt > TELLING * other.jolt {
            (a, Exclusion::Deviating)
        } else if other.jolt > TELLING * one.jolt {
            (b, Exclusion::Deviating)
        } else {
            self.torn = true;
            return;
        };
        self.candidates[out].exclude(why);
    }
}

/// What the rig does.
#[derive(Clone, Copy, Debug)]
struct Motion {
    /// rad/s.
    turning: f64,
    /// Force beyond gravity's size, m/s².
    pushed: f64,
    /// What makes the ends of a lever accelerate, rad/s².
    swing: f64,
    span_s: f64,
}

impl Motion {
    /// The usual disagreement of rates, rad/s, and forces, m/s², of a member on an arm, m. Lever-arm terms
    /// are as good as the survey, and late by the smoothing of the rate.
    fn usual(&self, arm_m: f64, p: &VotingParameters) -> (f64, f64) {
        let lever = (p.arm_error_m + LATE * arm_m) * self.swing;
        // A step of misalignment in time shows as the change of the rate.
        let rate = p.rate_rad_s + p.rate_share * self.turning + self.swing * self.span_s;
        (rate, p.force_m_s2 + p.force_share * self.pushed + lever)
    }
}

impl Candidate {
    /// Looks at what is there at all.
    fn look(&mut self, given: &Given, p: &VotingParameters) {
        self.missing = if given.present { 0 } else { self.missing.saturating_add(1) };
        if self.missing >= p.silent_steps {
            self.exclude(Exclusion::Silent);
            self.last = None;
        } else if given.present && given.centred.is_none() {
            self.exclude(Exclusion::Invalid);
            self.last = None;
        }
    }

    /// Compares it with the consensus and with itself a step ago.
    fn compare(
        &mut self,
        given: &Given,
        consensus: &Inertial,
        (rate, force): (f64, f64),
        span_s: f64,
        p: &VotingParameters,
    ) {
        let Some(now) = given.centred else { return };
        let size = |a: &Inertial, b: &Inertial| {
            let by_rate = libm::sqrt((a.rate - b.rate).length_squared()) / rate;
            by_rate.max(libm::sqrt((a.force - b.force).length_squared()) / force)
        };
        let off = size(&now, consensus);
        let share = span_s / (span_s + p.average_s);
        self.strain += share * (off.min(p.gross / share) - self.strain);
        if off > p.gross {
            self.strain = self.strain.max(off);
        }
        let jump = self.last.map_or(0.0, |last| size(&now, &last));
        self.jolt = jump.max(self.jolt * (1.0 - span_s / JOLT_S));
        self.last = Some(now);
    }

    /// Whether it may count in this very step.
    fn now_usual(&self, p: &VotingParameters) -> bool {
        self.strain <= p.gross
    }

    fn exclude(&mut self, why: Exclusion) {
        if self.exclusion.is_none() {
            self.agreeing_s = 0.0;
        }
        if self.exclusion.is_none() || why == Exclusion::Silent || why == Exclusion::Invalid {
            self.exclusion = Some(why);
            if why == Exclusion::Silent || why == Exclusion::Invalid {
                self.agreeing_s = 0.0;
            }
        }
    }

    fn readmit(&mut self, span_s: f64, p: &VotingParameters) {
        if self.exclusion.is_none() {
            return;
        }
        let agrees = self.last.is_some() && self.strain < 0.5 && self.repeats < p.stuck_steps;
        self.agreeing_s = if agrees { self.agreeing_s + span_s } else { 0.0 };
        if self.agreeing_s >= self.return_s {
            self.exclusion = None;
            self.return_s = (2.0 * self.return_s).min(p.return_limit_s);
        }
    }

    /// Counts how often a raw reading repeats.
    fn note_repeat(&mut self, repeats: bool) {
        self.repeats = if repeats { self.repeats.saturating_add(1) } else { 0 };
    }
}

impl Voting {
    /// Tells whether each member's raw reading is the one before once more.
    pub(crate) fn note_repeats(&mut self, repeats: [bool; MAX_MEMBERS]) {
        for (candidate, repeats) in self.candidates.iter_mut().zip(repeats) {
            candidate.note_repeat(repeats);
        }
    }
}

/// The middle value; the mean of the two middle ones; zero of none.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted = [0.0; MAX_MEMBERS];
    let mut count = 0;
    for value in values.take(MAX_MEMBERS) {
        sorted[count] = value;
        count += 1;
    }
    sorted[..count].sort_unstable_by(f64::total_cmp);
    match count {
        0 => 0.0,
        n if n % 2 == 1 => sorted[n / 2],
        n => 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]),
    }
}
