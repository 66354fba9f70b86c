//! Against whom a member may be measured, and what the anchor is worth.

use lodestone_fusion::relative::Tied;
use lodestone_fusion::{Anchor, is_position_known};
use lodestone_schema::AnchorRefusal;

use super::frame::WorldFrame;
use super::motion::Motion;
use crate::reading::HostTime;

/// An anchor whose last pose is older than this is silent, s.
const SILENT_AFTER_S: f64 = 0.5;
/// Standard deviation of a heading above which nothing can be given in the world by it, rad: 1σ of 18°.
const HEADING_SIGMA_RAD: f64 = 0.316;

/// An anchor as it was when something was measured against it.
///
/// What it says of itself is its latest; its place is taken back by its velocity.
///
/// # Errors
/// Why it cannot be one.
pub fn anchor_for(
    frame: &WorldFrame,
    follower: usize,
    anchor: usize,
    (valid_at, now): (HostTime, HostTime),
) -> Result<Anchor, AnchorRefusal> {
    if anchor >= frame.member_count() {
        return Err(AnchorRefusal::Unknown);
    }
    if anchor == follower {
        return Err(AnchorRefusal::Itself);
    }
    let motion = present(frame, anchor, now)?;
    if leads_to(frame, anchor, follower, now) {
        return Err(AnchorRefusal::Loop);
    }
    let ago_s = (motion.time_ns - valid_at.as_nanos()) as f64 * 1e-9;
    Ok(anchor_of(anchor as u16, &motion, ago_s))
}

/// An anchor as it is now, if it is one, and the time of its pose, ns.
pub(super) fn anchor_now(frame: &WorldFrame, anchor: u16, now: HostTime) -> Option<(Anchor, i64)> {
    let motion = present(frame, anchor.into(), now).ok()?;
    Some((anchor_of(anchor, &motion, 0.0), motion.time_ns))
}

fn present(frame: &WorldFrame, anchor: usize, now: HostTime) -> Result<Motion, AnchorRefusal> {
    let motion = frame.motion(anchor).ok_or(AnchorRefusal::Silent)?;
    let age_s = (now.as_nanos() - motion.time_ns) as f64 * 1e-9;
    if age_s > SILENT_AFTER_S {
        return Err(AnchorRefusal::Silent);
    }
    if motion.epoch == 0 || motion.epoch != frame.phase().published_epoch() {
        return Err(AnchorRefusal::OtherWorld);
    }
    let station = &motion.station;
    let heading_sigma_rad = station.orientation_covariance.z_axis.z.sqrt();
    let known = motion.heading_known && heading_sigma_rad < HEADING_SIGMA_RAD;
    if !(known && is_position_known(station.position_covariance)) {
        return Err(AnchorRefusal::NotKnown);
    }
    Ok(motion)
}

fn anchor_of(id: u16, motion: &Motion, ago_s: f64) -> Anchor {
    let station = &motion.station;
    Anchor {
        id,
        position_m: station.position - station.velocity * ago_s,
        orientation_covariance: station.orientation_covariance,
        position_covariance: station.position_covariance,
        drift: motion.drift,
    }
}

/// Whether a member was measured against another one, directly or by way of others: their errors would be
/// counted as each other's, and both would grow sure of what neither knows.
fn leads_to(frame: &WorldFrame, member: usize, other: usize, now: HostTime) -> bool {
    let mut at = member;
    for _ in 0..frame.member_count() {
        let Some(tied) = tie_now(frame, at, now) else { return false };
        at = tied.anchor.into();
        if at == other {
            return true;
        }
    }
    // A loop that this one is no part of.
    false
}

