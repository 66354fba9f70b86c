//! Where each member of a rig sits.
//!
//! The rig has a body frame of its own, in which its members' poses are surveyed. Everything in it is
//! reckoned from the filter point: the centroid of the members' IMUs, where the lever-arm terms of
//! the mean cancel, because both `α × l` and `ω × (ω × l)` are linear in `l`.

use glam::DVec3;

use super::derive::Point;
use crate::frame::{Body, Rotation, Vehicle};

/// Most cameras of one rig.
pub const MAX_MEMBERS: usize = 8;

/// One member's pose on the rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mounting {
    /// Member's body axes to the rig's.
    pub rotation: Rotation<Vehicle, Body>,
    /// Position of its IMU in the rig's axes, m.
    pub imu_m: DVec3,
    /// Position of its magnetometer in the rig's axes, m.
    pub magnetometer_m: DVec3,
}

impl Mounting {
    /// A member whose sensors share one place: the origin, its axes the rig's.
    pub const CENTRED: Self =
        Self { rotation: Rotation::IDENTITY, imu_m: DVec3::ZERO, magnetometer_m: DVec3::ZERO };
}

/// Why members make no rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GeometryError {
    /// None, or too many.
    #[error("{0} members; allowed: 1 to {MAX_MEMBERS}")]
    Count(usize),
    /// A position is NaN or infinite.
    #[error("member {0}: its position is not finite")]
    NotFinite(usize),
}

/// The members' places, reckoned from the filter point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    mountings: [Mounting; MAX_MEMBERS],
    count: usize,
    centroid_m: DVec3,
}

impl Geometry {
    /// Takes the members' poses in the rig's body frame.
    ///
    /// # Errors
    /// [`GeometryError`] for no, too many or impossible members.
    pub fn new(members: &[Mounting]) -> Result<Self, GeometryError> {
        if members.is_empty() || members.len() > MAX_MEMBERS {
            return Err(GeometryError::Count(members.len()));
        }
        let finite = |m: &Mounting| m.imu_m.is_finite() && m.magnetometer_m.is_finite();
        if let Some(index) = members.iter().position(|m| !finite(m)) {
            return Err(GeometryError::NotFinite(index));
        }
        let mut mountings = [Mounting::CENTRED; MAX_MEMBERS];
        mountings[..members.len()].copy_from_slice(members);
        let sum: DVec3 = members.iter().map(|m| m.imu_m).sum();
        let centroid_m = sum / members.len() as f64;
        Ok(Self { mountings, count: members.len(), centroid_m })
    }

    /// Number of members.
    pub const fn count(&self) -> usize {
        self.count
    }

    /// The filter point in the rig's axes, m.
    pub const fn centroid_m(&self) -> DVec3 {
        self.centroid_m
    }

    /// A member's pose on the rig.
    pub const fn mounting(&self, member: usize) -> &Mounting {
        &self.mountings[member]
    }

    /// From the filter point to a member's IMU, rig's axes, m.
    pub fn imu_arm_m(&self, member: usize) -> DVec3 {
        self.mountings[member].imu_m - self.centroid_m
    }

    /// The rig's origin, with the rig's axes.
    pub fn origin(&self) -> Point {
        Point { arm_m: -self.centroid_m, rotation: Rotation::IDENTITY }
    }

    /// A member's IMU, with the member's axes.
    pub fn member(&self, member: usize) -> Point {
        Point { arm_m: self.imu_arm_m(member), rotation: self.mountings[member].rotation }
    }

    /// From the filter point to a member's magnetometer, rig's axes, m.
    pub fn magnetometer_arm_m(&self, member: usize) -> DVec3 {
        self.mountings[member].magnetometer_m - self.centroid_m
    }

    /// Square of the second largest spread of the magnetometers over its count, m²: how far from a line
    /// they are. Zero if they are collinear, when no gradient can be told.
    pub fn breadth_m2(&self) -> f64 {
        let arms = (0..self.count).map(|k| self.mountings[k].magnetometer_m);
        let mean = arms.clone().sum::<DVec3>() / self.count as f64;
        let mut spread = glam::DMat3::ZERO;
        for arm in arms {
            let d = arm - mean;
            spread += glam::DMat3::from_cols(d * d.x, d * d.y, d * d.z);
        }
        super::symmetric::eigen(spread).values.y / self.count as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64, z: f64) -> Mounting {
        let place = DVec3::new(x, y, z);
        Mounting { imu_m: place, magnetometer_m: place, ..Mounting::CENTRED }
    }

    #[test]
    fn the_arms_of_all_members_cancel() {
        let g = Geometry::new(&[at(1.0, 0.2, 0.0), at(0.3, -0.7, 0.4), at(2.0, 0.0, 1.0)]).unwrap();
        let sum: DVec3 = (0..3).map(|k| g.imu_arm_m(k)).sum();
        assert!(sum.length() < 1e-14);
    }

    #[test]
    fn magnetometers_in_a_line_have_no_breadth() {
        let line = [at(0.0, 0.0, 0.0), at(0.5, 0.5, 0.0), at(1.0, 1.0, 0.0)];
        assert!(Geometry::new(&line).unwrap().breadth_m2() < 1e-12);
        let triangle = [at(0.0, 0.0, 0.0), at(0.5, 0.0, 0.0), at(0.25, 0.433, 0.0)];
        assert!((Geometry::new(&triangle).unwrap().breadth_m2() - 0.0417).abs() < 1e-3);
    }

    #[test]
    fn no_members_too_many_and_impossible_ones_are_refused() {
        assert_eq!(Geometry::new(&[]), Err(GeometryError::Count(0)));
        assert_eq!(Geometry::new(&[Mounting::CENTRED; 9]), Err(GeometryError::Count(9)));
        let wrong = [Mounting::CENTRED, at(f64::NAN, 0.0, 0.0)];
        assert_eq!(Geometry::new(&wrong), Err(GeometryError::NotFinite(1)));
    }
}
