//! Recordings of a place: the synthetic driver, run as fast as it goes.

use std::time::Duration;

use lodestone_config::model::Synthetic;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::place::Place;
use crate::driver::synthetic::{SyntheticDriver, SyntheticError, TruthSource};
use crate::driver::{Driver, Sink, SourceState};
use crate::service::signals::StopFlag;

/// What a recording is for. No two are made of the same random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// To calibrate from.
    Calibration,
    /// To judge a calibration on: the n-th.
    Fresh(u32),
    /// To look at the noise of sensors at rest.
    Rest,
    /// To follow a motion: the n-th run.
    Run(u32),
    /// To calibrate the unit of the n-th run.
    Unit(u32),
}

/// Why there is no recording.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The synthetic world cannot be made.
    #[error("{scenario}: {source}")]
    World {
        /// The scenario.
        scenario: String,
        /// What is wrong with it.
        source: SyntheticError,
    },
    /// SIGINT or SIGTERM.
    #[error("interrupted; nothing was written")]
    Interrupted,
}

/// Records a place into a sink and gives the truth of what was recorded. `seed` is the evaluation's;
/// `change` may alter what is recorded.
///
/// # Errors
/// If the synthetic world cannot be made, or somebody asked to stop.
pub fn record(
    place: &Place,
    (purpose, seed): (Purpose, u64),
    change: impl FnOnce(&mut Synthetic),
    sink: &mut dyn Sink,
    stop: &StopFlag,
) -> Result<TruthSource, RecordingError> {
    let mut synthetic = place.synthetic();
    synthetic.seed = seed_for(synthetic.seed, seed, purpose);
    synthetic.speed = 0.0;
    change(&mut synthetic);
    let mut camera = place.camera.clone();
    camera.synthetic = Some(synthetic);
    let mut driver = SyntheticDriver::new(&camera, &place.world)
        .map_err(|source| RecordingError::World { scenario: place.source.clone(), source })?;
    while driver.poll(Duration::ZERO, sink) != SourceState::Ended {
        if stop.is_raised() {
            return Err(RecordingError::Interrupted);
        }
    }
    Ok(driver.truth_source())
}

/// An independent seed for each purpose of each place of each evaluation.
fn seed_for(scenario: u64, evaluation: u64, purpose: Purpose) -> u64 {
    let mut rng = ChaCha8Rng::seed_from_u64(scenario ^ evaluation.rotate_left(32));
    rng.set_stream(match purpose {
        Purpose::Calibration => 0,
        Purpose::Rest => 1,
        Purpose::Fresh(n) => 2 + u64::from(n),
        Purpose::Run(n) => (1 << 32) + u64::from(n),
        Purpose::Unit(n) => (2 << 32) + u64::from(n),
    });
    rng.random()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::place::places;
    use crate::reading::Reading;
    use std::collections::BTreeSet;

    fn second(purpose: Purpose, seed: u64) -> Vec<Reading> {
        let place = &places(&[]).unwrap()[0];
        let mut readings = Vec::new();
        let short = |synthetic: &mut Synthetic| synthetic.duration_s = 1.0;
        record(place, (purpose, seed), short, &mut readings, &StopFlag::new()).unwrap();
        readings
    }

    #[test]
    fn no_two_recordings_share_their_noise_and_each_can_be_made_again() {
        let purposes = [
            Purpose::Calibration,
            Purpose::Rest,
            Purpose::Fresh(0),
            Purpose::Fresh(1),
            Purpose::Run(0),
            Purpose::Run(1),
            Purpose::Unit(1),
        ];
        let gyro = |r: &Vec<Reading>| format!("{:?}", r[0].gyro);
        let firsts: BTreeSet<String> = purposes
            .iter()
            .flat_map(|purpose| [1, 2].map(|seed| gyro(&second(*purpose, seed))))
            .collect();
        assert_eq!(firsts.len(), 14);
        assert_eq!(second(Purpose::Rest, 1), second(Purpose::Rest, 1));
    }

    #[test]
    fn a_raised_flag_stops_it() {
        let stop = StopFlag::new();
        stop.raise();
        let place = &places(&[]).unwrap()[0];
        let mut readings: Vec<Reading> = Vec::new();
        let result = record(place, (Purpose::Rest, 0), |_| {}, &mut readings, &stop);
        assert!(matches!(result, Err(RecordingError::Interrupted)));
    }
}
