//! What stereo makes of a true depth: noise, a range, and points without depth.

use lodestone_config::model::Depth;
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

/// The errors of a stereo camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stereo {
    sigma_per_m: f32,
    min_m: f32,
    max_m: f32,
    /// Square of the sine of the least angle between ray and surface.
    grazing: f32,
    /// Logarithm of the probability that a point is kept.
    log_kept: f64,
    seed: u64,
}

/// The draws of one cloud.
#[derive(Clone, Debug)]
pub(super) struct Draws {
    /// Fast rather than portable: clouds need not be the same to the bit on every machine.
    generator: SmallRng,
    /// Points until the next one is lost.
    until_lost: u64,
}

impl Stereo {
    /// `camera` tells cameras with the same seed apart.
    pub(super) fn new(settings: &Depth, camera: u64) -> Self {
        Self {
            sigma_per_m: settings.sigma_per_m as f32,
            min_m: settings.min_m as f32,
            max_m: settings.max_m as f32,
            grazing: settings.grazing_deg.to_radians().sin().powi(2) as f32,
            log_kept: (1.0 - settings.drop_probability).ln(),
            seed: mixed(mixed(settings.seed) ^ camera),
        }
    }

    /// Begins a cloud; the same number gives the same draws.
    pub(super) fn begin(&self, cloud: u64) -> Draws {
        let generator = SmallRng::seed_from_u64(mixed(self.seed ^ mixed(cloud)));
        let mut draws = Draws { generator, until_lost: 0 };
        draws.until_lost = self.gap(&mut draws.generator);
        draws
    }

    /// The measured depth, m, of a surface at a depth; `None` where there is none. `along_normal` is the
    /// ray along the surface's normal, `length_squared` the square of its length for a metre of depth.
    pub(super) fn measure(
        &self,
        draws: &mut Draws,
        depth_m: f32,
        along_normal: f32,
        length_squared: f32,
    ) -> Option<f32> {
        if draws.until_lost == 0 {
            draws.until_lost = self.gap(&mut draws.generator);
            return None;
        }
        draws.until_lost -= 1;
        let in_range = depth_m >= self.min_m && depth_m <= self.max_m;
        if !in_range || along_normal * along_normal < self.grazing * length_squared {
            return None;
        }
        let normal: f32 = StandardNormal.sample(&mut draws.generator);
        let measured = depth_m + self.sigma_per_m * depth_m * depth_m * normal;
        (measured > 0.0).then_some(measured)
    }

    /// How many points are kept until one is lost: geometric, so that only what is lost is drawn.
    fn gap(&self, generator: &mut SmallRng) -> u64 {
        if self.log_kept >= 0.0 {
            return u64::MAX;
        }
        let uniform: f64 = generator.random();
        // ln 0 is −∞: where every point is lost, none is kept.
        ((1.0 - uniform).ln() / self.log_kept) as u64
    }
}

/// Mixes the bits of a number (`SplitMix64`, Steele et al. 2014).
const fn mixed(number: u64) -> u64 {
    let z = number.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}
