//! One run of a scene: what the sensors said, and, apart from it, what really happened.

use lodestone_config::Calibration;
use lodestone_config::model::{Camera, Synthetic, World};
use lodestone_fusion::{ImuSample, SensorSpan};

use super::track::{Track, TrackPoint};
use super::unit::Unit;
use crate::driver::synthetic::TruthSource;
use crate::evaluation::place::Place;
use crate::evaluation::recording::{Purpose, RecordingError, record};
use crate::lane::Conditioner;
use crate::reading::Reading;
use crate::service::signals::StopFlag;

/// Samples from one compared pose to the next: 40 poses a second at 400 Hz.
const COMPARED_EVERY: usize = 10;

/// All that an estimator may see.
#[derive(Clone, Debug)]
pub struct Heard {
    /// The camera's configuration.
    pub camera: Camera,
    /// The place's configuration.
    pub world: World,
    /// The unit's calibration; or why there is none.
    pub calibration: Result<Calibration, String>,
    /// What the driver delivered.
    pub readings: Vec<Reading>,
    /// The same in body axes, one for each reading.
    pub samples: Vec<ImuSample>,
    /// Samples per second that the driver means to deliver.
    pub rate_hz: f64,
    /// The first sample after the rest: where the way begins.
    pub begin: usize,
    /// The samples at which poses are asked for, from `begin` on.
    pub instants: Vec<usize>,
}

/// What was heard, and the truth for the score.
#[derive(Clone, Debug)]
pub struct Run {
    /// For estimators.
    pub heard: Heard,
    /// For scores, at the instants.
    pub truth: Track,
}

impl Heard {
    /// Splits readings of a camera into the rest that its scene begins with and what comes then.
    fn new(scene: &Place, unit: &Unit, readings: Vec<Reading>) -> Self {
        let camera = scene.camera.clone();
        let conditioner = Conditioner::new(camera.axes(), None);
        let samples: Vec<ImuSample> =
            readings.iter().map(|reading| conditioner.condition(reading)).collect();
        let rest = SensorSpan::from_secs_f64(scene.synthetic().rest_s);
        let in_rest = |sample: &ImuSample| sample.time - samples[0].time < rest;
        let begin = samples.partition_point(in_rest);
        Self {
            rate_hz: camera.model.nominal_rate_hz(),
            camera,
            world: scene.world.clone(),
            calibration: unit.calibration.clone(),
            readings,
            begin,
            instants: (begin..samples.len()).step_by(COMPARED_EVERY).collect(),
            samples,
        }
    }

    /// Seconds from the end of the rest to a sample.
    pub fn time_s(&self, sample: usize) -> f64 {
        (self.samples[sample].time - self.samples[self.begin].time).as_secs_f64()
    }
}

impl Run {
    /// Sends a unit through a scene.
    ///
    /// # Errors
    /// If the synthetic world cannot be made, or somebody asked to stop.
    pub fn record(
        scene: &Place,
        unit: &Unit,
        seed: u64,
        stop: &StopFlag,
    ) -> Result<Self, RecordingError> {
        let mut readings: Vec<Reading> = Vec::new();
        let purpose = (Purpose::Run(unit.number()), seed);
        let equip = |synthetic: &mut Synthetic| unit.equip(synthetic);
        let truth = record(scene, purpose, equip, &mut readings, stop)?;
        let heard = Heard::new(scene, unit, readings);
        let truth = true_track(&heard, &truth);
        Ok(Self { heard, truth })
    }
}

fn true_track(heard: &Heard, source: &TruthSource) -> Track {
    let point = |&sample: &usize| {
        let truth = source.truth_at(heard.samples[sample].time);
        TrackPoint {
            time_s: heard.time_s(sample),
            position_m: truth.position_m,
            orientation: truth.orientation,
        }
    };
    Track(heard.instants.iter().map(point).collect()).from_its_start()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::place::dynamic_scenes;

    #[test]
    fn a_run_begins_with_rest_and_another_number_is_another_run() {
        let scene = &dynamic_scenes().unwrap()[2];
        let run = |number| {
            let unit = Unit::with_biases(number, [0.0; 3], [0.0; 3]);
            Run::record(scene, &unit, 1, &StopFlag::new()).unwrap()
        };
        let first = run(0);
        let heard = &first.heard;
        assert!((heard.samples[heard.begin].time - heard.samples[0].time).as_secs_f64() >= 10.0);
        assert_eq!(first.truth.0.len(), heard.instants.len());
        assert_eq!(first.truth.0[0].position_m.length().to_bits(), 0);
        let climbed = first.truth.0.iter().map(|p| p.position_m.z).fold(0.0, f64::max);
        assert!((3.9..4.3).contains(&climbed), "two flights of twelve steps: {climbed} m");
        assert_ne!(heard.readings[0].gyro, run(1).heard.readings[0].gyro);
    }
}
