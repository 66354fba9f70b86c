//! Readings made beforehand, so that making them is not measured.

use std::path::Path;
use std::time::Duration;

use lodestone_config::model::{
    Camera, Config, DriverKind, Replay, Synthetic, TrajectoryKind, Transport, World,
};
use lodestone_daemon::driver::replay::{ReplayDriver, ReplayError};
use lodestone_daemon::driver::synthetic::{SyntheticDriver, SyntheticError};
use lodestone_daemon::driver::{Driver, SourceState};
use lodestone_daemon::lane::LaneSettings;
use lodestone_daemon::reading::Reading;

/// Readings and the settings of the lane that takes them.
#[derive(Clone, Debug)]
pub struct Load {
    /// In the order of their arrival.
    pub readings: Vec<Reading>,
    /// Samples per second.
    pub rate_hz: f64,
    /// The lane's settings: the defaults.
    pub settings: LaneSettings,
}

impl Load {
    /// The first `count` readings of a ZED 2 on a trajectory, after 3 s of rest: 400 Hz with the
    /// magnetometer at 50 Hz, the sensor's rate and sampling instants as uneven as a camera's.
    ///
    /// # Errors
    /// [`SyntheticError`] if the world's field is not known today.
    pub fn synthetic(trajectory: TrajectoryKind, count: usize) -> Result<Self, SyntheticError> {
        let camera = synthetic_camera(trajectory);
        let mut driver = SyntheticDriver::new(&camera, &World::default())?;
        Ok(Self::collect(&mut driver, &camera, count))
    }

    /// The first `count` readings of a recording, or all if there are fewer.
    ///
    /// # Errors
    /// [`ReplayError`] if the recording cannot be read.
    pub fn recorded(recording: &Path, count: usize) -> Result<Self, ReplayError> {
        let file = recording.to_string_lossy().into_owned();
        let replay = Replay { file, speed: 0.0, repeat: false };
        let mut driver = ReplayDriver::open(&replay, Path::new(""))?;
        let camera = Camera { driver: DriverKind::Replay, ..Camera::default() };
        Ok(Self::collect(&mut driver, &camera, count))
    }

    fn collect(driver: &mut dyn Driver, camera: &Camera, count: usize) -> Self {
        let rate_hz = driver.info().nominal_rate_hz;
        let mut readings = Vec::with_capacity(count + 64);
        while readings.len() < count
            && driver.poll(Duration::ZERO, &mut readings) != SourceState::Ended
        {}
        readings.truncate(count);
        let settings = LaneSettings::new(&Config::default(), 0, camera, None, rate_hz)
            .expect("magnetic north needs no model");
        Self { readings, rate_hz, settings }
    }
}

/// A camera that delivers as fast as it is polled.
fn synthetic_camera(trajectory: TrajectoryKind) -> Camera {
    let transport = Transport {
        rate_error: 0.004,
        sampling_jitter_s: 20e-6,
        drop_probability: 0.0002,
        ..Transport::default()
    };
    let synthetic =
        Synthetic { trajectory, seed: 1, speed: 0.0, transport, ..Synthetic::default() };
    Camera { driver: DriverKind::Synthetic, synthetic: Some(synthetic), ..Camera::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_walk_is_as_long_as_asked_and_its_magnetometer_comes_every_eighth_sample() {
        let load = Load::synthetic(TrajectoryKind::Walk, 4000).expect("default world");
        let fields = load.readings.iter().filter(|r| r.mag.is_some()).count();
        assert_eq!(load.readings.len(), 4000);
        assert!((495..=505).contains(&fields), "{fields}");
    }
}
