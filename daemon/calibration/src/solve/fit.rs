//! The search: Levenberg and Marquardt's damped steps, with the noise taken from what is left.

use super::arrow::{GlobalBlock, Solution};
use super::parameters::{GLOBALS, State};
use super::problem::{Left, Linearised, Noise, Problem};
use crate::settings::SensorNoise;

const MOST_STEPS: u32 = 60;
/// A step is small enough if it moves nothing by more than this many of its σ.
const SMALL_STEP: f64 = 0.02;
/// Median of χ² with three degrees of freedom.
const MEDIAN_SQUARE: f64 = 2.366;
/// No magnetometer is better, µT; no accelerometer, m/s².
const LEAST_MAG_UT: f64 = 0.02;
const LEAST_ACCEL_M_S2: f64 = 0.002;

/// Where the search ended.
pub(crate) struct Fit {
    pub(crate) state: State,
    pub(crate) noise: Noise,
    /// Covariance of the recording's parameters.
    pub(crate) covariance: GlobalBlock,
    /// What is left of each bin of the magnetometer.
    pub(crate) mag: Vec<Left>,
    pub(crate) iterations: u32,
    /// Whether the last step was small.
    pub(crate) converged: bool,
    /// Twice the negative logarithm of the evidence, but for a constant.
    pub(crate) evidence: f64,
}

/// Searches from a start; `None` if the equations cannot be solved there.
pub(crate) fn search(problem: &Problem<'_>, start: State, noise: Noise) -> Option<Fit> {
    let mut search = Search::new(problem, start, noise);
    let mut iterations = 0;
    let mut converged = false;
    while iterations < MOST_STEPS && !converged {
        iterations += 1;
        converged = search.step()?;
    }
    search.finish(iterations, converged)
}

struct Search<'a> {
    problem: &'a Problem<'a>,
    state: State,
    noise: Noise,
    at: Linearised,
    damping: f64,
}

impl<'a> Search<'a> {
    fn new(problem: &'a Problem<'a>, state: State, noise: Noise) -> Self {
        let at = problem.linearise(&state, &noise);
        Self { problem, state, noise, at, damping: 1e-4 }
    }

    /// One step; whether it was small, taken, and left the noise as it was.
    fn step(&mut self) -> Option<bool> {
        let solution = self.at.arrow.clone().solve(self.damping)?;
        let state = self.state.stepped(&solution.globals, &solution.locals);
        let at = self.problem.linearise(&state, &self.noise);
        if !(at.arrow.cost < self.at.arrow.cost * (1.0 + 1e-9)) {
            self.damping *= 8.0;
            // Nothing better is to be found along a vanishing step.
            return Some(self.damping > 1e8);
        }
        self.damping = (self.damping / 8.0).max(1e-9);
        let (noise, settled) = renewed(&self.noise, &at);
        self.at = if settled { at } else { self.problem.linearise(&state, &noise) };
        self.state = state;
        self.noise = noise;
        Some(settled && is_small(&solution))
    }

    fn finish(self, iterations: u32, converged: bool) -> Option<Fit> {
        let cost = self.at.arrow.cost;
        let solution = self.at.arrow.solve(0.0)?;
        Some(Fit {
            evidence: cost + solution.log_determinant,
            covariance: solution.covariance,
            state: self.state,
            noise: self.noise,
            mag: self.at.mag,
            iterations,
            converged,
        })
    }
}

fn is_small(solution: &Solution) -> bool {
    (0..GLOBALS).all(|i| {
        solution.globals[i].abs() <= SMALL_STEP * solution.covariance[(i, i)].max(0.0).sqrt()
    })
}

/// The noise that the residuals show, and whether it is the one they were weighted with.
fn renewed(noise: &Noise, at: &Linearised) -> (Noise, bool) {
    let mag = spread(&at.mag).max(LEAST_MAG_UT);
    let accel = spread(&at.accel).max(LEAST_ACCEL_M_S2);
    let settled = |new: f64, old: f64| (new / old - 1.0).abs() < 0.01;
    let same = settled(mag, noise.mag) && settled(accel, noise.accel);
    if same { (*noise, true) } else { (Noise { mag, accel, ..*noise }, false) }
}

/// σ of one reading from the median of the squares, which few outliers do not move.
fn spread(left: &[Left]) -> f64 {
    if left.is_empty() {
        return 0.0;
    }
    let mut squares: Vec<f64> = left.iter().map(Left::square).collect();
    let middle = squares.len() / 2;
    let median = *squares.select_nth_unstable_by(middle, f64::total_cmp).1;
    (median / MEDIAN_SQUARE).sqrt()
}

/// Noise before the first look at the residuals.
pub(crate) fn first_noise(sensors: &SensorNoise, mag_ut: f64, interval_s: f64) -> Noise {
    let root_rate = interval_s.max(1e-4).sqrt().recip();
    Noise {
        mag: mag_ut.max(sensors.mag_sigma_ut),
        accel: (sensors.accel_density_m_s2_rthz * root_rate).max(0.05),
        gyro: sensors.gyro_density_rad_s_rthz,
        gyro_walk: sensors.gyro_bias_walk_rad_s2_rthz,
    }
}
