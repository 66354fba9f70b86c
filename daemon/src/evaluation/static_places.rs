//! The paper's static table: how much calibration steadies the magnetometer at each place.

use glam::DVec3;
use lodestone_calibration::{Outcome, Sample, calibrate};
use lodestone_config::model::{Synthetic, TrajectoryKind};
use serde::Serialize;

use super::correction::Correction;
use super::paper::{PaperRow, row_of};
use super::place::Place;
use super::recording::{Purpose, RecordingError, record};
use super::statistics::{Spread, improvement};
use super::trace::Trace;
use crate::commands::calibrate::{sample, settings_of};
use crate::driver::synthetic::{EarthField, FieldError, TruthSource};
use crate::reading::Reading;
use crate::service::signals::StopFlag;

/// Fresh recordings on which each calibration is judged.
pub const FRESH_RECORDINGS: u32 = 5;
/// Length of the recording at rest, s.
const REST_S: f64 = 120.0;

/// Why a place cannot be evaluated.
#[derive(Debug, thiserror::Error)]
pub enum StaticError {
    /// It cannot be recorded.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The earth's field there is not known.
    #[error("{scenario}: {source}")]
    Field {
        /// The scenario.
        scenario: String,
        /// Why.
        source: FieldError,
    },
    /// The recording is too short for any figure.
    #[error(
        "{scenario}: the magnetometer of camera \"{camera}\" gave fewer than two readings; allowed: \
         a longer camera.synthetic.duration_s"
    )]
    NoReadings {
        /// The scenario.
        scenario: String,
        /// The camera.
        camera: String,
    },
}

/// One row of the table.
#[derive(Clone, Debug, Serialize)]
pub struct PlaceResult {
    /// Name of the place.
    pub name: String,
    /// The scenario it comes from.
    pub scenario: String,
    /// Strength of the earth's field there, µT.
    pub earth_field_ut: f64,
    /// The magnetometer as it comes.
    pub uncalibrated: Score,
    /// The same recordings after calibration; `None` if it was refused.
    pub calibrated: Option<Score>,
    /// `ε = 1 − σ_c / σ_nc`, percent; `None` if calibration was refused.
    pub epsilon_percent: Option<Spread>,
    /// What the calibration said.
    pub calibration: Verdict,
    /// What the paper measured.
    pub paper: Option<PaperRow>,
    /// What the figures show.
    #[serde(skip)]
    pub figures: Figures,
    /// The place itself.
    #[serde(skip)]
    pub place: Place,
}

/// How steady and how right the magnetometer is, over the fresh recordings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Score {
    /// Standard deviation of the field's norm while the camera is turned, µT: the paper's σ.
    pub sigma_ut: Spread,
    /// Root mean square of the heading's error against the truth, degrees.
    pub heading_rms_deg: Spread,
    /// The same for perfect readings of the same distortion, without noise, motors, instruments and
    /// disturbances, degrees: what the calibration itself gets wrong, and no averaging takes away.
    pub lasting_heading_rms_deg: Spread,
    /// Standard deviation of the field's norm at rest, µT: what changes in time alone.
    pub rest_sigma_ut: f64,
}

/// What the calibration said.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Accepted.
    Accepted(Found),
    /// Refused, with what is missing.
    Refused(String),
}

/// What an accepted calibration found, beside the truth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Found {
    /// Its own expectation of the heading's error, 1σ, degrees.
    pub heading_sigma_deg: f64,
    /// Hard iron in sensor axes, µT.
    pub hard_iron_ut: [f64; 3],
    /// Distance of the hard iron from the configured one (the mean field of motors and instruments
    /// is in the one that was found), µT.
    pub hard_iron_error_ut: f64,
    /// Correction of soft iron, row by row.
    pub soft_iron: [[f64; 3]; 3],
    /// What the fit left on its own recording, root mean square per axis, µT.
    pub residual_ut: f64,
}

/// The first fresh recording, before and after.
#[derive(Clone, Debug, Default)]
pub struct Figures {
    /// As it comes.
    pub uncalibrated: Trace,
    /// Calibrated; `None` if it was refused.
    pub calibrated: Option<Trace>,
}

/// Calibrates at a place and judges the calibration on recordings that it has not seen.
///
/// # Errors
/// [`StaticError`] if the place cannot be recorded. A refused calibration is a result.
pub fn evaluate(place: &Place, seed: u64, stop: &StopFlag) -> Result<PlaceResult, StaticError> {
    let session = Session::new(place, seed, stop)?;
    let (calibration, correction) = session.calibrate()?;
    let unseen = Unseen {
        turned: session.fresh(|_| {})?,
        quiet: session.fresh(quiet)?,
        rest: session.record(Purpose::Rest, at_rest)?,
    };
    let before = session.traces(&unseen.turned, &Correction::NONE);
    let uncalibrated = session.score(&before, &unseen, &Correction::NONE)?;
    let after = correction.map(|correction| session.traces(&unseen.turned, &correction));
    let judged = after.as_ref().zip(correction);
    let calibrated =
        judged.map(|(after, correction)| session.score(after, &unseen, &correction)).transpose()?;
    Ok(PlaceResult {
        name: place.name.clone(),
        scenario: place.source.clone(),
        earth_field_ut: session.earth.world_ut.length(),
        uncalibrated,
        calibrated,
        epsilon_percent: after.as_ref().and_then(|after| epsilon_percent(&before, after)),
        calibration,
        paper: row_of(&place.name),
        figures: Figures { uncalibrated: first(before), calibrated: after.map(first) },
        place: place.clone(),
    })
}

