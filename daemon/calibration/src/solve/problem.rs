//! Everything that is known about one recording, linearised at a point of the search.

use glam::{DMat3, DVec3};

use super::arrow::{Arrow, Residual};
use super::parameters::{
    ACCEL, DELAY, FIELD, GLOBALS, GRAVITY, GYRO, GYRO_SLOPE, GlobalStep, HARD, HARD_SLOPE,
    MAG_DELAY, SCALE, SOFT, State,
};
use super::segments::{Integrator, Segment, cut};
use super::turned::{MeanVector, Turned};
use super::{field, force, link};
use crate::settings::{FieldPrior, Settings};
use crate::stream::{Step, Stream};

/// A bin whose squared residual is above this many variances pulls less and less: 99.9 % of
/// undisturbed ones (χ², three degrees of freedom) are below.
const DOUBT: f64 = 16.3;
/// Mean gravity of the earth, and its variation from equator to pole with the error of an
/// accelerometer's scale, m/s².
const GRAVITY_M_S2: (f64, f64) = (9.81, 0.05);
/// Strength of the earth's field anywhere, µT.
const STRENGTH_UT: (f64, f64) = (47.0, 12.0);
/// 1σ of slopes: µT/K and rad/s/K.
const HARD_SLOPE_SIGMA: f64 = 0.5;
const GYRO_SLOPE_SIGMA: f64 = 5e-4;

/// Noise as the fit takes it at the moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Noise {
    /// Of one reading, µT.
    pub(crate) mag: f64,
    /// Of one reading, m/s².
    pub(crate) accel: f64,
    /// By how much more a reading counts for less, because residuals hang together in time.
    pub(crate) mag_colour: f64,
    /// The same for the accelerometer.
    pub(crate) accel_colour: f64,
    /// Whether the accelerometer's figures stay as they are.
    pub(crate) accel_is_known: bool,
    /// Density, rad/s/√Hz.
    pub(crate) gyro: f64,
    /// Density of the bias's random walk, rad/s²/√Hz.
    pub(crate) gyro_walk: f64,
}

/// What is left of one bin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Left {
    /// When, s.
    pub(crate) time_s: f64,
    /// Readings in it.
    pub(crate) count: usize,
    /// Residual of their mean.
    pub(crate) residual: DVec3,
}

impl Left {
    /// The squared residual for a single reading's σ of 1.
    pub(crate) fn square(&self) -> f64 {
        self.residual.length_squared() * self.count as f64
    }
}

/// The equations at a point, and what they leave.
pub(crate) struct Linearised {
    pub(crate) arrow: Arrow,
    pub(crate) mag: Vec<Left>,
    pub(crate) accel: Vec<Left>,
}

/// A recording as a problem.
pub(crate) struct Problem<'a> {
    pub(crate) stream: &'a Stream,
    pub(crate) segments: Vec<Segment>,
    settings: &'a Settings,
    /// Whether the temperature varies enough for slopes.
    pub(crate) has_slopes: bool,
}

impl<'a> Problem<'a> {
    pub(crate) fn new(stream: &'a Stream, settings: &'a Settings) -> Self {
        let least_k = settings.limits.temperature_range_k;
        let has_slopes = stream.temperature_c.is_some_and(|[low, high, _]| high - low >= least_k);
        Self { stream, segments: cut(stream), settings, has_slopes }
    }

    /// Every residual at a point of the search.
    pub(crate) fn linearise(&self, state: &State, noise: &Noise) -> Linearised {
        let mut all =
            Linearised { arrow: Arrow::new(state.knots.len()), mag: Vec::new(), accel: Vec::new() };
        for (k, segment) in self.segments.iter().enumerate() {
            self.add_segment(k, segment, state, noise, &mut all);
        }
        self.add_priors(state, noise, &mut all.arrow);
        all
    }

