//! A low-pass on gyroscope and accelerometer, whose delay is known.
//!
//! Butterworth of second order by the bilinear transform, prewarped, so that the discrete filter has its
//! −3 dB exactly at the cut-off. With `K = tan(π f_c T)`, `d = 1 + √2 K + K²`:
//!
//! ```text
//! H(z) = (K²/d) (1 + 2 z⁻¹ + z⁻²) / (1 + a₁ z⁻¹ + a₂ z⁻²),  a₁ = 2 (K² − 1)/d,  a₂ = (1 − √2 K + K²)/d
//! ```
//!
//! Its group delay at low frequencies, the logarithmic derivative of H at z = 1, is
//! `1 − (a₁ + 2 a₂)/(1 + a₁ + a₂) = 1/(√2 K)` samples; for small `f_c T` that is the analogue filter's
//! `√2/(2π f_c) = 1/(√2 π f_c) = 0.225/f_c`. (Oppenheim and Schafer, Discrete-Time Signal
//! Processing, ch. 7.2.)
//!
//! H(1) = 1, so what is integrated over the filtered samples is what was turned, only later.

use glam::DVec3;

use crate::quantity::{Accel, Gyro};
use crate::sample::ImuSample;

/// Most samples that are taken for missing in one place; after more the filter begins anew.
const MOST_MISSING: u64 = 100;

/// The filter's coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Coefficients {
    b0: f64,
    a1: f64,
    a2: f64,
}

/// One channel of three axes, in the transposed direct form II.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Channel {
    first: DVec3,
    second: DVec3,
}

/// A low-pass on the inertial part of samples at a nominal rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPass {
    coefficients: Coefficients,
    group_delay_s: f64,
    /// The last sample as it came, and the channels of gyroscope and accelerometer.
    running: Option<(ImuSample, [Channel; 2])>,
}

impl LowPass {
    /// A low-pass with a cut-off, Hz, for samples at a rate, Hz; `None` unless the cut-off is above zero
    /// and below 0.45 of the rate.
    pub fn new(cut_off_hz: f64, rate_hz: f64) -> Option<Self> {
        let ratio = cut_off_hz / rate_hz;
        if !(ratio > 0.0 && ratio < 0.45) {
            return None;
        }
        let k = libm::tan(core::f64::consts::PI * ratio);
        let root = core::f64::consts::SQRT_2 * k;
        let d = 1.0 + root + k * k;
        Some(Self {
            coefficients: Coefficients {
                b0: k * k / d,
                a1: 2.0 * (k * k - 1.0) / d,
                a2: (1.0 - root + k * k) / d,
            },
            group_delay_s: 1.0 / (core::f64::consts::SQRT_2 * k * rate_hz),
            running: None,
        })
    }

    /// By how much what comes out is late, s, for motions well below the cut-off.
    pub const fn group_delay_s(&self) -> f64 {
        self.group_delay_s
    }

    /// The sample with its inertial part filtered; `missing` samples were lost before it, and are taken to
    /// lie on a straight line. Neither time nor magnetometer is touched.
    pub fn filter(&mut self, sample: &ImuSample, missing: u64) -> ImuSample {
        let inputs = |s: &ImuSample| [s.gyro.vector, s.accel.vector];
        let c = self.coefficients;
        let now = inputs(sample);
        let Some((last, channels)) = self.running.as_mut().filter(|_| missing <= MOST_MISSING)
        else {
            self.running = Some((*sample, now.map(|input| c.settled(input))));
            return *sample;
        };
        let before = inputs(last);
        let mut out = now;
        for k in 1..=missing + 1 {
            let share = k as f64 / (missing + 1) as f64;
            for axis in 0..2 {
                let input = before[axis] + (now[axis] - before[axis]) * share;
                out[axis] = channels[axis].push(input, &c);
            }
        }
        *last = *sample;
        ImuSample { gyro: Gyro::new(out[0]), accel: Accel::new(out[1]), ..*sample }
    }

    /// Forgets what came: the next sample is taken as one of a camera that has long been so.
    pub const fn reset(&mut self) {
        self.running = None;
    }
}

impl Coefficients {
    /// The state in which an input has been there for ever: no transient follows.
    fn settled(&self, input: DVec3) -> Channel {
        let second = input * (self.b0 - self.a2);
        Channel { first: input * (2.0 * self.b0 - self.a1) + second, second }
    }
}

impl Channel {
    fn push(&mut self, input: DVec3, c: &Coefficients) -> DVec3 {
        let out = input * c.b0 + self.first;
        self.first = input * (2.0 * c.b0) - out * c.a1 + self.second;
        self.second = input * c.b0 - out * c.a2;
        out
    }
}

#[cfg(test)]
mod tests;