/// A member's tie, if it is there and has one in the present world.
pub(super) fn tie_now(frame: &WorldFrame, member: usize, now: HostTime) -> Option<Tied> {
    let report = frame.tie(member)?;
    let age_s = (now.as_nanos() - report.time_ns) as f64 * 1e-9;
    let holds = age_s < SILENT_AFTER_S && report.epoch == frame.phase().published_epoch();
    holds.then_some(report.tied)
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};
    use lodestone_fusion::relative::{FieldTie, Station};
    use lodestone_fusion::{Drift, Rotation, SensorTime};
    use lodestone_schema::DistanceSource;

    use super::super::ties;
    use super::*;
    use crate::world::WorldPhase;

    const NOW: HostTime = HostTime::from_nanos(10_000_000_000);
    const EPOCH: u32 = 4;
    const SIGMA_M: f64 = 3e-3;
    const SIGMA_RAD: f64 = 1e-3;

    /// A camera that knows its heading to a degree and its place to five centimetres.
    fn motion(at_m: DVec3) -> Motion {
        Motion {
            time_ns: NOW.as_nanos() - 5_000_000,
            epoch: EPOCH,
            heading_known: true,
            source: DistanceSource::CommonStart,
            station: Station {
                orientation: Rotation::from_yaw_pitch_roll(0.5, 0.0, 0.0),
                orientation_covariance: DMat3::IDENTITY * 3e-4,
                angular_rate: DVec3::ZERO,
                position: at_m,
                position_covariance: DMat3::IDENTITY * 0.0025,
                velocity: DVec3::X,
                velocity_covariance: DMat3::ZERO,
                at_rest: false,
                field: FieldTie {
                    with_orientation_rad2: DVec3::ZERO,
                    variance_rad2: 0.0,
                    prior_variance_rad2: 0.0,
                    way_m: 1.0,
                },
            },
            drift: Drift::new(SensorTime::from_nanos(1)),
        }
    }

    fn at(member: usize) -> DVec3 {
        DVec3::new(member as f64, 0.0, 0.0)
    }

    /// Four cameras in a row, a metre apart.
    fn frame() -> WorldFrame {
        let phase = WorldPhase { epoch: EPOCH, fixed: true, starts_hold: true, member: Some(0) };
        let frame = WorldFrame::new(4, phase);
        (0..4).for_each(|member| frame.report_motion(member, &motion(at(member))));
        frame
    }

    /// Says that a member was just measured against another one.
    fn tie(frame: &WorldFrame, member: usize, anchor: u16) {
        let by_turn = lodestone_fusion::so3::skew(at(anchor.into()) - at(member));
        let tied = Tied {
            anchor,
            shares: [[DMat3::IDENTITY, DMat3::ZERO], [by_turn, DMat3::IDENTITY]],
            own: [DMat3::IDENTITY * (SIGMA_RAD * SIGMA_RAD), DMat3::IDENTITY * (SIGMA_M * SIGMA_M)],
            anchor_covariance: [DMat3::IDENTITY * 3e-4, DMat3::IDENTITY * 0.0025],
            mark: motion(at(0)).drift,
        };
        frame.report_tie(member, &motion(at(member)), Some(&tied));
    }

    fn asked(frame: &WorldFrame, follower: usize, anchor: usize) -> Result<Anchor, AnchorRefusal> {
        anchor_for(frame, follower, anchor, (HostTime::from_nanos(9_895_000_000), NOW))
    }

    #[test]
    fn an_anchor_is_where_it_was_then_and_knows_what_it_knows() {
        let anchor = asked(&frame(), 0, 2).expect("it is there");
        let expected = motion(at(2));
        // A tenth of a second ago at a metre per second.
        assert!((anchor.position_m - at(2) + DVec3::X * 0.1).length() < 1e-9, "{anchor:?}");
        assert_eq!((anchor.id, anchor.drift), (2, expected.drift));
        assert_eq!(anchor.orientation_covariance, expected.station.orientation_covariance);
    }

    #[test]
    fn what_cannot_be_an_anchor_is_refused_with_its_reason() {
        let frame = frame();
        let reported = |change: &dyn Fn(&mut Motion)| {
            let mut changed = motion(at(1));
            change(&mut changed);
            frame.report_motion(1, &changed);
            asked(&frame, 0, 1).err()
        };
        assert_eq!(asked(&frame, 0, 9).err(), Some(AnchorRefusal::Unknown));
        assert_eq!(asked(&frame, 2, 2).err(), Some(AnchorRefusal::Itself));
        assert_eq!(reported(&|m| m.time_ns -= 1_000_000_000), Some(AnchorRefusal::Silent));
        assert_eq!(reported(&|m| m.epoch = EPOCH - 1), Some(AnchorRefusal::OtherWorld));
        assert_eq!(reported(&|m| m.epoch = 0), Some(AnchorRefusal::OtherWorld));
        assert_eq!(reported(&|m| m.heading_known = false), Some(AnchorRefusal::NotKnown));
        let vague = |m: &mut Motion| m.station.orientation_covariance.z_axis.z = 0.2;
        assert_eq!(reported(&vague), Some(AnchorRefusal::NotKnown));
        let nowhere = |m: &mut Motion| m.station.position_covariance = DMat3::IDENTITY * 1e8;
        assert_eq!(reported(&nowhere), Some(AnchorRefusal::NotKnown));
        assert_eq!(reported(&|_| {}), None);
        let alone = WorldFrame::new(2, frame.phase());
        assert_eq!(asked(&alone, 0, 1).err(), Some(AnchorRefusal::Silent), "it has no pose yet");
    }

    #[test]
    fn two_cameras_are_not_each_others_anchor_directly_or_by_way_of_others() {
        // Given 1 measured against 0, 2 against 1, 3 against 2
        let frame = frame();
        for member in 1..4_u16 {
            tie(&frame, member.into(), member - 1);
        }
        // Then 0 is measured against none of them
        for anchor in 1..4 {
            assert_eq!(asked(&frame, 0, anchor).err(), Some(AnchorRefusal::Loop), "{anchor}");
        }
        assert_eq!(asked(&frame, 1, 3).err(), Some(AnchorRefusal::Loop));
        assert!(asked(&frame, 3, 0).is_ok() && asked(&frame, 2, 0).is_ok(), "they may skip one");
        // Once the tie is of another world, nothing is in the way
        let (old, tied) =
            (Motion { epoch: EPOCH - 1, ..motion(at(1)) }, frame.tie(1).unwrap().tied);
        frame.report_tie(1, &old, Some(&tied));
        assert!(asked(&frame, 0, 1).is_ok());
    }

    #[test]
    fn a_pair_is_as_far_apart_as_the_way_from_anchor_to_anchor() {
        // Given 1 and 2 measured against 0, and 3 against 2
        let frame = frame();
        tie(&frame, 1, 0);
        tie(&frame, 2, 0);
        let turned = |a: usize, b: usize| {
            let [of_a, of_b] = ties::apart(&frame, [a, b], NOW)?;
            let variance = of_a.orientation.z_axis.z + of_b.orientation.z_axis.z;
            Some(variance / (SIGMA_RAD * SIGMA_RAD))
        };
        let close =
            |found: Option<f64>, links: f64| found.is_some_and(|x| (x - links).abs() < 1e-6);
        assert_eq!(turned(0, 3), None, "nobody measured 3");
        tie(&frame, 3, 2);
        assert!(close(turned(0, 1), 1.0) && close(turned(1, 0), 1.0));
        assert!(close(turned(1, 2), 2.0), "{:?}", turned(1, 2));
        assert!(close(turned(0, 3), 2.0) && close(turned(1, 3), 3.0));
        // A chain swings what is at its end: two metres of one link's turn, and both links' noise.
        let [_, of_3] = ties::apart(&frame, [0, 3], NOW).unwrap();
        let swung = 2.0 * SIGMA_M * SIGMA_M + SIGMA_RAD * SIGMA_RAD;
        assert!((of_3.position.y_axis.y - swung).abs() < 1e-12, "{of_3:?}");
    }

    #[test]
    fn what_an_anchor_drifted_since_parts_it_from_its_follower_but_not_two_followers() {
        let frame = frame();
        tie(&frame, 1, 0);
        tie(&frame, 2, 0);
        let drift = Drift { angle_rad2: 1e-4, ..motion(at(0)).drift };
        frame.report_motion(0, &Motion { drift, ..motion(at(0)) });
        let turned = |a: usize, b: usize| {
            let [of_a, of_b] = ties::apart(&frame, [a, b], NOW).unwrap();
            of_a.orientation.z_axis.z + of_b.orientation.z_axis.z
        };
        assert!((turned(0, 1) - 1e-4 - SIGMA_RAD * SIGMA_RAD).abs() < 1e-12);
        assert!((turned(1, 2) - 2.0 * SIGMA_RAD * SIGMA_RAD).abs() < 1e-12);
        // One that began anew has nothing in common with what it was.
        let anew = Drift::new(SensorTime::from_nanos(2));
        frame.report_motion(0, &Motion { drift: anew, ..motion(at(0)) });
        assert!(ties::apart(&frame, [0, 1], NOW).is_none());
        assert!(ties::apart(&frame, [1, 2], NOW).is_some());
    }
}
