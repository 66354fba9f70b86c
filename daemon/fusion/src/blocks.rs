//! The estimator's building blocks, each callable as the estimator calls it: for benches alone, behind
//! the feature `blocks`.

use glam::DVec3;

use crate::estimator::Estimator;
use crate::grid::Increment;
use crate::parameters::Parameters;
use crate::predict::{Ground, Pending, ProcessNoise, Strapdown, follow};
use crate::state::State;
use crate::update::compass::Compass;
use crate::update::levelling::Levelling;
use crate::update::standstill::{Around, Standstill};

pub use crate::rig::RigBlocks;

/// An aligned filter, taken apart.
#[derive(Clone, Copy, Debug)]
pub struct Blocks {
    parameters: Parameters,
    noise: ProcessNoise,
    state: State,
    strapdown: Strapdown,
    pending: Pending,
    levelling: Levelling,
    compass: Compass,
    standstill: Standstill,
}

impl Blocks {
    /// The blocks of a filter as it is now; `None` before its alignment.
    pub fn of(estimator: &Estimator, parameters: &Parameters) -> Option<Self> {
        Some(Self {
            parameters: *parameters,
            noise: ProcessNoise::new(parameters),
            state: *estimator.state()?,
            strapdown: Strapdown::NEW,
            pending: Pending::NONE,
            levelling: Levelling::new(),
            compass: Compass::new(),
            standstill: Standstill::UNKNOWN,
        })
    }

    /// The nominal state over one step; gives its turn, rad.
    pub fn predict(&mut self, increment: &Increment) -> f64 {
        let ground = Ground { earth_rate: DVec3::ZERO, stands: false };
        let around = (&self.noise, ground);
        self.strapdown.advance(&mut self.state, &mut self.pending, increment, around)
    }

    /// The covariance over what the nominal state has done since the last time.
    pub fn follow(&mut self) {
        follow(&mut self.state, &mut self.pending, &self.noise);
    }

    /// One update of the tilt; gives its largest normalised innovation squared.
    pub fn level(&mut self) -> f64 {
        self.levelling.update(&mut self.state, &self.parameters.levelling).nis
    }

    /// One update of the heading by a field in body axes, µT, with the average and the verdict on it.
    pub fn compass(&mut self, field_ut: DVec3) -> Option<f64> {
        let interval_s = self.parameters.compass.interval_s;
        let field = self.state.orientation * field_ut;
        self.compass.note_motion(interval_s, 0.0, 0.0);
        let reading = Some((field, DVec3::ZERO));
        let average = self.compass.average(reading, 0.0, interval_s, &self.parameters.compass)?;
        let report = self.compass.update(&mut self.state, &average, &self.parameters)?;
        Some(report.norm_ut)
    }

    /// One step of the search for standstill, with the updates of velocity and rate that follow where
    /// the camera stands; whether it does.
    pub fn standstill(&mut self, increment: &Increment) -> bool {
        let around = Around { earth_rate: DVec3::ZERO, velocity_is_measured: false };
        let windows = self.standstill.watch(increment, &self.parameters);
        self.standstill.update(&mut self.state, &windows, around, &self.parameters);
        self.standstill.stands()
    }

    /// What updates leave undone of the covariance's symmetry.
    pub fn restore(&mut self) {
        self.state.covariance.restore();
    }
}
