//! A lane's part in the world: it fixes it where it may, and stands in it where that is known.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use lodestone_fusion::{Anchor, Estimate, Estimator, HeadingOrigin, PositionOrigin};
use lodestone_schema::DistanceSource;

use super::anchor::anchor_now;
use super::founding::Founding;
use super::frame::{WorldFrame, WorldPhase};
use crate::reading::HostTime;

/// A place in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// m.
    pub position: DVec3,
    /// m².
    pub covariance: DMat3,
    /// Where it is known from.
    pub source: DistanceSource,
}

/// What a lane knows of its place before it has aligned.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MemberSettings {
    /// What is at the origin if this member fixes the world: its magnetometer, in body axes, m.
    pub origin_in_body_m: DVec3,
    /// Where it stands when it is first aligned.
    pub start: Option<Place>,
    /// Where it was in the last run of the daemon, uncertain by how far it may have been moved.
    pub kept: Option<Place>,
    /// Speed with which it may have been moved while its lane could not see it, 1σ, m/s.
    pub unseen_speed_m_s: f64,
    /// Time at rest that an alignment has seen, s.
    pub alignment_rest_s: f64,
}

/// What a step is in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldStep {
    /// Epoch of the world; 0 while there is none.
    pub epoch: u32,
    /// Where the position is known from.
    pub source: DistanceSource,
}

/// Where the member was when it was last seen.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LastSeen {
    place: Place,
    velocity: DVec3,
    velocity_covariance: DMat3,
    arrival: HostTime,
    epoch: u32,
}

/// A lane's part in the world.
#[derive(Clone, Debug)]
pub struct Membership {
    frame: Arc<WorldFrame>,
    member: u16,
    settings: MemberSettings,
    phase: WorldPhase,
    source: DistanceSource,
    /// What the fix was made with that was heard last.
    fix_source: DistanceSource,
    last: Option<LastSeen>,
    /// It has not been aligned since the world was fixed.
    is_first: bool,
}

impl Membership {
    /// A member of a world that it shares.
    pub fn new(frame: Arc<WorldFrame>, member: usize, settings: MemberSettings) -> Self {
        let phase = frame.phase();
        Self {
            frame,
            member: member as u16,
            settings,
            phase,
            source: DistanceSource::Unknown,
            fix_source: DistanceSource::PositionFix,
            last: None,
            is_first: true,
        }
    }

    /// The only member of a world of its own, which begins where it is aligned.
    pub fn alone(settings: MemberSettings) -> Self {
        Self::new(Arc::new(WorldFrame::waiting(1, 1)), 0, settings)
    }

    /// The world.
    pub const fn frame(&self) -> &Arc<WorldFrame> {
        &self.frame
    }

    /// Follows a step of the filter: fixes the world if it is this member's to fix, and puts the filter
    /// where it stands when it has just been aligned or the world has become another one.
    ///
    /// Whether the world was defined anew: poses before and after do not compare.
    pub fn follow(
        &mut self,
        estimator: &mut Estimator,
        just_aligned: bool,
        arrival: HostTime,
    ) -> bool {
        let seen = self.frame.phase();
        let before = core::mem::replace(&mut self.phase, seen);
        let began_anew = before.epoch != seen.epoch;
        if began_anew {
            // Nothing that was known of the old world holds in the new one.
            (self.last, self.settings.kept, self.is_first) = (None, None, true);
        }
        if estimator.state().is_some()
            && !self.found_if_allowed(estimator, arrival)
            && (just_aligned || before != seen)
        {
            self.stand(estimator, just_aligned, before, arrival);
        }
        began_anew
    }

    fn found_if_allowed(&mut self, estimator: &mut Estimator, arrival: HostTime) -> bool {
        if self.phase.fixed || self.phase.member != Some(self.member) {
            return false;
        }
        let Some(fixed) = self.frame.fix(self.phase, self.starts_hold_with_it()) else {
            return false;
        };
        self.phase = fixed;
        self.is_first = false;
        let place = self.settings.start.unwrap_or_else(|| self.at_origin(estimator));
        self.put(estimator, Some(place));
        if let Some(founding) = self.founding(estimator, arrival) {
            self.frame.report_founding(self.member.into(), &founding);
        }
        true
    }

    /// The place of the body whose magnetometer is in the origin.
    fn at_origin(&self, estimator: &Estimator) -> Place {
        let turn = estimator.state().map_or(DMat3::IDENTITY, |s| s.orientation().matrix());
        Place {
            position: -(turn * self.settings.origin_in_body_m),
            covariance: DMat3::ZERO,
            source: DistanceSource::CommonStart,
        }
    }

