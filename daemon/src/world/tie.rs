//! What a member says of the one against which it was measured.

use lodestone_fusion::relative::Tied;

use super::words::{DRIFT, Put, Take, triangle};

/// Number of 64-bit words of a [`TieReport`].
pub(super) const WORDS: usize = 2 + 4 * 9 + 4 * 6 + DRIFT;

/// A member's tie at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TieReport {
    /// Of the pose that it goes with, `CLOCK_MONOTONIC`, ns.
    pub(super) time_ns: i64,
    /// Epoch of the world.
    pub(super) epoch: u32,
    pub(super) tied: Tied,
}

impl TieReport {
    pub(super) fn to_words(self) -> [u64; WORDS] {
        let mut words = Put::new();
        // The lowest bit says that there is one: a blank report is none.
        words.word(1 | u64::from(self.tied.anchor) << 16 | u64::from(self.epoch) << 32);
        words.word(self.time_ns.cast_unsigned());
        for matrix in self.tied.shares.as_flattened() {
            words.numbers(&matrix.to_cols_array());
        }
        for matrix in [self.tied.own, self.tied.anchor_covariance].as_flattened() {
            words.numbers(&triangle(*matrix));
        }
        words.drift(&self.tied.mark);
        words.done()
    }

    /// `None` while nothing was reported.
    pub(super) fn from_words(words: &[u64; WORDS]) -> Option<Self> {
        let mut words = Take::new(words);
        let flags = words.word();
        if flags & 1 == 0 {
            return None;
        }
        let time_ns = words.word().cast_signed();
        let shares = [(); 2].map(|()| [(); 2].map(|()| words.matrix()));
        let [own, anchor_covariance] = [(); 2].map(|()| [(); 2].map(|()| words.symmetric()));
        let (anchor, mark) = ((flags >> 16) as u16, words.drift());
        let tied = Tied { anchor, shares, own, anchor_covariance, mark };
        Some(Self { time_ns, epoch: (flags >> 32) as u32, tied })
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};
    use lodestone_fusion::{Drift, SensorTime};

    use super::super::words::symmetric;
    use super::*;

    #[test]
    fn a_tie_survives_its_words_and_none_is_none() {
        let matrix = |x: f64| DMat3::from_cols_array(&core::array::from_fn(|k| x + k as f64));
        let covariance = |x: f64| symmetric(core::array::from_fn(|k| x - k as f64));
        let vector = |x: f64| DVec3::new(x, x + 0.1, x + 0.2);
        let report = TieReport {
            time_ns: -7,
            epoch: 77,
            tied: Tied {
                anchor: 0xfedc,
                shares: [[matrix(1.0), matrix(11.0)], [matrix(21.0), matrix(31.0)]],
                own: [covariance(1.0), covariance(2.0)],
                anchor_covariance: [covariance(3.0), covariance(4.0)],
                mark: Drift {
                    angle_rad2: 1.0,
                    bias_rad: 2.0,
                    way_m: 3.0,
                    turned_rad2: vector(4.0),
                    shifted_m2: vector(5.0),
                    turned_rad: vector(6.0),
                    shifted_m: vector(7.0),
                    ..Drift::new(SensorTime::from_nanos(-9))
                },
            },
        };
        assert_eq!(TieReport::from_words(&report.to_words()), Some(report));
        assert_eq!(TieReport::from_words(&[0; WORDS]), None);
    }
}
