//! Velocity by the gradient of the magnetic field (the paper's `F_s`, soundly).
//!
//! Where steel bends the field, a rig of three or more magnetometers sees both how the field differs
//! over its own width, `G`, and how it changes as the rig moves, `Ḃ + ω × B`; the quotient is the
//! velocity. The [`filter`] solves it; this file opens a window, closes it, and says whether its
//! answer counts: the gate is hard. Each window forgets the velocity first, so that what it says
//! comes from its own readings and can be handed to the pose's filter as news.

use glam::{DMat3, DQuat, DVec3};

mod filter;

use super::geometry::{Geometry, MAX_MEMBERS};
use super::symmetric::{Eigen, eigen};
use crate::grid::Increment;
use crate::so3;
use filter::{FieldFilter, Moved};

/// Parameters of the velocity by gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GradientParameters {
    /// Length of a window, s. Short corrects more often, long averages more noise. Default 0.95.
    pub window_s: f64,
    /// Noise of one magnetometer reading, 1σ, µT, as far as it is independent. Default 0.5.
    pub mag_sigma_ut: f64,
    /// What a calibration leaves of each magnetometer's bias, 1σ, µT, per axis. Large needs stronger
    /// gradients; small believes what is not true. Default 0.7, more than most calibrations leave.
    pub residual_bias_ut: f64,
    /// Walk of that bias, 1σ after one second or after one radian (soft iron), µT. Default 0.01.
    pub bias_walk_ut: f64,
    /// How far the field's curvature walks in a metre at least, 1σ, µT/m². Default 5.
    pub roughness_ut_m2: f64,
    /// The same for each unit of what it is, 1/√m. Default 1.
    pub liveliness_per_m: f64,
    /// Distance over which the polynomial is used, m. Default 0.1.
    pub reach_m: f64,
    /// Unforeseen change of velocity, 1σ after one second, m/s: accelerometer noise, tilt. Default 0.03.
    pub acceleration_density: f64,
    /// Error of a turn, 1σ after one radian, rad. Default 2e-3.
    pub turn_error_rad: f64,
    /// A window starts from the pose filter's velocity, which its answer then does not contain; factor on
    /// that velocity's sigma. Default 2.5.
    pub prior_factor: f64,
    /// Added to it, 1σ, m/s. Default 0.2.
    pub prior_sigma_m_s: f64,
    /// How many times its own noise the gradient must be in a direction that counts. Default 4.
    pub contrast: f64,
    /// Largest standard deviation of the velocity in a direction that counts, m/s. Default 0.25.
    pub max_sigma_m_s: f64,
    /// Largest mean normalised innovation squared of a window's readings. Default 1.6.
    pub max_nis: f64,
    /// Least difference of a reading from what was foreseen that is odd, µT. Default 4.
    pub odd_ut: f64,
    /// Gradient from which the field is not the earth's and tells no heading, µT/m. Default 2.
    pub bent_ut_m: f64,
    /// Least breadth of the magnetometers' array, m. Default 0.05.
    pub min_breadth_m: f64,
    /// Variance of a window's velocity over what the filter says: biases and gradient errors outlive a
    /// window. Default 1.2.
    pub deweight: f64,
}

impl Default for GradientParameters {
    fn default() -> Self {
        Self {
            window_s: 0.95,
            mag_sigma_ut: 0.5,
            residual_bias_ut: 0.7,
            bias_walk_ut: 0.01,
            roughness_ut_m2: 5.0,
            liveliness_per_m: 1.0,
            reach_m: 0.1,
            acceleration_density: 0.03,
            turn_error_rad: 2.0e-3,
            prior_factor: 2.5,
            prior_sigma_m_s: 0.2,
            contrast: 4.0,
            max_sigma_m_s: 0.25,
            max_nis: 1.6,
            odd_ut: 4.0,
            bent_ut_m: 2.0,
            min_breadth_m: 0.05,
            deweight: 1.2,
        }
    }
}

/// Whether the gradient gives a velocity, and why not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GradientVerdict {
    /// No window is complete yet.
    #[default]
    Collecting,
    /// It does, in all directions.
    Open,
    /// It does, but with what was known before it does not hold the velocity in all directions.
    Partial,
    /// Fewer than three magnetometers, or in a line.
    Array,
    /// The gradient is not well above its own noise in any direction.
    Uniform,
    /// The field did not change along the way: the rig stands, or the field is its own.
    Still,
    /// The field does not fit a smooth one.
    Rough,
    /// A magnetometer's bias is not what a calibration leaves.
    Uncalibrated,
    /// It contradicts the pose's filter.
    Contradicted,
}