    fn add_segment(
        &self,
        k: usize,
        segment: &Segment,
        state: &State,
        noise: &Noise,
        all: &mut Linearised,
    ) {
        let (globals, knot) = (&state.globals, &state.knots[k]);
        let steps = &self.stream.steps;
        let mut integrator = Integrator::new(globals, knot, segment);
        let to_knot = knot.attitude.inverse();
        let vectors = (to_knot * globals.field(), to_knot * globals.gravity());
        for bin in &segment.bins {
            let mut sums = BinSums::new(vectors);
            for i in bin.clone() {
                sums.add(&mut integrator, &steps[i], i == segment.samples.start);
            }
            let warmer_k = segment.warmer_k;
            if let Some((mean, reading)) = sums.mag() {
                let r = field::residual(globals, knot, &mean, reading, warmer_k);
                let left = add_doubted(&mut all.arrow, k, r, noise.mag * noise.mag_colour);
                all.mag.push(Left { time_s: steps[bin.start].time_s, ..left });
            }
            if let Some((mean, reading)) = sums.accel() {
                let r = force::residual(globals, knot, &mean, reading, warmer_k);
                let left = add_doubted(&mut all.arrow, k, r, noise.accel * noise.accel_colour);
                all.accel.push(Left { time_s: steps[bin.start].time_s, ..left });
            }
        }
        if let Some(next) = state.knots.get(k + 1) {
            let turn = *integrator.step(&steps[segment.samples.end]);
            let rotation = link::rotation(knot, next, &turn, segment);
            // Through a gap the rate is a guess.
            let spread = (segment.gap_s * segment.gap_s) / segment.duration_s;
            add_link(&mut all.arrow, k, rotation, noise.gyro.powi(2) + spread);
            let bias = link::bias(knot, next, segment);
            add_link(&mut all.arrow, k, bias, noise.gyro_walk.powi(2));
        }
    }

    fn add_priors(&self, state: &State, noise: &Noise, arrow: &mut Arrow) {
        let x = &state.globals.0;
        for (at, mean, sigma) in self.priors() {
            arrow.add_prior(at, x[at] - mean, sigma);
        }
        add_soft_iron_prior(state.globals.soft_iron(), self.settings.noise.soft_iron_sigma, arrow);
        add_field_prior(self.settings.field.as_ref(), x, arrow);
        // The deviations from the recording's bias have no mean of their own.
        let walk = noise.gyro_walk * (self.stream.duration_s() / 3.0).sqrt();
        let mut local = nalgebra::SMatrix::<f64, 3, 6>::zeros();
        local.fixed_columns_mut::<3>(3).fill_with_identity();
        let value = crate::linear::vector(state.knots[0].bias);
        let global = nalgebra::SMatrix::zeros();
        let first = Residual { value, local, global, weight: (walk * walk).recip() };
        arrow.cost += first.value.norm_squared() * first.weight;
        arrow.add(0, &first);
    }

    /// Index, mean and 1σ of every parameter with a prior of its own.
    fn priors(&self) -> Vec<(usize, f64, f64)> {
        let n = &self.settings.noise;
        let delay_s = 0.5 * self.stream.interval_s + 1e-5;
        // Without enough range a slope is held at zero.
        let slope = |sigma: f64| if self.has_slopes { sigma } else { 1e-9 };
        let vectors = [
            (HARD, n.hard_iron_sigma_ut),
            (HARD_SLOPE, slope(HARD_SLOPE_SIGMA)),
            (ACCEL, n.accel_bias_sigma_m_s2),
            (GYRO, n.gyro_bias_sigma_rad_s),
            (GYRO_SLOPE, slope(GYRO_SLOPE_SIGMA)),
            (SCALE, n.gyro_scale_sigma),
        ];
        let mut priors: Vec<(usize, f64, f64)> = vectors
            .iter()
            .flat_map(|&(at, sigma)| (at..at + 3).map(move |i| (i, 0.0, sigma)))
            .collect();
        priors.push((GRAVITY, GRAVITY_M_S2.0, GRAVITY_M_S2.1));
        priors.push((DELAY, 0.0, delay_s));
        priors.push((MAG_DELAY, n.imu_delay_s, n.imu_delay_sigma_s));
        priors
    }
}