    fn founding(&self, estimator: &Estimator, arrival: HostTime) -> Option<Founding> {
        let estimate = estimator.estimate()?;
        let c = &estimate.orientation_covariance;
        Some(Founding {
            epoch: self.phase.epoch,
            time: arrival,
            orientation: estimate.orientation.quaternion(),
            heading_sigma_rad: match estimate.heading_origin {
                HeadingOrigin::Arbitrary => f64::NAN,
                _ => c.z_axis.z.sqrt(),
            },
            tilt_sigma_rad: c.x_axis.x.max(c.y_axis.y).sqrt(),
            field_ut: estimator.expected_field_ut(),
            origin_in_body_m: self.settings.origin_in_body_m,
        })
    }

    /// Puts the filter where the member stands, as far as that is known.
    fn stand(
        &mut self,
        estimator: &mut Estimator,
        just_aligned: bool,
        before: WorldPhase,
        arrival: HostTime,
    ) {
        let phase = self.phase;
        if !just_aligned && before.epoch == phase.epoch && phase.starts_hold {
            // The world that was waited for is there, and the start that was taken holds in it.
            return;
        }
        let seen = self.last.filter(|last| just_aligned && last.epoch == phase.epoch);
        let seen = seen.map(|last| self.after_absence(&last, arrival));
        let kept = self.settings.kept.take_if(|_| phase.fixed);
        let start = self.settings.start.filter(|_| self.is_first && phase.starts_hold);
        self.put(estimator, seen.or(kept).or(start));
        self.is_first = self.is_first && !phase.fixed;
    }

    /// Whether configured starts are places in a world that this member fixes: the first one's is the
    /// one that they are meant for, and one with a start of its own makes it the same.
    const fn starts_hold_with_it(&self) -> bool {
        self.member == 0 || self.settings.start.is_some()
    }

    fn put(&mut self, estimator: &mut Estimator, place: Option<Place>) {
        match place {
            Some(place) => estimator.place(place.position, place.covariance),
            None => estimator.forget_place(),
        }
        self.source = place.map_or(DistanceSource::Unknown, |place| place.source);
    }

    /// Where the member was, uncertain by how far it may have come since: at the speed it had, and at
    /// one with which it may have been moved. The alignment has seen it standing for a part of the time.
    fn after_absence(&self, last: &LastSeen, arrival: HostTime) -> Place {
        let away_s = (arrival.as_nanos() - last.arrival.as_nanos()) as f64 * 1e-9;
        let away_s = (away_s - self.settings.alignment_rest_s).max(0.0);
        let unseen = self.settings.unseen_speed_m_s;
        let speeds = last.velocity * last.velocity + DVec3::splat(unseen * unseen);
        let moved = last.velocity_covariance + DMat3::from_diagonal(speeds);
        Place { covariance: last.place.covariance + moved * (away_s * away_s), ..last.place }
    }

    /// The member that this one is measured against, as it is now, and the time of its pose, ns; `None` if it
    /// cannot be followed.
    pub fn anchor(&self, anchor: u16, now: HostTime) -> Option<(Anchor, i64)> {
        anchor_now(&self.frame, anchor, now)
    }

    /// Takes note of what a fix that was heard was made with: where it is used, that is where the position
    /// is known from.
    pub const fn hear_fix(&mut self, source: DistanceSource) {
        self.fix_source = source;
    }

    /// Takes note of where the member is after a step, for when its lane has lost it, and says what the
    /// step is in the world.
    pub fn note(&mut self, estimate: Option<&Estimate>, arrival: HostTime) -> WorldStep {
        match estimate.filter(|estimate| estimate.is_position_known()) {
            Some(estimate) => self.note_known(estimate, arrival),
            None => self.source = DistanceSource::Unknown,
        }
        WorldStep { epoch: self.phase.published_epoch(), source: self.source }
    }

    fn note_known(&mut self, estimate: &Estimate, arrival: HostTime) {
        self.source = match estimate.position_origin {
            PositionOrigin::PositionFix | PositionOrigin::PoseFix => self.fix_source,
            PositionOrigin::Gradient => DistanceSource::MagneticGradient,
            _ => self.source,
        };
        let place = Place {
            position: estimate.position,
            covariance: estimate.position_covariance,
            source: self.source,
        };
        self.last = Some(LastSeen {
            place,
            velocity: estimate.velocity,
            velocity_covariance: estimate.velocity_covariance,
            arrival,
            epoch: self.phase.epoch,
        });
    }
}
