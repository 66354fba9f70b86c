//! Static initial alignment: level by gravity, north by the field, bias by the mean rate.
//!
//! It needs rest and refuses with the reason while there is none; a camera that does not come to rest
//! is aligned coarsely, where that is allowed. Source: Groves, ch. 5.6
//! (levelling and magnetic heading).

use glam::{DMat3, DQuat, DVec3};

use crate::covariance::{
    ACCEL_BIAS, Covariance, DEVIATION, GYRO_BIAS, LEAKY_VELOCITY, MAG_DELAY, ORIENTATION,
};
use crate::grid::Step;
use crate::parameters::Parameters;
use crate::rest::{RestDetector, WindowStatistics};
use crate::so3;
use crate::state::State;

mod coarse;

use coarse::Coarse;

/// Why there is no alignment yet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Waiting {
    /// Not enough samples yet.
    Collecting,
    /// The camera turns: standard deviation of the angular rate, rad/s.
    Turning(f64),
    /// The camera shakes: standard deviation of the specific force, m/s².
    Shaking(f64),
    /// The mean specific force is not gravity: its size, m/s².
    NotGravity(f64),
    /// A constant turn that no gyroscope bias explains: mean angular rate, rad/s.
    ConstantTurn(f64),
}

impl core::fmt::Display for Waiting {
    fn fmt(&self, out: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Collecting => write!(out, "collecting samples"),
            Self::Turning(rate) => {
                write!(out, "the camera turns ({rate:.3} rad/s RMS): hold it still")
            }
            Self::Shaking(force) => {
                write!(out, "the camera shakes ({force:.2} m/s² RMS): hold it still")
            }
            Self::NotGravity(force) => {
                write!(
                    out,
                    "the specific force is {force:.2} m/s², not gravity: check the accelerometer"
                )
            }
            Self::ConstantTurn(rate) => {
                write!(out, "the camera turns steadily ({rate:.3} rad/s): hold it still")
            }
        }
    }
}

/// What the alignment found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aligned {
    /// The first state.
    pub state: State,
    /// The field in levelled world axes, µT, if there was a magnetometer.
    pub field: Option<DVec3>,
    /// Time that the field was averaged over for what it is worth, s: at rest it is worth more.
    pub field_span_s: f64,
    /// Whether the camera stood; else the alignment is a coarse one.
    pub at_rest: bool,
    /// The window that found it, where it is the one that finds standstills later on.
    pub(crate) detector: Option<RestDetector>,
}

/// The alignment's state: what was collected since the camera came to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alignment {
    detector: RestDetector,
    quiet_s: f64,
    field_sum: DVec3,
    field_count: f64,
    coarse: Coarse,
    waiting: Waiting,
}

impl Alignment {
    /// Nothing collected.
    pub const fn new() -> Self {
        Self {
            detector: RestDetector::new(),
            quiet_s: 0.0,
            field_sum: DVec3::ZERO,
            field_count: 0.0,
            coarse: Coarse::NONE,
            waiting: Waiting::Collecting,
        }
    }

    /// Why it is not done yet.
    pub const fn waiting(&self) -> Waiting {
        self.waiting
    }

    /// Takes one step; gives the first state once the camera has stood long enough.
    pub fn push(&mut self, step: &Step, p: &Parameters) -> Option<Aligned> {
        if let Some(mag) = step.mag {
            self.field_sum += mag.vector;
            self.field_count += 1.0;
        }
        self.quiet_s += step.increment.span_s;
        self.coarse.push(step);
        let window = self.detector.push(&step.increment, p.alignment.window_s)?;
        match refuse(&window, p) {
            Some(reason) => {
                let (detector, mut coarse) = (self.detector, self.coarse);
                let aligned = coarse.conclude(p);
                *self = Self { detector, coarse, waiting: reason, ..Self::new() };
                aligned
            }
            None if self.quiet_s < p.alignment.rest_s => {
                self.waiting = Waiting::Collecting;
                None
            }
            None => Some(self.conclude(&window, p)),
        }
    }

    fn conclude(&self, window: &WindowStatistics, p: &Parameters) -> Aligned {
        let level = level(window.force);
        let field = (self.field_count > 0.0).then(|| level * (self.field_sum / self.field_count));
        let bearing = field.and_then(crate::update::compass::bearing);
        // Turning about up by what the field's bearing is too much brings it where it belongs.
        let heading = bearing.map_or(0.0, |bearing| bearing - p.field_bearing_rad);
        let orientation = so3::exp(DVec3::Z * heading) * level;
        let field = field.map(|f| so3::exp(DVec3::Z * heading) * f);
        // A gyroscope at rest shows its bias and the earth's rate.
        let earth_rate = orientation.conjugate() * p.earth_rate_where(bearing.is_some());
        let believed = square(p.noise.gyro_bias_sigma);
        let share = believed / (believed + rate_variance(window, p));
        let gyro_bias = (window.rate - earth_rate) * share;
        let mut state = State { gyro_bias, ..State::at(orientation) };
        state.covariance = first_covariance(&state, window, field, p);
        let alike = p.alignment.window_s.to_bits() == p.rest.window_s.to_bits();
        let detector = alike.then_some(self.detector);
        Aligned { state, field, field_span_s: f64::INFINITY, at_rest: true, detector }
    }
}

