//! One virtual IMU at the filter point out of the members' steps.
//!
//! Rates and forces are turned into the rig's axes and averaged (Skog, Nilsson, Händel, "Inertial sensor
//! arrays, a tutorial", 2016). A member at `l` feels `f + α × l + ω × (ω × l)`; over all members, equally
//! weighted, that is `f`. Where some are missing, the mean arm `l̄` of the rest remains, and its
//! terms are taken off, so that the point does not jump.
//!
//! Biases differ between members. What a member reads beside the mean of all is learnt slowly and taken
//! off: with all members the offsets add up to nothing; when one leaves, the mean goes on without a step.

use glam::DVec3;

use super::geometry::{Geometry, MAX_MEMBERS};
use crate::grid::{Increment, Step};

/// One member's rate and force, rig's axes, rad/s and m/s².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Inertial {
    pub(crate) rate: DVec3,
    pub(crate) force: DVec3,
}

impl Inertial {
    /// A member's step in the rig's axes; nothing if it is no step or not finite.
    pub(crate) fn of(step: &Step, geometry: &Geometry, member: usize) -> Option<Self> {
        let increment = &step.increment;
        let turn = geometry.mounting(member).rotation;
        let per_second = increment.span_s.recip();
        let rate = turn.apply(increment.angle) * per_second;
        let force = turn.apply(increment.velocity) * per_second;
        (rate.is_finite() && force.is_finite()).then_some(Self { rate, force })
    }

    pub(crate) fn plus(self, other: Self, weight: f64) -> Self {
        Self { rate: self.rate + other.rate * weight, force: self.force + other.force * weight }
    }
}

/// Time over which offsets between members are learnt, s: long against motion, short against the
/// walk of biases.
const OFFSET_S: f64 = 20.0;
/// Time after which an offset is known, s.
const KNOWN_S: f64 = 0.5;
/// Largest offset that a member's biases explain, rad/s and m/s².
const MOST_RATE_RAD_S: f64 = 0.05;
const MOST_FORCE_M_S2: f64 = 0.6;
/// Smoothing of the rate before its change counts as angular acceleration, s. Its lag moves no velocity
/// for good: what it takes off is a difference of rates.
const SMOOTH_S: f64 = 0.01;

/// The state of the virtual IMU.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct VirtualImu {
    offsets: [Inertial; MAX_MEMBERS],
    learnt_s: [f64; MAX_MEMBERS],
    smooth_rate: Option<DVec3>,
    /// Angular acceleration in the last step, rad/s².
    acceleration: DVec3,
}

impl VirtualImu {
    pub(crate) const fn new() -> Self {
        Self {
            offsets: [Inertial { rate: DVec3::ZERO, force: DVec3::ZERO }; MAX_MEMBERS],
            learnt_s: [0.0; MAX_MEMBERS],
            smooth_rate: None,
            acceleration: DVec3::ZERO,
        }
    }

    /// What members would read at the filter point, offsets taken off: comparable with each other.
    pub(crate) fn centred(
        &self,
        members: &[Option<Inertial>; MAX_MEMBERS],
        geometry: &Geometry,
    ) -> [Option<Inertial>; MAX_MEMBERS] {
        let rate = self.smooth_rate.unwrap_or(DVec3::ZERO);
        let mut centred = [None; MAX_MEMBERS];
        for (k, member) in members.iter().enumerate() {
            centred[k] = member.map(|read| {
                let own = read.plus(self.offsets[k], -1.0);
                let felt = lever_arm(rate, self.acceleration, geometry.imu_arm_m(k));
                Inertial { force: own.force - felt, ..own }
            });
        }
        centred
    }

    /// The mean of the members that are in, as one increment at the filter point.
    pub(crate) fn fuse(
        &mut self,
        members: &[Option<Inertial>; MAX_MEMBERS],
        admitted: [bool; MAX_MEMBERS],
        geometry: &Geometry,
        span_s: f64,
    ) -> Option<Increment> {
        let (mut mean, mut arm, mut count) = (Inertial::default(), DVec3::ZERO, 0.0);
        for (k, read) in members.iter().enumerate() {
            let Some(read) = read.filter(|_| admitted[k]) else { continue };
            mean = mean.plus(read.plus(self.offsets[k], -1.0), 1.0);
            arm += geometry.imu_arm_m(k);
            count += 1.0;
        }
        if count < 1.0 {
            self.smooth_rate = None;
            return None;
        }
        let rate = mean.rate / count;
        self.accelerate(rate, span_s);
        let force = mean.force / count - lever_arm(rate, self.acceleration, arm / count);
        Some(Increment { span_s, angle: rate * span_s, velocity: force * span_s })
    }

    /// Learns what members read beside the virtual IMU.
    pub(crate) fn learn(
        &mut self,
        members: &[Option<Inertial>; MAX_MEMBERS],
        admitted: [bool; MAX_MEMBERS],
        geometry: &Geometry,
        fused: &Increment,
    ) {
        let span_s = fused.span_s;
        let (rate, force) = (fused.angle / span_s, fused.velocity / span_s);
        for (k, read) in members.iter().enumerate() {
            // One that never counted yet is got to know first.
            let known = self.knows(k);
            let Some(read) = read.filter(|_| admitted[k] || !known) else { continue };
            self.learnt_s[k] = (self.learnt_s[k] + span_s).min(OFFSET_S);
            let felt = lever_arm(rate, self.acceleration, geometry.imu_arm_m(k));
            let beside = Inertial { rate: read.rate - rate, force: read.force - felt - force };
            let share = span_s / self.learnt_s[k];
            let offset = self.offsets[k].plus(beside.plus(self.offsets[k], -1.0), share);
            self.offsets[k] = Inertial {
                rate: offset.rate.clamp_length_max(MOST_RATE_RAD_S),
                force: offset.force.clamp_length_max(MOST_FORCE_M_S2),
            };
        }
    }

    /// Angular acceleration in the last step, rad/s².
    pub(crate) const fn acceleration(&self) -> DVec3 {
        self.acceleration
    }

    /// Size of the angular acceleration in the last step, rad/s².
    pub(crate) fn swing_rad_s2(&self) -> f64 {
        libm::sqrt(self.acceleration.length_squared())
    }

    /// Whether a member's usual offset is known.
    pub(crate) fn knows(&self, member: usize) -> bool {
        self.learnt_s[member] >= KNOWN_S
    }

    fn accelerate(&mut self, rate: DVec3, span_s: f64) {
        let before = self.smooth_rate.unwrap_or(rate);
        let smooth = before + (rate - before) * (span_s / (span_s + SMOOTH_S));
        self.acceleration = (smooth - before) / span_s;
        self.smooth_rate = Some(smooth);
    }
}

/// What an accelerometer at `arm` feels beside one at the filter point, m/s².
pub(crate) fn lever_arm(rate: DVec3, acceleration: DVec3, arm: DVec3) -> DVec3 {
    acceleration.cross(arm) + rate.cross(rate.cross(arm))
}
