//! A simulated camera and the filter that follows it.

use glam::DVec3;
use lodestone_fusion::{Estimate, Estimator, Parameters, StepReport, so3};

use crate::simulation::{Motion, Simulation, steps};

/// Carried by hand.
pub(crate) const CARRIED: Motion = Motion::Carried { rate_sigma: 0.6, speed_sigma: 0.4 };

/// A camera and the filter that follows it.
#[derive(Clone)]
pub(crate) struct Scene {
    pub(crate) truth: Simulation,
    pub(crate) filter: Estimator,
}

impl Scene {
    pub(crate) fn new(seed: u64) -> Self {
        Self::with(seed, Parameters::default())
    }

    pub(crate) fn with(seed: u64, p: Parameters) -> Self {
        Self { truth: Simulation::new(seed, p), filter: Estimator::new(p) }
    }

    /// A camera with perfect biases, in an undisturbed field.
    pub(crate) fn perfect(seed: u64) -> Self {
        Self::perfect_with(seed, Parameters::default())
    }

    pub(crate) fn perfect_with(seed: u64, p: Parameters) -> Self {
        let still = lodestone_fusion::CompassParameters { deviation_sigma_rad: 0.0, ..p.compass };
        let truth = Simulation::perfect(seed, Parameters { compass: still, ..p });
        Self { truth, filter: Estimator::new(p) }
    }

    /// Lets time pass; gives the last step's report.
    pub(crate) fn pass(&mut self, seconds: f64, motion: Motion) -> StepReport {
        let mut last = None;
        for _ in 0..steps(seconds) {
            last = Some(self.filter.step(&self.truth.step(motion)));
        }
        last.expect("some time passes")
    }

    pub(crate) fn estimate(&self) -> Estimate {
        self.filter.estimate().expect("aligned and finite")
    }

    /// Angle between true and estimated attitude about the world axes, rad.
    pub(crate) fn attitude_error(&self) -> DVec3 {
        let estimated = self.estimate().orientation.quaternion();
        so3::log(self.truth.orientation * estimated.conjugate())
    }

    /// The largest attitude error in standard deviations.
    pub(crate) fn attitude_sigmas(&self) -> f64 {
        let error = self.attitude_error();
        (error.dot(self.estimate().orientation_covariance.inverse() * error)).sqrt()
    }
}