impl GradientVerdict {
    /// Whether the window's velocity corrected the filter.
    pub const fn is_used(self) -> bool {
        matches!(self, Self::Open | Self::Partial)
    }
}

/// What a window found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GradientReport {
    /// Whether its velocity counts.
    pub verdict: GradientVerdict,
    /// Velocity in the world, m/s.
    pub velocity_m_s: DVec3,
    /// Its covariance, (m/s)²; huge in directions that the gradient does not tell.
    pub covariance: DMat3,
    /// Directions that it tells.
    pub directions: u8,
    /// Frobenius norm of the gradient, µT/m, and of its 1σ error.
    pub gradient_ut_m: f64,
    /// 1σ error of the gradient, µT/m.
    pub gradient_sigma_ut_m: f64,
    /// Mean normalised innovation squared of the readings.
    pub nis: f64,
}

impl GradientReport {
    /// 1σ of the velocity along the direction that is known best, m/s; nothing where none is known.
    pub fn best_sigma_m_s(&self) -> Option<f64> {
        let least = eigen(self.covariance).values.z;
        (self.directions > 0 && least > 0.0).then(|| libm::sqrt(least))
    }
}

/// The pose's filter, as far as it matters here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Carrier {
    /// Rig's axes to world.
    pub(crate) orientation: DQuat,
    /// m/s in the world.
    pub(crate) velocity: DVec3,
    /// (m/s)².
    pub(crate) velocity_covariance: DMat3,
    /// Rate bias, rad/s, and force bias, m/s².
    pub(crate) gyro_bias: DVec3,
    pub(crate) accel_bias: DVec3,
    /// m/s².
    pub(crate) gravity: f64,
}

/// Magnetometer readings of one step, rig's axes, µT.
pub(crate) type Readings = [Option<DVec3>; MAX_MEMBERS];

/// The open window.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Window {
    span_s: f64,
    nis: f64,
    readings: f64,
    /// `Σ G G` and `Σ E[δG δG]` over the readings' epochs.
    signal: DMat3,
    noise: DMat3,
    epochs: f64,
    /// Who gave any.
    members: [bool; MAX_MEMBERS],
    /// Velocity as the window's own readings do not know it, m/s in `N`, and its covariance.
    velocity: DVec3,
    prior: DMat3,
    /// `N` to world.
    to_world: DQuat,
}

/// The state of the velocity by gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GradientAid {
    p: GradientParameters,
    filter: FieldFilter,
    /// Rig's axes to `N`.
    carried: DQuat,
    pending: Moved,
    window: Option<Window>,
    enough: bool,
    odd: [bool; MAX_MEMBERS],
    odd_s: [f64; MAX_MEMBERS],
}

const UNMOVED: Moved = Moved { span_s: 0.0, gain: DVec3::ZERO, way: DVec3::ZERO, turn_rad: 0.0 };

/// A reading is odd so many sigma from what was foreseen, and alone after so many seconds of it.
const ODD_SIGMAS: f64 = 3.5;
const ODD_S: f64 = 0.2;
/// Variance in directions that are not told, (m/s)².
const UNTOLD: f64 = 1e6;

impl GradientAid {
    pub(crate) fn new(geometry: &Geometry, p: GradientParameters) -> Self {
        let breadth = libm::sqrt(geometry.breadth_m2().max(0.0));
        Self {
            p,
            filter: FieldFilter::new(geometry.count(), &p),
            carried: DQuat::IDENTITY,
            pending: UNMOVED,
            window: None,
            odd: [false; MAX_MEMBERS],
            odd_s: [0.0; MAX_MEMBERS],
            enough: geometry.count() >= 3 && breadth >= p.min_breadth_m,
        }
    }

    /// Takes one step; gives a report when a window ends.
    pub(crate) fn step(
        &mut self,
        increment: &Increment,
        readings: &Readings,
        carrier: &Carrier,
        geometry: &Geometry,
    ) -> Option<GradientReport> {
        if !self.enough {
            return None;
        }
        let mut window = self.window.unwrap_or_else(|| self.open(carrier));
        self.carry(increment, carrier, &mut window);
        window.span_s += increment.span_s;
        for member in 0..geometry.count() {
            let odd = self.is_odd(member);
            self.odd_s[member] = if odd { self.odd_s[member] + increment.span_s } else { 0.0 };
        }
        if readings.iter().any(Option::is_some) {
            self.read(readings, geometry, &mut window);
        }
        self.window = Some(window);
        if window.span_s < self.p.window_s {
            return None;
        }
        let report = self.conclude(&window);
        self.window = None;
        if !self.filter.is_finite() {
            self.filter = FieldFilter::new(geometry.count(), &self.p);
        }
        Some(report)
    }