fn first(traces: Vec<Trace>) -> Trace {
    traces.into_iter().next().unwrap_or_default()
}

fn at_rest(synthetic: &mut Synthetic) {
    synthetic.trajectory = TrajectoryKind::Standing;
    synthetic.duration_s = REST_S;
}

/// Leaves the distortion alone.
fn quiet(synthetic: &mut Synthetic) {
    synthetic.errors.noise_scale = 0.0;
    synthetic.errors.quantise = false;
    synthetic.motor.clear();
    synthetic.instrument.clear();
    synthetic.disturbance.clear();
}

/// ε of each recording, then their spread.
fn epsilon_percent(before: &[Trace], after: &[Trace]) -> Option<Spread> {
    let of_one = |(before, after): (&Trace, &Trace)| {
        Some(100.0 * improvement(after.norm_sigma_ut()?, before.norm_sigma_ut()?)?)
    };
    let all: Option<Vec<f64>> = before.iter().zip(after).map(of_one).collect();
    Spread::of(&all?)
}

/// Readings with their truth.
struct Recorded {
    readings: Vec<Reading>,
    truth: TruthSource,
}

/// What the calibration has not seen.
struct Unseen {
    /// Turned as for a calibration.
    turned: Vec<Recorded>,
    /// The same movements with perfect readings of the distortion.
    quiet: Vec<Recorded>,
    /// Standing.
    rest: Recorded,
}

/// One place under evaluation.
struct Session<'a> {
    place: &'a Place,
    seed: u64,
    stop: &'a StopFlag,
    earth: EarthField,
}

impl<'a> Session<'a> {
    fn new(place: &'a Place, seed: u64, stop: &'a StopFlag) -> Result<Self, StaticError> {
        let earth = EarthField::of(&place.world)
            .map_err(|source| StaticError::Field { scenario: place.source.clone(), source })?;
        Ok(Self { place, seed, stop, earth })
    }

    fn record(
        &self,
        purpose: Purpose,
        change: impl FnOnce(&mut Synthetic),
    ) -> Result<Recorded, RecordingError> {
        let mut readings = Vec::new();
        let truth = record(self.place, (purpose, self.seed), change, &mut readings, self.stop)?;
        Ok(Recorded { readings, truth })
    }

    fn fresh(&self, change: fn(&mut Synthetic)) -> Result<Vec<Recorded>, RecordingError> {
        (0..FRESH_RECORDINGS).map(|n| self.record(Purpose::Fresh(n), change)).collect()
    }

    /// Calibrates from a recording of its own as `lodestoned calibrate` does: it is told of the place
    /// and the camera's noise figures what the configuration says, and nothing of the truth.
    fn calibrate(&self) -> Result<(Verdict, Option<Correction>), RecordingError> {
        let recorded = self.record(Purpose::Calibration, |_| {})?;
        let samples: Vec<Sample> = recorded.readings.iter().map(sample).collect();
        let settings = settings_of(&self.place.camera, Some(&self.place.world));
        Ok(match calibrate(&samples, &settings) {
            Ok(outcome) => {
                let correction = Correction::of(&outcome);
                (Verdict::Accepted(self.found(&outcome)), Some(correction))
            }
            Err(refusal) => (Verdict::Refused(refusal.to_string()), None),
        })
    }

    fn found(&self, outcome: &Outcome) -> Found {
        let magnetometer = &outcome.magnetometer;
        let configured = DVec3::from_array(self.place.synthetic().distortion.hard_iron_ut);
        Found {
            heading_sigma_deg: magnetometer.heading_sigma_deg,
            hard_iron_ut: magnetometer.hard_iron_ut.to_array(),
            hard_iron_error_ut: magnetometer.hard_iron_ut.distance(configured),
            soft_iron: magnetometer.soft_iron.transpose().to_cols_array_2d(),
            residual_ut: magnetometer.residual_ut,
        }
    }

    fn trace(&self, recorded: &Recorded, correction: &Correction) -> Trace {
        let surroundings = (self.place.camera.axes(), &self.earth);
        Trace::of(&recorded.readings, &recorded.truth, surroundings, correction)
    }

    fn traces(&self, recorded: &[Recorded], correction: &Correction) -> Vec<Trace> {
        recorded.iter().map(|recorded| self.trace(recorded, correction)).collect()
    }

    fn score(
        &self,
        turned: &[Trace],
        unseen: &Unseen,
        correction: &Correction,
    ) -> Result<Score, StaticError> {
        let quiet = self.traces(&unseen.quiet, correction);
        let spread = |traces: &[Trace], figure: fn(&Trace) -> Option<f64>| {
            let all: Option<Vec<f64>> = traces.iter().map(figure).collect();
            Spread::of(&all?)
        };
        let score = || {
            Some(Score {
                sigma_ut: spread(turned, Trace::norm_sigma_ut)?,
                heading_rms_deg: spread(turned, Trace::heading_rms_deg)?,
                lasting_heading_rms_deg: spread(&quiet, Trace::heading_rms_deg)?,
                rest_sigma_ut: self.trace(&unseen.rest, correction).norm_sigma_ut()?,
            })
        };
        score().ok_or_else(|| StaticError::NoReadings {
            scenario: self.place.source.clone(),
            camera: self.place.name.clone(),
        })
    }
}
