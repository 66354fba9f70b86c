//! Standstill by the spread of angular rate and specific force over a sliding window.
//!
//! The window is a ring of short blocks with sums and sums of squares, so a step costs a few
//! additions. Thresholds are on standard deviations within the window, not on the values: a biased
//! sensor at rest is at rest. Compare Skog et al. 2010 (likelihood-ratio detectors).

use glam::DVec3;

use crate::grid::Increment;
use crate::parameters::RestParameters;

/// Blocks in the window.
const BLOCKS: usize = 10;

#[derive(Clone, Copy, Debug, PartialEq)]
struct Sums {
    count: f64,
    rate: DVec3,
    rate_squared: DVec3,
    force: DVec3,
    force_squared: DVec3,
}

impl Sums {
    const ZERO: Self = Self {
        count: 0.0,
        rate: DVec3::ZERO,
        rate_squared: DVec3::ZERO,
        force: DVec3::ZERO,
        force_squared: DVec3::ZERO,
    };

    fn add(&mut self, other: &Self) {
        self.count += other.count;
        self.rate += other.rate;
        self.rate_squared += other.rate_squared;
        self.force += other.force;
        self.force_squared += other.force_squared;
    }
}

/// Mean and spread over a full window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindowStatistics {
    /// Length of the window, s.
    pub span_s: f64,
    /// Mean angular rate, rad/s.
    pub rate: DVec3,
    /// Mean angular rate over the window's first block, which the rest of the window confirms,
    /// rad/s.
    pub confirmed_rate: DVec3,
    /// Mean specific force, m/s².
    pub force: DVec3,
    /// Largest standard deviation of the angular rate over the axes, rad/s.
    pub rate_deviation: f64,
    /// Largest standard deviation of the specific force over the axes, m/s².
    pub force_deviation: f64,
}

/// The detector's state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestDetector {
    blocks: [Sums; BLOCKS],
    open: Sums,
    open_span_s: f64,
    filled: usize,
    next: usize,
}

impl RestDetector {
    /// An empty window.
    pub const fn new() -> Self {
        Self {
            blocks: [Sums::ZERO; BLOCKS],
            open: Sums::ZERO,
            open_span_s: 0.0,
            filled: 0,
            next: 0,
        }
    }

    /// Takes one step. Gives the window's statistics each time a block is complete and the window
    /// is full.
    pub fn push(&mut self, increment: &Increment, p: &RestParameters) -> Option<WindowStatistics> {
        let per_second = increment.span_s.recip();
        let rate = increment.angle * per_second;
        let force = increment.velocity * per_second;
        self.open.add(&Sums {
            count: 1.0,
            rate,
            rate_squared: rate * rate,
            force,
            force_squared: force * force,
        });
        self.open_span_s += increment.span_s;
        if self.open_span_s < p.window_s / BLOCKS as f64 {
            return None;
        }
        self.close_block();
        (self.filled == BLOCKS).then(|| self.statistics(p.window_s))
    }

    fn close_block(&mut self) {
        self.blocks[self.next] = self.open;
        self.next = (self.next + 1) % BLOCKS;
        self.filled = (self.filled + 1).min(BLOCKS);
        self.open = Sums::ZERO;
        self.open_span_s = 0.0;
    }

    fn statistics(&self, span_s: f64) -> WindowStatistics {
        let mut all = Sums::ZERO;
        for block in &self.blocks {
            all.add(block);
        }
        let per_count = all.count.recip();
        let (rate, force) = (all.rate * per_count, all.force * per_count);
        let rate_variance = all.rate_squared * per_count - rate * rate;
        let force_variance = all.force_squared * per_count - force * force;
        // The next block to be overwritten is the oldest.
        let oldest = &self.blocks[self.next];
        WindowStatistics {
            span_s,
            rate,
            confirmed_rate: oldest.rate * oldest.count.recip(),
            force,
            rate_deviation: libm::sqrt(rate_variance.max_element().max(0.0)),
            force_deviation: libm::sqrt(force_variance.max_element().max(0.0)),
        }
    }
}

impl Default for RestDetector {
    fn default() -> Self {
        Self::new()
    }
}

impl WindowStatistics {
    /// Whether the sensors are as quiet as those of a standing camera.
    pub fn is_quiet(&self, p: &RestParameters) -> bool {
        self.rate_deviation < p.rate_deviation_rad_s
            && self.force_deviation < p.force_deviation_m_s2
    }

    /// Whether the camera stands: quiet, and no turn beyond the bias.
    pub fn is_rest(&self, gyro_bias: DVec3, bias_sigma: f64, p: &RestParameters) -> bool {
        let turn = (self.rate - gyro_bias).abs().max_element();
        self.is_quiet(p) && turn < p.mean_rate_rad_s.max(3.0 * bias_sigma)
    }
}
