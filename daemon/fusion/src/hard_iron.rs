//! Hard iron that the calibration left, learnt while running.
//!
//! A magnet on the camera turns with it; the earth's field does not. With readings in the body `m`
//! and the attitude `R`, `R m = R b + h + n`: `b` is fixed to the body, `h` to the world, and `n` is
//! what rooms add, another one after each turn or way. A Kalman filter of these six numbers, fed once
//! for each such renewal, tells them apart as soon as the camera has turned (Kok and Schön 2016 treat
//! the whole calibration so). It stands beside the pose's filter: an error of the heading turns `h`
//! and leaves `b` alone, and a wrong `b` cannot make the heading's covariance small.

use glam::{DMat3, DQuat, DVec3};

use crate::parameters::HardIronParameters;

const STATES: usize = 6;

/// The refinement's state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HardIron {
    /// `b`, then `h`, µT.
    estimate: [f64; STATES],
    covariance: [[f64; STATES]; STATES],
    /// Renewals since the last reading that was used.
    renewed: f64,
    /// What is taken off every reading, in the body, µT.
    correction: DVec3,
}

impl HardIron {
    /// Nothing known but the prior.
    pub(crate) fn new(p: &HardIronParameters) -> Self {
        let mut covariance = [[0.0; STATES]; STATES];
        for k in 0..3 {
            covariance[k][k] = p.prior_sigma_ut * p.prior_sigma_ut;
            covariance[k + 3][k + 3] = FIELD_SIGMA_UT * FIELD_SIGMA_UT;
        }
        Self { estimate: [0.0; STATES], covariance, renewed: 0.0, correction: DVec3::ZERO }
    }

    /// What is to be taken off a reading in the body, µT.
    pub(crate) const fn correction(&self) -> DVec3 {
        self.correction
    }

    /// The world may have turned under the filter: another field will be seen in it.
    pub(crate) fn forget_field(&mut self) {
        for k in 3..STATES {
            self.covariance[k][k] += FIELD_SIGMA_UT * FIELD_SIGMA_UT;
        }
    }

    /// Takes note of a turn, rad, and a way, m.
    pub(crate) fn note_motion(&mut self, turn_rad: f64, way_m: f64, p: &HardIronParameters) {
        self.renewed += turn_rad / p.renewal_turn_rad + way_m / p.renewal_way_m;
    }

    /// Takes a raw reading in the body, µT, at an attitude, if it is due and the camera turns slowly
    /// enough, rad/s, for its time not to matter.
    pub(crate) fn take(
        &mut self,
        reading: DVec3,
        orientation: DQuat,
        rate_rad_s: f64,
        p: &HardIronParameters,
    ) {
        if !p.enabled || self.renewed < 1.0 || rate_rad_s > p.max_rate_rad_s {
            return;
        }
        self.renewed = 0.0;
        let rotation = DMat3::from_quat(orientation);
        let world = rotation * reading;
        for k in 0..STATES {
            self.covariance[k][k] += p.walk_ut * p.walk_ut;
        }
        for axis in 0..3 {
            self.update(rotation.row(axis), axis, world[axis], p);
        }
        self.correction = self.worth_correcting(p);
    }

    /// What is believed beyond the dead zone, up to the bound, µT.
    ///
    /// Rooms are not random enough for a small `b` to be believed: a camera that prefers some
    /// headings in some corners sees hard iron of a microtesla or two that is none.
    fn worth_correcting(&self, p: &HardIronParameters) -> DVec3 {
        let b = DVec3::from_slice(&self.estimate[..3]);
        let size_ut = libm::sqrt(b.length_squared());
        if size_ut <= p.dead_zone_ut {
            return DVec3::ZERO;
        }
        // James and Stein's factor: large magnets are taken off nearly whole.
        let believed = 1.0 - p.dead_zone_ut * p.dead_zone_ut / (size_ut * size_ut);
        b * believed.min(p.bound_ut / size_ut)
    }

    /// One axis of `R m = R b + h + n`.
    ///
    /// A residual beyond three standard deviations is weakened: a magnet passes by.
    fn update(&mut self, row: DVec3, axis: usize, measured: f64, p: &HardIronParameters) {
        let mut h = [0.0; STATES];
        h[..3].copy_from_slice(&row.to_array());
        h[3 + axis] = 1.0;
        let ph: [f64; STATES] =
            core::array::from_fn(|i| (0..STATES).map(|k| self.covariance[i][k] * h[k]).sum());
        let expected: f64 = h.iter().zip(&self.estimate).map(|(a, b)| a * b).sum();
        let noise = p.room_sigma_ut * p.room_sigma_ut;
        let variance: f64 = h.iter().zip(&ph).map(|(a, b)| a * b).sum::<f64>() + noise;
        let residual = measured - expected;
        let excess = (residual * residual / (variance * 9.0)).max(1.0);
        let variance = variance * excess;
        for i in 0..STATES {
            self.estimate[i] += ph[i] * residual / variance;
            for k in 0..STATES {
                self.covariance[i][k] -= ph[i] * ph[k] / variance;
            }
        }
    }
}

/// Any field on earth.
const FIELD_SIGMA_UT: f64 = 100.0;
