//! The paper's dynamic part, measured again in the synthetic world.
//!
//! ```text
//! unit ──┬─> run ─┬─ heard ─> method ─> track ─┐
//! scene ─┘        └─ truth ────────────────────┴─> errors ─> noise, drift, stairs ─> report
//! ```
//!
//! Every run has another unit of the camera (biases, calibration, noise) and another walker. A method sees what
//! was heard; the truth is for scores alone.

pub mod dead_reckoning;
pub mod drift;
pub mod filtered;
pub mod harmonic;
pub mod method;
pub mod noise;
pub mod recorded;
pub mod run;
pub mod stairs;
pub mod track;
pub mod unit;

use std::path::PathBuf;

use lodestone_config::model::Preset;
use serde::Serialize;

use self::drift::Drift;
use self::filtered::FilterError;
use self::method::Method;
use self::noise::Noise;
use self::recorded::{Recorded, RecordedError};
use self::run::Run;
use self::stairs::{Drawn, Stairs};
use self::track::Track;
use self::unit::Unit;
use super::place::{Place, ScenarioError, dynamic_scenes};
use super::recording::RecordingError;
use crate::service::signals::StopFlag;

/// Why there is no dynamic evaluation.
#[derive(Debug, thiserror::Error)]
pub enum DynamicError {
    /// The embedded scenes cannot be used.
    #[error(transparent)]
    Scenes(#[from] ScenarioError),
    /// A scene cannot be recorded.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// Lodestone's filter gave no pose.
    #[error("scene \"{scene}\", run {run}: {source}")]
    Filter {
        /// The scene.
        scene: String,
        /// The run, from 1.
        run: u32,
        /// Why.
        source: FilterError,
    },
    /// A recording cannot be scored.
    #[error(transparent)]
    Recorded(#[from] RecordedError),
    /// A scene is too short for its figures.
    #[error("scene \"{scene}\": too short for any figure")]
    TooShort {
        /// The scene.
        scene: String,
    },
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct DynamicResult {
    /// Runs of each scene.
    pub runs: u32,
    /// The sensors at rest: the first run of the scene at rest.
    pub noise: Noise,
    /// Position errors at rest.
    pub at_rest: Drift,
    /// Position errors of a camera that is carried through a room.
    pub in_motion: Drift,
    /// Position and orientation on stairs.
    pub stairs: Stairs,
    /// Recordings with a truth, as many as were given.
    pub recordings: Vec<Recorded>,
    /// Position and orientation of the same walkers on the same stairs, halting on every landing.
    pub stairs_halting: Stairs,
}

/// How an evaluation is done.
#[derive(Clone, Copy)]
pub struct Conditions<'a> {
    /// The evaluation's seed.
    pub seed: u64,
    /// Runs of each scene.
    pub runs: u32,
    /// Recordings to score as well.
    pub recordings: &'a [PathBuf],
    /// What carried the recorded sensors.
    pub preset: Preset,
    /// Asks to stop.
    pub stop: &'a StopFlag,
    /// Tells whoever waits.
    pub progress: &'a dyn Fn(&str),
}

impl Conditions<'_> {
    /// Tells of every fourth part.
    fn tell(&self, what: &str, number: u32) {
        if number.is_multiple_of(self.runs.div_ceil(4)) {
            (self.progress)(&format!("{what}: run {} of {}", number + 1, self.runs));
        }
    }
}

/// Evaluates all scenes.
///
/// # Errors
/// [`DynamicError`].
pub fn evaluate(conditions: Conditions<'_>) -> Result<DynamicResult, DynamicError> {
    let scenes = dynamic_scenes()?;
    let [rest, walk, stairs, halting] = &scenes[..] else { return Err(too_short("dynamic")) };
    let recordings = recorded(conditions)?;
    let units = units(rest, conditions)?;
    let (at_rest, noise) = drift_in(rest, &units, conditions)?;
    Ok(DynamicResult {
        runs: conditions.runs,
        noise: noise.ok_or_else(|| too_short(&rest.name))?,
        at_rest,
        in_motion: drift_in(walk, &units, conditions)?.0,
        recordings,
        stairs: stairs_in(stairs, &units, conditions)?,
        stairs_halting: stairs_in(halting, &units, conditions)?,
    })
}

/// The recordings that were given; they come first, because they may be unfit.
fn recorded(conditions: Conditions<'_>) -> Result<Vec<Recorded>, RecordedError> {
    let score = |path: &PathBuf| {
        (conditions.progress)(&format!("recording {}", path.display()));
        recorded::evaluate(path, conditions.preset, conditions.stop)
    };
    conditions.recordings.iter().map(score).collect()
}

/// The units of all runs, calibrated.
fn units(scene: &Place, conditions: Conditions<'_>) -> Result<Vec<Unit>, RecordingError> {
    let drawn = |number| {
        conditions.tell("calibration", number);
        Unit::drawn(scene, (conditions.seed, number), conditions.stop)
    };
    (0..conditions.runs).map(drawn).collect()
}

fn too_short(scene: &str) -> DynamicError {
    DynamicError::TooShort { scene: scene.into() }
}

/// How positions drift in a scene, and what the sensors of its first run show.
fn drift_in(
    scene: &Place,
    units: &[Unit],
    conditions: Conditions<'_>,
) -> Result<(Drift, Option<Noise>), DynamicError> {
    let mut errors = Vec::new();
    let mut noise = None;
    each_run(scene, units, conditions, |number, run, tracks| {
        errors.push(tracks.iter().map(|track| track.errors(&run.truth)).collect());
        if number == 0 {
            noise = Noise::of(&run);
        }
        Some(())
    })?;
    Ok((Drift::of(&scene.name, &errors), noise))
}

/// What becomes of a walk on stairs.
fn stairs_in(
    scene: &Place,
    units: &[Unit],
    conditions: Conditions<'_>,
) -> Result<Stairs, DynamicError> {
    let mut scores = Vec::new();
    let mut drawn = Drawn::default();
    each_run(scene, units, conditions, |number, run, tracks| {
        let walk = Drawn::until_return(run.truth, tracks)?;
        scores.push(walk.scores()?);
        if number == 0 {
            drawn = walk;
        }
        Some(())
    })?;
    Stairs::of(&scores, drawn).ok_or_else(|| too_short(&scene.name))
}

/// Records all runs of a scene and hands each on with the tracks of all methods, which says `None` of a
/// run that is too short.
fn each_run(
    scene: &Place,
    units: &[Unit],
    conditions: Conditions<'_>,
    mut hand_on: impl FnMut(u32, Run, Vec<Track>) -> Option<()>,
) -> Result<(), DynamicError> {
    let Conditions { seed, stop, .. } = conditions;
    for unit in units {
        let number = unit.number();
        conditions.tell(&scene.name, number);
        let run = Run::record(scene, unit, seed, stop)?;
        let tracks = tracks(&run, stop)?.map_err(|source| DynamicError::Filter {
            scene: scene.name.clone(),
            run: number + 1,
            source,
        })?;
        hand_on(number, run, tracks).ok_or_else(|| too_short(&scene.name))?;
    }
    Ok(())
}

/// What each method makes of a run, unless somebody asked to stop.
fn tracks(run: &Run, stop: &StopFlag) -> Result<Result<Vec<Track>, FilterError>, RecordingError> {
    let mut tracks = Vec::new();
    for method in Method::ALL {
        if stop.is_raised() {
            return Err(RecordingError::Interrupted);
        }
        match method.follow(&run.heard) {
            Ok(track) => tracks.push(track),
            Err(error) => return Ok(Err(error)),
        }
    }
    Ok(Ok(tracks))
}
