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

/// An anchor as it is now, if it is one.
pub(super) fn anchor_now(frame: &WorldFrame, anchor: u16, now: HostTime) -> Option<Anchor> {
    let motion = present(frame, anchor.into(), now).ok()?;
    Some(anchor_of(anchor, &motion, 0.0))
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
