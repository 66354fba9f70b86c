//! The search: Levenberg and Marquardt's damped steps, with the noise taken from what is left.

use super::arrow::{GlobalBlock, Solution};
use super::colour;
use super::parameters::{GLOBALS, State};
use super::problem::{Left, Linearised, Noise, Problem};
use crate::settings::SensorNoise;

const MOST_STEPS: u32 = 60;
const FIRST_DAMPING: f64 = 1e-4;
/// The accelerometer counts for this much less at first: accelerations that last, as in a circle
/// driven or on an arm, must show as residuals before attitude and gyro bias can follow them.
const FIRST_ACCEL_COLOUR: f64 = 20.0;
/// A step is small enough if it moves nothing by more than this many of its σ.
const SMALL_STEP: f64 = 0.02;
/// Or if it lowers the squared residuals, in variances, by less than this.
const LITTLE_GAIN: f64 = 0.003;
/// How many times the gyroscope's noise may be what it is meant to be, tried in this order.
const GYRO_NOISE_TRIES: [f64; 8] = [1.5, 2.25, 3.5, 5.0, 8.0, 12.0, 18.0, 27.0];
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
}

/// Searches from a start; `None` if the equations cannot be solved there.
pub(crate) fn search(problem: &Problem<'_>, start: State, noise: Noise) -> Option<Fit> {
    let mut search = Search::new(problem, start, noise);
    search.run()?;
    // Only now is the accelerometer trusted, as far as what is left of it allows.
    let trusted = Noise { accel_colour: 1.0, accel_is_known: true, ..search.noise };
    search.run_with(trusted.coloured(&search.at))?;
    search.run_with(with_likeliest_gyro(problem, &search.state, search.noise)?)?;
    search.run_with(search.noise.coloured(&search.at))?;
    search.finish()
}

/// The noise with the gyroscope's raised as far as the evidence asks for.
///
/// Residuals cannot tell: the attitudes between them are free. The evidence can: it weighs how well
/// neighbouring attitudes fit against how much they may move (Laplace's approximation).
fn with_likeliest_gyro(problem: &Problem<'_>, state: &State, noise: Noise) -> Option<Noise> {
    let mut best = (evidence(problem, state, &noise)?, noise);
    for by in GYRO_NOISE_TRIES {
        let raised = Noise { gyro: noise.gyro * by, gyro_walk: noise.gyro_walk * by, ..noise };
        let cost = evidence(problem, state, &raised)?;
        if cost >= best.0 {
            break;
        }
        best = (cost, raised);
    }
    Some(best.1)
}

/// Twice the negative logarithm of the evidence, but for a constant, after one full step.
fn evidence(problem: &Problem<'_>, state: &State, noise: &Noise) -> Option<f64> {
    let at = problem.linearise(state, noise);
    let step = at.arrow.solve(0.0)?;
    let after = problem.linearise(&state.stepped(&step.globals, &step.locals), noise);
    let cost = after.arrow.cost;
    let links = 3.0 * (state.knots.len() - 1) as f64;
    let width = 2.0 * links * (noise.gyro.ln() + noise.gyro_walk.ln());
    Some(cost + after.arrow.solve(0.0)?.log_determinant + width)
}

struct Search<'a> {
    problem: &'a Problem<'a>,
    state: State,
    noise: Noise,
    at: Linearised,
    damping: f64,
    iterations: u32,
    converged: bool,
}

impl<'a> Search<'a> {
    fn new(problem: &'a Problem<'a>, state: State, noise: Noise) -> Self {
        let at = problem.linearise(&state, &noise);
        Self { problem, state, noise, at, damping: FIRST_DAMPING, iterations: 0, converged: false }
    }

    /// Goes on with other noise, if it is another.
    fn run_with(&mut self, noise: Noise) -> Option<()> {
        if noise == self.noise {
            return Some(());
        }
        self.noise = noise;
        self.at = self.problem.linearise(&self.state, &noise);
        self.damping = FIRST_DAMPING;
        self.run()
    }

    /// Steps until one is small.
    fn run(&mut self) -> Option<()> {
        self.converged = false;
        for _ in 0..MOST_STEPS {
            self.iterations += 1;
            self.converged = self.step()?;
            if self.converged {
                break;
            }
        }
        Some(())
    }

    /// One step; whether it was small, taken, and left the noise as it was.
    fn step(&mut self) -> Option<bool> {
        let solution = self.at.arrow.clone().solve(self.damping)?;
        let state = self.state.stepped(&solution.globals, &solution.locals);
        let at = self.problem.linearise(&state, &self.noise);
        let is_better = at.arrow.cost < self.at.arrow.cost * (1.0 + 1e-9);
        if !is_better {
            self.damping *= 8.0;
            // Nothing better is to be found along a vanishing step.
            return Some(self.damping > 1e8);
        }
        self.damping = (self.damping / 8.0).max(1e-9);
        let gained = self.at.arrow.cost - at.arrow.cost;
        let (noise, settled) = renewed(&self.noise, &at);
        self.at = if settled { at } else { self.problem.linearise(&state, &noise) };
        self.state = state;
        self.noise = noise;
        Some(settled && (gained < LITTLE_GAIN || is_small(&solution)))
    }

    fn finish(self) -> Option<Fit> {
        let solution = self.at.arrow.solve(0.0)?;
        Some(Fit {
            covariance: solution.covariance,
            state: self.state,
            noise: self.noise,
            mag: self.at.mag,
            iterations: self.iterations,
            converged: self.converged,
        })
    }
}

impl Noise {
    /// The noise with the colour of what is left, if that is stronger than its own.
    fn coloured(self, at: &Linearised) -> Self {
        Self {
            mag_colour: colour::factor(&at.mag, self.mag).max(self.mag_colour),
            accel_colour: colour::factor(&at.accel, self.accel).max(self.accel_colour),
            ..self
        }
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
    let accel = if noise.accel_is_known { noise.accel } else { accel };
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
        mag_colour: 1.0,
        accel_colour: FIRST_ACCEL_COLOUR,
        accel_is_known: false,
        gyro: sensors.gyro_density_rad_s_rthz,
        gyro_walk: sensors.gyro_bias_walk_rad_s2_rthz,
    }
}
