//! Where a member is and how it moves, as its lane reports it for relative poses and for the file.

use glam::DQuat;
use lodestone_fusion::relative::{FieldTie, Station};
use lodestone_fusion::{Drift, Estimate, HeadingOrigin, Rotation};
use lodestone_schema::DistanceSource;

use super::membership::WorldStep;
use super::words::{DRIFT, Put, Take, triangle};

/// Number of 64-bit words of a [`Motion`].
pub(super) const WORDS: usize = 39 + DRIFT;

/// One member at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Time of validity, `CLOCK_MONOTONIC`, ns.
    pub time_ns: i64,
    /// Epoch of the world; 0 while there is none.
    pub epoch: u32,
    /// Whether the heading counts from north and not from the start.
    pub heading_known: bool,
    /// Where the position is known from.
    pub source: DistanceSource,
    /// Pose, motion and covariances.
    pub station: Station,
    /// How far its errors have moved on.
    pub drift: Drift,
}

impl Motion {
    /// Takes what a relative pose needs out of an estimate.
    pub fn of(estimate: &Estimate, time_ns: i64, world: &WorldStep) -> Self {
        Self {
            time_ns,
            epoch: world.epoch,
            heading_known: estimate.heading_origin != HeadingOrigin::Arbitrary,
            source: world.source,
            station: estimate.station(),
            drift: estimate.drift,
        }
    }

    pub(super) fn to_words(self) -> [u64; WORDS] {
        let s = &self.station;
        let mut words = Put::new();
        // Valid from 1 on, so that a blank report is none.
        let flags = 1
            | u64::from(self.heading_known) << 1
            | u64::from(s.at_rest) << 2
            | u64::from(self.source.code()) << 8;
        words.word(flags | u64::from(self.epoch) << 32);
        words.word(self.time_ns.cast_unsigned());
        words.numbers(&s.orientation.quaternion().to_array());
        for vector in [s.angular_rate, s.position, s.velocity, s.field.with_orientation_rad2] {
            words.numbers(&vector.to_array());
        }
        for matrix in [s.orientation_covariance, s.position_covariance, s.velocity_covariance] {
            words.numbers(&triangle(matrix));
        }
        words.numbers(&[s.field.variance_rad2, s.field.prior_variance_rad2, s.field.way_m]);
        words.drift(&self.drift);
        words.done()
    }

    /// `None` while nothing was reported.
    pub(super) fn from_words(words: &[u64; WORDS]) -> Option<Self> {
        let mut words = Take::new(words);
        let flags = words.word();
        let source = DistanceSource::from_code((flags >> 8) as u8)?;
        let time_ns = words.word().cast_signed();
        let orientation =
            DQuat::from_xyzw(words.number(), words.number(), words.number(), words.number());
        let [angular_rate, position, velocity, with_orientation_rad2] =
            [(); 4].map(|()| words.vector());
        let [orientation_covariance, position_covariance, velocity_covariance] =
            [(); 3].map(|()| words.symmetric());
        let station = Station {
            orientation: Rotation::from_quaternion(orientation)?,
            angular_rate,
            position,
            velocity,
            at_rest: flags & 4 != 0,
            orientation_covariance,
            position_covariance,
            velocity_covariance,
            field: FieldTie {
                with_orientation_rad2,
                variance_rad2: words.number(),
                prior_variance_rad2: words.number(),
                way_m: words.number(),
            },
        };
        (flags & 1 == 1).then_some(Self {
            time_ns,
            epoch: (flags >> 32) as u32,
            heading_known: flags & 2 != 0,
            source,
            station,
            drift: words.drift(),
        })
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use lodestone_fusion::SensorTime;

    use super::super::words::symmetric;
    use super::*;

    #[test]
    fn a_motion_survives_its_words_and_none_is_none() {
        let matrix = |x: f64| symmetric([x, 0.1, 0.2, x + 1.0, 0.3, x + 2.0]);
        let motion = Motion {
            time_ns: -5,
            epoch: 77,
            heading_known: true,
            source: DistanceSource::PositionFix,
            station: Station {
                orientation: Rotation::from_yaw_pitch_roll(0.3, 0.2, 0.1),
                orientation_covariance: matrix(1.0),
                angular_rate: DVec3::new(1.0, 2.0, 3.0),
                position: DVec3::new(4.0, 5.0, 6.0),
                position_covariance: matrix(2.0),
                velocity: DVec3::new(7.0, 8.0, 9.0),
                at_rest: true,
                velocity_covariance: matrix(3.0),
                field: FieldTie {
                    with_orientation_rad2: DVec3::new(10.0, 11.0, 12.0),
                    variance_rad2: 13.0,
                    prior_variance_rad2: 14.0,
                    way_m: 15.0,
                },
            },
            drift: Drift { way_m: 16.0, ..Drift::new(SensorTime::from_nanos(17)) },
        };
        let back = Motion::from_words(&motion.to_words()).unwrap();
        let turned =
            back.station.orientation.quaternion().dot(motion.station.orientation.quaternion());
        assert!((turned - 1.0).abs() < 1e-15);
        let orientation = motion.station.orientation;
        assert_eq!(Motion { station: Station { orientation, ..back.station }, ..back }, motion);
        assert_eq!(Motion::from_words(&[0; WORDS]), None);
    }
}