/// Each element about the identity; `δ` moves `A` by `A δ`.
fn add_soft_iron_prior(soft_iron: DMat3, sigma: f64, arrow: &mut Arrow) {
    for (i, j) in (0..9).map(|n| (n / 3, n % 3)) {
        let mut by = GlobalStep::zeros();
        for k in 0..3 {
            by[SOFT + 3 * k + j] = soft_iron.col(k)[i];
        }
        arrow.add_global((soft_iron - DMat3::IDENTITY).col(j)[i], &by, sigma);
    }
}

/// Strength and dip, as far as they are known; without any, only that it is the earth's field.
fn add_field_prior(prior: Option<&FieldPrior>, x: &GlobalStep, arrow: &mut Arrow) {
    let (north, down) = (x[FIELD], x[FIELD + 1]);
    let strength = north.hypot(down).max(1.0);
    let mut by = GlobalStep::zeros();
    (by[FIELD], by[FIELD + 1]) = (north / strength, down / strength);
    let (expected, sigma) =
        prior.map_or(STRENGTH_UT, |prior| (prior.strength_ut, prior.strength_sigma_ut));
    arrow.add_global(strength - expected, &by, sigma);
    if let Some(prior) = prior {
        let square = strength * strength;
        (by[FIELD], by[FIELD + 1]) = (-down / square, north / square);
        let error = down.atan2(north) - prior.dip_deg.to_radians();
        arrow.add_global(error, &by, prior.dip_sigma_deg.to_radians());
    }
}

/// Adds a bin's residual, bounded: `ρ(s) = s` up to the doubt `c`, then `2c − c²/s`.
fn add_doubted(arrow: &mut Arrow, k: usize, mut r: Residual<3>, sigma: f64) -> Left {
    let count = r.weight;
    r.weight /= sigma * sigma;
    let square = r.value.norm_squared() * r.weight;
    if square > DOUBT {
        arrow.cost += 2.0 * DOUBT - DOUBT * DOUBT / square;
        r.weight *= (DOUBT / square).powi(2);
    } else {
        arrow.cost += square;
    }
    arrow.add(k, &r);
    Left { time_s: 0.0, count: count as usize, residual: crate::linear::dvec(r.value) }
}

fn add_link(arrow: &mut Arrow, k: usize, mut link: link::Link, variance: f64) {
    link.residual.weight /= variance;
    arrow.cost += link.residual.value.norm_squared() * link.residual.weight;
    arrow.add_link(k, &link.residual, &link.next);
}

/// Sums over one bin.
struct BinSums {
    field: Turned,
    gravity: Turned,
    mag: DVec3,
    accel: DVec3,
}

impl BinSums {
    fn new((field, gravity): (DVec3, DVec3)) -> Self {
        let zero = DVec3::ZERO;
        Self { field: Turned::new(field), gravity: Turned::new(gravity), mag: zero, accel: zero }
    }

    fn add(&mut self, integrator: &mut Integrator, step: &Step, is_knot: bool) {
        let turn = if is_knot { integrator.at_knot(step) } else { integrator.step(step) };
        self.gravity.add(turn);
        self.accel += step.accel;
        if let Some(reading) = step.mag {
            self.field.add(turn);
            self.mag += reading;
        }
    }

    fn mag(&self) -> Option<(MeanVector, DVec3)> {
        self.field.mean().map(|mean| (mean, self.mag / mean.count as f64))
    }

    fn accel(&self) -> Option<(MeanVector, DVec3)> {
        self.gravity.mean().map(|mean| (mean, self.accel / mean.count as f64))
    }
}

const _: () = assert!(MAG_DELAY + 1 == GLOBALS);
