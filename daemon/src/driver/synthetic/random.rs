//! One independent stream of random numbers for each cause, so that switching one error on does
//! not change what is drawn for another.

use glam::DVec3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// What a stream is for. The numbers are part of what a seed means: never reuse one.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Stream {
    Trajectory = 1,
    GyroBias = 2,
    GyroWhite = 3,
    GyroWalk = 4,
    AccelBias = 5,
    AccelWhite = 6,
    AccelWalk = 7,
    MagWhite = 8,
    Jitter = 9,
    Drop = 10,
    Delay = 11,
    ClockOrigin = 12,
    MagFlicker = 13,
    Machines = 14,
}

impl Stream {
    /// This stream of a seed.
    pub(crate) fn of(self, seed: u64) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(self as u64);
        rng
    }
}

/// Three independent draws of the standard normal distribution.
pub(crate) fn normal3(rng: &mut ChaCha8Rng) -> DVec3 {
    let mut draw = || -> f64 { StandardNormal.sample(rng) };
    let (x, y, z) = (draw(), draw(), draw());
    DVec3::new(x, y, z)
}
