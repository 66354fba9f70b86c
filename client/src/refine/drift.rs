//! The error of a camera's published poses against the anchor's, followed over time.

use nalgebra::{Matrix6, Vector6};

use crate::registration::PoseCovariance;

/// Drift of an orientation that nothing but gyroscope and compass holds, rad²/s: 0.05° in a second.
const TURN_RAD2_S: f64 = 7.6e-7;
/// Drift of a position between fixes, m²/s: 3 cm in a second.
const SHIFT_M2_S: f64 = 9e-4;
/// Square of the Mahalanobis distance that 99.73 % of what fits stay within, in six dimensions.
const SURPRISE: f64 = 20.062;

/// A random walk that is measured now and then: turn about the world's axes, rad, then shift of the body,
/// m; small, so that they add.
#[derive(Clone, Debug, Default)]
pub(super) struct Drift {
    state: Option<State>,
}

#[derive(Clone, Debug)]
struct State {
    error: Vector6<f64>,
    covariance: Matrix6<f64>,
    time_ns: i64,
}

impl Drift {
    /// Takes a measurement. One that does not fit what was known, such as after a jump of the pose, stands
    /// alone from here on.
    pub(super) fn measure(
        &mut self,
        time_ns: i64,
        error: Vector6<f64>,
        covariance: &PoseCovariance,
    ) -> Vector6<f64> {
        let measured = State { error, covariance: covariance.matrix(), time_ns };
        let merged = self.state.as_ref().and_then(|state| state.merged(&measured));
        self.state.insert(merged.unwrap_or(measured)).error
    }

    /// Nothing is known any more.
    pub(super) fn forget(&mut self) {
        self.state = None;
    }

    /// Time of the last measurement, ns.
    pub(super) fn measured_ns(&self) -> Option<i64> {
        self.state.as_ref().map(|state| state.time_ns)
    }

    /// The error as it was last known.
    pub(super) fn error(&self) -> Option<Vector6<f64>> {
        self.state.as_ref().map(|state| state.error)
    }
}

impl State {
    /// `None` if the two exclude each other.
    fn merged(&self, measured: &Self) -> Option<Self> {
        let seconds = (measured.time_ns.saturating_sub(self.time_ns) as f64 * 1e-9).max(0.0);
        let (turn, shift) = (TURN_RAD2_S * seconds, SHIFT_M2_S * seconds);
        let walk = Vector6::new(turn, turn, turn, shift, shift, shift);
        let before = self.covariance + Matrix6::from_diagonal(&walk);
        let innovation = measured.error - self.error;
        let factor = (before + measured.covariance).cholesky()?;
        let is_surprise = innovation.dot(&factor.solve(&innovation)) > SURPRISE;
        let gain = factor.solve(&before).transpose();
        let after = before - gain * before;
        (!is_surprise).then(|| Self {
            error: self.error + gain * innovation,
            covariance: (after + after.transpose()) * 0.5,
            time_ns: measured.time_ns.max(self.time_ns),
        })
    }
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;

    const SECOND: i64 = 1_000_000_000;

    fn covariance(sigma: f64) -> PoseCovariance {
        let square = DMat3::IDENTITY * (sigma * sigma);
        PoseCovariance::independent(square, square)
    }

    #[test]
    fn the_first_measurement_stands_and_later_ones_are_averaged() {
        let mut drift = Drift::default();
        assert!(drift.error().is_none() && drift.measured_ns().is_none());
        let first = Vector6::repeat(0.01);
        assert_eq!(drift.measure(0, first, &covariance(0.01)), first);
        // At the same moment, two of the same weight meet in the middle.
        let second = drift.measure(0, Vector6::zeros(), &covariance(0.01));
        assert!((second - Vector6::repeat(0.005)).norm() < 1e-12);
        // After a while, a position is the newest one's, an orientation still a mean.
        let third = drift.measure(20 * SECOND, Vector6::repeat(0.02), &covariance(0.01));
        assert!(third[3] > 0.018 && third[0] < third[3], "{third}");
        assert_eq!(drift.measured_ns(), Some(20 * SECOND));
    }

    #[test]
    fn after_a_jump_the_new_one_stands_alone() {
        let mut drift = Drift::default();
        drift.measure(0, Vector6::zeros(), &covariance(0.001));
        let jump = Vector6::repeat(0.1);
        assert_eq!(drift.measure(SECOND, jump, &covariance(0.001)), jump);
        drift.forget();
        assert!(drift.error().is_none());
    }
}
