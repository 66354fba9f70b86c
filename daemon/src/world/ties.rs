//! How far two members are apart that were measured against each other, directly or by way of others.

use glam::DVec3;
use lodestone_fusion::relative::{Apart, Tied};
use lodestone_fusion::{Drift, Drifted};

use super::anchor::tie_now;
use super::frame::WorldFrame;
use crate::reading::HostTime;

/// Longest way from anchor to anchor: registrations of registrations say little.
const LONGEST: usize = 8;

/// A member that another one leads to by its ties.
#[derive(Clone, Copy, Debug)]
struct Reached {
    member: usize,
    /// How far the one that leads here is from the member before.
    before: Apart,
    /// The tie of the member before to this one; `None` where the way begins.
    last: Option<Step>,
}

/// A tie, and the way from its follower to where it all begins.
#[derive(Clone, Copy, Debug)]
struct Step {
    tied: Tied,
    /// From the anchor to its follower, m in the world.
    arm_m: DVec3,
    /// From the follower to the member at which the way begins, m in the world.
    beyond_m: DVec3,
}

/// How far each of two members is from one that both lead to, which may be one of the two; `None` if there
/// is none.
pub(super) fn apart(frame: &WorldFrame, members: [usize; 2], now: HostTime) -> Option<[Apart; 2]> {
    let [a, b] = members.map(|member| way(frame, member, now));
    let meeting = a.iter().find_map(|of_a| {
        let of_b = b.iter().find(|of_b| of_b.member == of_a.member)?;
        Some((of_a, of_b))
    });
    let (of_a, of_b) = meeting?;
    if let (Some(to_a), Some(to_b)) = (&of_a.last, &of_b.last) {
        // Of their anchor's drift only what lies between the two measurements leads them apart.
        let between = to_a.tied.mark.between(&to_b.tied.mark)?;
        return Some([of_a.whole(&between), of_b.whole(&Drifted::NOTHING)]);
    }
    let present = frame.motion(of_a.member)?.drift;
    Some([of_a.until(&present)?, of_b.until(&present)?])
}

/// The members that one leads to, itself first.
fn way(frame: &WorldFrame, member: usize, now: HostTime) -> Vec<Reached> {
    let mut way = vec![Reached { member, before: Apart::NOTHING, last: None }];
    while way.len() <= LONGEST {
        let next = way.last().and_then(|last| step(frame, member, last, now));
        match next {
            Some(next) if way.iter().all(|reached| reached.member != next.member) => way.push(next),
            _ => break,
        }
    }
    way
}

/// One tie further.
fn step(frame: &WorldFrame, begin: usize, from: &Reached, now: HostTime) -> Option<Reached> {
    let tied = tie_now(frame, from.member, now)?;
    let anchor = usize::from(tied.anchor);
    let position = |member: usize| frame.motion(member).map(|motion| motion.station.position);
    let here = frame.motion(from.member)?;
    let arm_m = here.station.position - position(anchor)?;
    let beyond_m = position(begin)? - here.station.position;
    let before = from.until(&here.drift)?;
    Some(Reached { member: anchor, before, last: Some(Step { tied, arm_m, beyond_m }) })
}

impl Reached {
    /// How far the one that leads here is from this member, which has drifted so since.
    fn whole(&self, drifted: &Drifted) -> Apart {
        self.last.as_ref().map_or(self.before, |last| {
            self.before.then(&last.tied.apart(drifted, last.arm_m), last.beyond_m)
        })
    }

    /// The same, where the member's drift is so now; `None` if it has begun anew.
    fn until(&self, drift: &Drift) -> Option<Apart> {
        let Some(last) = &self.last else { return Some(self.before) };
        Some(self.whole(&drift.since(&last.tied.mark)?))
    }
}