impl Default for Alignment {
    fn default() -> Self {
        Self::new()
    }
}

fn refuse(window: &WindowStatistics, p: &Parameters) -> Option<Waiting> {
    let norm = libm::sqrt(window.force.length_squared());
    let rate = libm::sqrt(window.rate.length_squared());
    let (by_rate, by_force) = window.spread(&p.rest.stillness);
    if by_rate + by_force > p.rest.threshold {
        let turning = by_rate > by_force;
        Some(if turning {
            Waiting::Turning(window.rate_deviation)
        } else {
            Waiting::Shaking(window.force_deviation)
        })
    } else if (norm - p.gravity_m_s2).abs() > p.alignment.gravity_tolerance_m_s2 {
        Some(Waiting::NotGravity(norm))
    } else if rate > p.alignment.max_bias_rad_s.max(3.0 * p.noise.gyro_bias_sigma) {
        Some(Waiting::ConstantTurn(rate))
    } else {
        None
    }
}

/// A rotation that takes a specific force to up.
fn level(force: DVec3) -> DQuat {
    let up = force.normalize_or(DVec3::Z);
    if up.z < -0.999 {
        // Upside down, where the shortest arc is ill-defined: half a turn about x first.
        let half_turn = DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0);
        return DQuat::from_rotation_arc(half_turn * up, DVec3::Z) * half_turn;
    }
    DQuat::from_rotation_arc(up, DVec3::Z)
}

fn square(x: f64) -> f64 {
    x * x
}

/// Variance of a window's mean rate as a measurement of the gyroscope's bias, (rad/s)².
fn rate_variance(window: &WindowStatistics, p: &Parameters) -> f64 {
    square(p.noise.gyro_density) / window.span_s + square(p.rest.turn_sigma_rad_s)
}

fn first_covariance(
    state: &State,
    window: &WindowStatistics,
    field: Option<DVec3>,
    p: &Parameters,
) -> Covariance {
    let n = &p.noise;
    let mut cov = Covariance::ZERO;

    let believed = square(n.gyro_bias_sigma);
    let measured = rate_variance(window, p);
    let bias_variance = believed * measured / (believed + measured);
    cov.set_independent(GYRO_BIAS, DMat3::from_diagonal(DVec3::splat(bias_variance)));
    cov.set_independent(ACCEL_BIAS, DMat3::from_diagonal(DVec3::splat(square(n.accel_bias_sigma))));
    cov.set_independent(
        LEAKY_VELOCITY,
        DMat3::from_diagonal(DVec3::splat(square(p.rest.velocity_sigma_m_s))),
    );
    // Levelled with the accelerometer: a horizontal accelerometer bias b tilts by b / g, so the two
    // errors are one. δθ = (ẑ × R δb) / g.
    let to_tilt = so3::skew(DVec3::Z) * state.matrix() * p.gravity_m_s2.recip();
    let settled = square(window.force_deviation.max(0.02) / p.gravity_m_s2) * 0.1;
    cov.set_independent(ORIENTATION, DMat3::from_diagonal(DVec3::new(settled, settled, 0.0)));
    cov.shear(ORIENTATION, to_tilt, ACCEL_BIAS);

    // Without a field the heading counts from here: arbitrary, but not uncertain in its own world.
    let heading = field.map_or(0.0, |field| {
        let horizontal = libm::sqrt(field.x * field.x + field.y * field.y).max(1.0);
        let slope = field.z / horizontal;
        square(n.mag_sigma_ut / horizontal) + square(slope * n.accel_bias_sigma / p.gravity_m_s2)
    });
    cov.add_variance(ORIENTATION.0 + 2, heading);
    let deviation = square(p.compass.deviation_sigma_rad);
    cov.set(DEVIATION, DEVIATION, deviation);
    cov.add_variance(MAG_DELAY, square(p.compass.delay_sigma_s));
    if field.is_some() {
        // The heading was set by the local field: its error is the deviation's opposite.
        cov.add_variance(ORIENTATION.0 + 2, deviation);
        cov.set(ORIENTATION.0 + 2, DEVIATION, -deviation);
    }
    cov.restore();
    cov
}

#[cfg(test)]
mod tests;