    /// Size of the gradient now, µT/m, and of its error; unknown with too few magnetometers.
    pub(crate) fn gradient_now(&self) -> Option<(f64, f64)> {
        let trace = |m: DMat3| libm::sqrt(m.x_axis.x + m.y_axis.y + m.z_axis.z);
        let g = self.filter.gradient();
        self.enough.then(|| (trace(g * g), trace(self.filter.gradient_error_square())))
    }

    /// Which magnetometers have been odd for so long that it is no single reading.
    pub(crate) fn odd(&self) -> [bool; MAX_MEMBERS] {
        self.odd_s.map(|odd_s| odd_s > ODD_S)
    }

    /// A stretch unseen: the rig is elsewhere.
    pub(crate) fn cross_gap(&mut self) {
        self.filter.forget_field();
        self.pending = UNMOVED;
        self.window = None;
    }

    fn open(&mut self, carrier: &Carrier) -> Window {
        let to_world = so3::renormalise(carrier.orientation * self.carried.conjugate());
        self.flush();
        let from_world = DMat3::from_quat(to_world.conjugate());
        let velocity = from_world * carrier.velocity;
        let known = from_world * carrier.velocity_covariance * from_world.transpose();
        let floor = self.p.prior_sigma_m_s * self.p.prior_sigma_m_s;
        let prior = known * (self.p.prior_factor * self.p.prior_factor)
            + DMat3::from_diagonal(DVec3::splat(floor));
        self.filter.restart_velocity(velocity, prior);
        Window {
            velocity,
            prior,
            span_s: 0.0,
            nis: 0.0,
            readings: 0.0,
            signal: DMat3::ZERO,
            noise: DMat3::ZERO,
            epochs: 0.0,
            members: [false; MAX_MEMBERS],
            to_world,
        }
    }

    /// Strapdown in `N`, summed up until there is a reading.
    fn carry(&mut self, increment: &Increment, carrier: &Carrier, window: &mut Window) {
        let dt = increment.span_s;
        let angle = increment.angle - carrier.gyro_bias * dt;
        let gained = increment.velocity - carrier.accel_bias * dt;
        let gravity = window.to_world.conjugate() * DVec3::new(0.0, 0.0, -carrier.gravity);
        let gain = self.carried * (gained + 0.5 * angle.cross(gained)) + gravity * dt;
        self.pending.way += (self.pending.gain + 0.5 * gain) * dt;
        self.pending.gain += gain;
        window.velocity += gain;
        self.pending.span_s += dt;
        self.pending.turn_rad += libm::sqrt(angle.length_squared());
        self.carried = so3::renormalise(self.carried * so3::exp(angle));
    }

    fn flush(&mut self) {
        if self.pending.span_s > 0.0 {
            let moved = core::mem::replace(&mut self.pending, UNMOVED);
            self.filter.predict(&moved, self.p.roughness_ut_m2, &self.p);
        }
    }

    fn read(&mut self, readings: &Readings, geometry: &Geometry, window: &mut Window) {
        self.flush();
        let turned = DMat3::from_quat(self.carried);
        self.look_for_odd(readings, geometry, turned);
        for (member, reading) in readings.iter().enumerate() {
            let Some(reading) = reading.filter(|_| !self.is_odd(member)) else { continue };
            let arm = geometry.magnetometer_arm_m(member);
            window.nis += self.filter.take((member, turned), arm, reading, self.p.mag_sigma_ut);
            window.readings += 1.0;
            window.members[member] = true;
        }
        let g = self.filter.gradient();
        window.signal += g * g;
        window.noise += self.filter.gradient_error_square();
        window.epochs += 1.0;
    }

    /// Finds readings that are not what the filter foresees.
    fn look_for_odd(&mut self, readings: &Readings, geometry: &Geometry, turned: DMat3) {
        for (member, reading) in readings.iter().enumerate() {
            let Some(reading) = *reading else { continue };
            let arm = geometry.magnetometer_arm_m(member);
            let sigma_ut = self.p.mag_sigma_ut;
            let (off, sigma) = self.filter.surprise((member, turned), arm, reading, sigma_ut);
            let limit = self.p.odd_ut.max(ODD_SIGMAS * sigma);
            self.odd[member] = off > if self.odd[member] { 0.6 * limit } else { limit };
        }
    }

