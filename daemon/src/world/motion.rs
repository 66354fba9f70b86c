//! Where a member is and how it moves, as its lane reports it for relative poses and for the file.

use glam::{DMat3, DQuat, DVec3};
use lodestone_fusion::relative::{FieldTie, Station};
use lodestone_fusion::{Estimate, HeadingOrigin, Rotation};
use lodestone_schema::DistanceSource;

use super::membership::WorldStep;

/// Number of 64-bit words of a [`Motion`].
pub(super) const WORDS: usize = 39;

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
        }
    }

    pub(super) fn to_words(self) -> [u64; WORDS] {
        let s = &self.station;
        let mut words = Words { words: [0; WORDS], next: 0 };
        // Valid from 1 on, so that a blank report is none.
        let flags = 1 | u64::from(self.heading_known) << 1 | u64::from(self.source.code()) << 8;
        words.put(flags | u64::from(self.epoch) << 32);
        words.put(self.time_ns.cast_unsigned());
        for number in s.orientation.quaternion().to_array() {
            words.number(number);
        }
        for vector in [s.angular_rate, s.position, s.velocity, s.field.with_orientation_rad2] {
            for number in vector.to_array() {
                words.number(number);
            }
        }
        for matrix in [s.orientation_covariance, s.position_covariance, s.velocity_covariance] {
            for number in triangle(matrix) {
                words.number(number);
            }
        }
        words.number(s.field.variance_rad2);
        words.number(s.field.prior_variance_rad2);
        words.number(s.field.way_m);
        words.words
    }

    /// `None` while nothing was reported.
    pub(super) fn from_words(words: &[u64; WORDS]) -> Option<Self> {
        let flags = words[0];
        let source = DistanceSource::from_code((flags >> 8) as u8)?;
        let number = |at: usize| f64::from_bits(words[at]);
        let three = |at: usize| DVec3::new(number(at), number(at + 1), number(at + 2));
        let matrix = |at: usize| symmetric(core::array::from_fn(|k| number(at + k)));
        let orientation = DQuat::from_xyzw(number(2), number(3), number(4), number(5));
        let station = Station {
            orientation: Rotation::from_quaternion(orientation)?,
            angular_rate: three(6),
            position: three(9),
            velocity: three(12),
            orientation_covariance: matrix(18),
            position_covariance: matrix(24),
            velocity_covariance: matrix(30),
            field: FieldTie {
                with_orientation_rad2: three(15),
                variance_rad2: number(36),
                prior_variance_rad2: number(37),
                way_m: number(38),
            },
        };
        (flags & 1 == 1).then_some(Self {
            time_ns: words[1].cast_signed(),
            epoch: (flags >> 32) as u32,
            heading_known: flags & 2 != 0,
            source,
            station,
        })
    }
}

struct Words {
    words: [u64; WORDS],
    next: usize,
}

impl Words {
    fn put(&mut self, word: u64) {
        self.words[self.next] = word;
        self.next += 1;
    }

    fn number(&mut self, number: f64) {
        self.put(number.to_bits());
    }
}

/// `xx xy xz yy yz zz`.
pub(super) const fn triangle(m: DMat3) -> [f64; 6] {
    [m.x_axis.x, m.y_axis.x, m.z_axis.x, m.y_axis.y, m.z_axis.y, m.z_axis.z]
}

fn symmetric([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> DMat3 {
    DMat3::from_cols(DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz))
}

#[cfg(test)]
mod tests {
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
                velocity_covariance: matrix(3.0),
                field: FieldTie {
                    with_orientation_rad2: DVec3::new(10.0, 11.0, 12.0),
                    variance_rad2: 13.0,
                    prior_variance_rad2: 14.0,
                    way_m: 15.0,
                },
            },
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
