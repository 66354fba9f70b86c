//! A rig's building blocks, for benches alone.

use super::estimator::RigParameters;
use super::geometry::{Geometry, MAX_MEMBERS};
use super::virtual_imu::{Inertial, VirtualImu};
use super::voting::{Given, Voting};
use crate::grid::{Increment, Step};

/// A rig's vote and virtual IMU, taken apart.
#[derive(Clone, Copy, Debug)]
pub struct RigBlocks {
    geometry: Geometry,
    virtual_imu: VirtualImu,
    voting: Voting,
}

impl RigBlocks {
    /// The blocks of a rig of this geometry.
    pub fn new(geometry: Geometry, parameters: &RigParameters) -> Self {
        let voting = Voting::new(geometry.count(), parameters.voting);
        Self { geometry, virtual_imu: VirtualImu::new(), voting }
    }

    /// One step through the virtual IMU, in which everybody counts.
    pub fn virtual_imu(&mut self, steps: &[Option<Step>; MAX_MEMBERS]) -> Option<Increment> {
        let members = self.members(steps);
        let span_s = steps.iter().flatten().next()?.increment.span_s;
        let admitted = members.map(|member| member.is_some());
        let fused = self.virtual_imu.fuse(&members, admitted, &self.geometry, span_s)?;
        self.virtual_imu.learn(&members, admitted, &self.geometry, &fused);
        Some(fused)
    }

    /// One vote on who counts; how many do.
    pub fn vote(&mut self, steps: &[Option<Step>; MAX_MEMBERS]) -> Option<usize> {
        let span_s = steps.iter().flatten().next()?.increment.span_s;
        let centred = self.virtual_imu.centred(&self.members(steps), &self.geometry);
        let given = core::array::from_fn(|k| Given {
            centred: centred[k],
            present: steps[k].is_some(),
            saturated: false,
            known: self.virtual_imu.knows(k),
            arm_m: libm::sqrt(self.geometry.imu_arm_m(k).length_squared()),
        });
        let admitted = self.voting.hold(&given, self.virtual_imu.swing_rad_s2(), span_s);
        Some(admitted.iter().filter(|counts| **counts).count())
    }

    fn members(&self, steps: &[Option<Step>; MAX_MEMBERS]) -> [Option<Inertial>; MAX_MEMBERS] {
        let mut members = [None; MAX_MEMBERS];
        for (k, step) in steps.iter().enumerate().take(self.geometry.count()) {
            members[k] = step.as_ref().and_then(|s| Inertial::of(s, &self.geometry, k));
        }
        members
    }
}