    /// Whether a member's magnetometer, and it alone, is not what was foreseen: what all see is the field.
    fn is_odd(&self, member: usize) -> bool {
        self.odd[member] && self.odd.iter().filter(|odd| **odd).count() == 1
    }

    fn conclude(&mut self, window: &Window) -> GradientReport {
        self.flush();
        let n = window.epochs.max(1.0);
        let trace = |m: DMat3| m.x_axis.x + m.y_axis.y + m.z_axis.z;
        let mut report = GradientReport {
            gradient_ut_m: libm::sqrt(trace(window.signal) / n),
            gradient_sigma_ut_m: libm::sqrt(trace(window.noise) / n),
            nis: window.nis / window.readings.max(1.0),
            ..GradientReport::default()
        };
        report.verdict = self.judge(window, &mut report);
        report
    }

    /// The hard gate; fills in the velocity where it gets so far.
    fn judge(&self, window: &Window, report: &mut GradientReport) -> GradientVerdict {
        if window.members.iter().filter(|m| **m).count() < 3 {
            return GradientVerdict::Array;
        }
        let Some((velocity, covariance)) = self.news(window) else {
            return GradientVerdict::Uniform;
        };
        let covariance = covariance * self.p.deweight;
        let told = self.told(window, covariance);
        report.directions = told.iter().flatten().count() as u8;
        if report.directions == 0 {
            return GradientVerdict::Uniform;
        }
        let to_world = DMat3::from_quat(window.to_world);
        report.velocity_m_s = to_world * velocity;
        report.covariance = to_world * within(told, covariance) * to_world.transpose();
        if report.nis > self.p.max_nis {
            return GradientVerdict::Rough;
        }
        if self.is_uncalibrated() {
            return GradientVerdict::Uncalibrated;
        }
        let along = report.covariance.inverse() * report.velocity_m_s;
        if along.dot(report.velocity_m_s) < 9.0 {
            return GradientVerdict::Still;
        }
        GradientVerdict::Open
    }

    /// What the window's readings alone say: the filter's answer with what it started from taken off
    /// again (the tracklet, or equivalent measurement, of track fusion).
    fn news(&self, window: &Window) -> Option<(DVec3, DMat3)> {
        let q = self.p.acceleration_density * self.p.acceleration_density * window.span_s;
        let before = (window.prior + DMat3::from_diagonal(DVec3::splat(q))).inverse();
        let after = self.filter.velocity_covariance().inverse();
        let floor = DMat3::from_diagonal(DVec3::splat(UNTOLD.recip()));
        let covariance = (after - before + floor).inverse();
        let weighted = after * self.filter.velocity() - before * window.velocity;
        let velocity = covariance * weighted;
        (velocity.is_finite() && eigen(covariance).values.z > 0.0).then_some((velocity, covariance))
    }

    /// The directions in which the gradient stands above its own noise and tells the velocity.
    fn told(&self, window: &Window, covariance: DMat3) -> [Option<DVec3>; 3] {
        let Eigen { values, vectors } = eigen(window.signal);
        let contrast = self.p.contrast * self.p.contrast;
        let max = self.p.max_sigma_m_s * self.p.max_sigma_m_s;
        core::array::from_fn(|k| {
            let e = vectors.col(k);
            let clear = values[k] > contrast * e.dot(window.noise * e);
            (clear && e.dot(covariance * e) < max).then_some(e)
        })
    }

    fn is_uncalibrated(&self) -> bool {
        let limit = 4.0 * self.p.residual_bias_ut;
        (0..MAX_MEMBERS).any(|member| {
            let (bias, _) = self.filter.bias(member);
            bias.abs().max_element() > limit
        })
    }
}

/// A covariance restricted to the told directions; the others are unknown.
fn within(told: [Option<DVec3>; 3], covariance: DMat3) -> DMat3 {
    let outer = |a: DVec3, b: DVec3| DMat3::from_cols(a * b.x, a * b.y, a * b.z);
    let mut sum = DMat3::from_diagonal(DVec3::splat(UNTOLD));
    for a in told.iter().flatten() {
        sum += outer(*a, *a) * -UNTOLD;
        for b in told.iter().flatten() {
            sum += outer(*a, *b) * a.dot(covariance * *b);
        }
    }
    sum
}
