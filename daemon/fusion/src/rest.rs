//! Standstill by the likelihood of a sliding window of angular rate and specific force.
//!
//! The hypothesis is that the camera stood during the whole window: its rate is the gyroscope's bias, its
//! specific force a constant vector as long as gravity. The statistic is the generalised likelihood
//! ratio of that against any motion (Skog, Händel, Nilsson, Rantakokko 2010, the stance hypothesis
//! optimal detector), the direction of gravity being estimated along, for each sample:
//!
//! ```text
//! T = 1/N Σ ( |f − g f̄ / |f̄||² / σ_a² + |ω − b|² / σ_ω² )
//!   = s_f² / σ_a² + (|f̄| − g)² / σ_a² + s_ω² / σ_ω² + |ω̄ − b|² / σ_ω²
//! ```
//!
//! with s² the mean squares about the means. In the second form a bias that is known only to a
//! standard deviation `σ_b` widens the terms of the means to `σ² + N σ_b²`, as integrating it out does: a
//! biased sensor at rest is at rest.
//!
//! The window is a ring of short blocks with sums and sums of squares, so a step costs a few
//! additions.

use glam::DVec3;

use crate::grid::Increment;
use crate::parameters::{RestParameters, Stillness};

/// Blocks in the window.
const BLOCKS: usize = 10;

#[derive(Clone, Copy, Debug, PartialEq)]
struct Sums {
    count: f64,
    rate: DVec3,
    rate_square: f64,
    force: DVec3,
    force_square: f64,
}

impl Sums {
    const ZERO: Self = Self {
        count: 0.0,
        rate: DVec3::ZERO,
        rate_square: 0.0,
        force: DVec3::ZERO,
        force_square: 0.0,
    };

    fn add(&mut self, other: &Self) {
        self.count += other.count;
        self.rate += other.rate;
        self.rate_square += other.rate_square;
        self.force += other.force;
        self.force_square += other.force_square;
    }
}

/// Mean and spread over a full window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindowStatistics {
    /// Length of the window, s.
    pub span_s: f64,
    /// Number of steps in it.
    pub count: f64,
    /// Mean angular rate, rad/s.
    pub rate: DVec3,
    /// Mean angular rate over the window's first block, which the rest of the window confirms,
    /// rad/s.
    pub confirmed_rate: DVec3,
    /// Mean specific force, m/s².
    pub force: DVec3,
    /// Standard deviation of the angular rate, all axes together, rad/s.
    pub rate_deviation: f64,
    /// Standard deviation of the specific force, all axes together, m/s².
    pub force_deviation: f64,
}

/// What a standing camera would show, and how well that is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing {
    /// Gyroscope bias, rad/s.
    pub gyro_bias: DVec3,
    /// Its standard deviation, the worst axis, rad/s.
    pub gyro_bias_sigma: f64,
    /// Size of the specific force: gravity, m/s².
    pub force: f64,
    /// Standard deviation of what the accelerometer makes of it, m/s².
    pub force_sigma: f64,
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
    pub fn push(&mut self, increment: &Increment, window_s: f64) -> Option<WindowStatistics> {
        let per_second = increment.span_s.recip();
        let rate = increment.angle * per_second;
        let force = increment.velocity * per_second;
        self.open.add(&Sums {
            count: 1.0,
            rate,
            rate_square: rate.length_squared(),
            force,
            force_square: force.length_squared(),
        });
        self.open_span_s += increment.span_s;
        // Half a step of tolerance: a block is the whole number of steps that is nearest.
        if self.open_span_s + 0.5 * increment.span_s < window_s / BLOCKS as f64 {
            return None;
        }
        self.close_block();
        (self.filled == BLOCKS).then(|| self.statistics(window_s))
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
        let rate_variance = all.rate_square * per_count - rate.length_squared();
        let force_variance = all.force_square * per_count - force.length_squared();
        // The next block to be overwritten is the oldest.
        let oldest = &self.blocks[self.next];
        WindowStatistics {
            span_s,
            count: all.count,
            rate,
            confirmed_rate: oldest.rate * oldest.count.recip(),
            force,
            rate_deviation: libm::sqrt(rate_variance.max(0.0)),
            force_deviation: libm::sqrt(force_variance.max(0.0)),
        }
    }
}

impl Default for RestDetector {
    fn default() -> Self {
        Self::new()
    }
}

impl WindowStatistics {
    /// The parts of the statistic that the spread of rate and of force have in it.
    pub fn spread(&self, still: &Stillness) -> (f64, f64) {
        (
            square(self.rate_deviation / still.rate_sigma_rad_s),
            square(self.force_deviation / still.force_sigma_m_s2),
        )
    }

    /// The statistic T against a standing camera; 6 where all six sensors scatter as much as said.
    pub fn statistic(&self, standing: &Standing, still: &Stillness) -> f64 {
        let (by_rate, by_force) = self.spread(still);
        let widened = |sigma: f64, of_bias: f64| square(sigma) + self.count * square(of_bias);
        let turn = self.rate - standing.gyro_bias;
        let excess = libm::sqrt(self.force.length_squared()) - standing.force;
        let by_turn =
            turn.length_squared() / widened(still.rate_sigma_rad_s, standing.gyro_bias_sigma);
        let by_excess = square(excess) / widened(still.force_sigma_m_s2, standing.force_sigma);
        by_rate + by_force + by_turn + by_excess
    }

    /// Whether the camera stands: the statistic below its threshold, and no turn beyond the bias.
    pub fn is_rest(&self, standing: &Standing, p: &RestParameters) -> bool {
        let turn = (self.rate - standing.gyro_bias).abs().max_element();
        turn < p.mean_rate_rad_s.max(3.0 * standing.gyro_bias_sigma)
            && self.statistic(standing, &p.stillness) < p.threshold
    }
}

fn square(x: f64) -> f64 {
    x * x
}

#[cfg(test)]
mod tests;
