//! A recording as a source.
//!
//! The columns of a recording are in body axes. This driver hands them on unchanged as sensor
//! axes: its lane has an identity axis map unless the configuration names another.
//!
//! At a speed above 0 a row is handed on when it is due, and arrives at the time the host's clock
//! shows; sensor time keeps the recording's pace, so `speed` sensor seconds pass in a second of
//! the host ([`crate::clock::SensorClock::new`] takes the inverse). At speed 0 rows come as fast as
//! they are taken, and the host's clock is the recording's: a row arrives at its own time. In a live
//! lane [`super::host_clock`] stamps such rows by the host's clock instead.

mod pace;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use lodestone_config::model::Replay;
use lodestone_fusion::{Accel, Gyro, Mag};
use pace::Pace;

use super::{BATCH, Driver, DriverCounters, DriverInfo, Sink, SourceState};
use crate::reading::{HostTime, Reading};
use crate::recording::{Recording, RecordingError, Row, RowError};

/// Why a recording cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// It cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The speed makes no sense.
    #[error(
        "replay.speed: {0} is not a speed; 0 (as fast as it goes) or a positive number is allowed"
    )]
    Speed(f64),
}

/// Why a replay ended before the end of its recording.
#[derive(Debug, thiserror::Error)]
pub enum ReplayFailure {
    /// The rest of the file cannot be read.
    #[error(transparent)]
    Row(RowError),
    /// The file could not be opened for another round.
    #[error(transparent)]
    Reopen(RecordingError),
}

/// Plays one recording, once or again and again.
#[derive(Debug)]
pub struct ReplayDriver {
    path: PathBuf,
    recording: Recording,
    repeat: bool,
    pace: Pace,
    /// The row that was read and not handed on yet, and when it is due.
    next: Option<(Row, HostTime)>,
    epoch: u32,
    counters: DriverCounters,
    ended: bool,
    failure: Arc<OnceLock<ReplayFailure>>,
}

impl ReplayDriver {
    /// Opens the recording of `settings`, its path relative to `directory`.
    ///
    /// # Errors
    /// [`ReplayError`] if the recording cannot be read or the speed is out of range.
    pub fn open(settings: &Replay, directory: &Path) -> Result<Self, ReplayError> {
        if !settings.speed.is_finite() || settings.speed < 0.0 {
            return Err(ReplayError::Speed(settings.speed));
        }
        let path = directory.join(&settings.file);
        let recording = Recording::open(&path)?;
        if !recording.unknown_columns().is_empty() {
            tracing::info!(
                recording = %path.display(),
                columns = recording.unknown_columns().join(" "),
                "columns that mean nothing here are ignored"
            );
        }
        let pace = Pace::new(settings.speed, recording.nominal_rate_hz());
        Ok(Self {
            path,
            recording,
            repeat: settings.repeat,
            pace,
            next: None,
            epoch: 0,
            counters: DriverCounters::default(),
            ended: false,
            failure: Arc::default(),
        })
    }

    /// Where the reason will stand if the replay ends before the end of its recording.
    pub fn failure(&self) -> Arc<OnceLock<ReplayFailure>> {
        Arc::clone(&self.failure)
    }

    /// Whether the recording has magnetometer columns.
    pub const fn has_magnetometer(&self) -> bool {
        self.recording.has_magnetometer()
    }

    /// Whether the recording has a speed column.
    pub const fn has_speed(&self) -> bool {
        self.recording.has_speed()
    }

    /// Reads the row that comes next, good or bad; a bad one is counted.
    fn read(&mut self) {
        match self.recording.next_row() {
            Some(Ok(row)) => self.next = Some((row, self.pace.schedule(row.time))),
            Some(Err(error)) if error.is_fatal() => self.fail(ReplayFailure::Row(error)),
            Some(Err(error)) => self.count_malformed(&error),
            None if self.repeat => self.reopen(),
            None => self.ended = true,
        }
    }

    fn count_malformed(&mut self, error: &RowError) {
        if self.counters.malformed == 0 {
            tracing::warn!(%error, "a row is skipped; more of them are only counted");
        }
        self.counters.malformed += 1;
    }

    fn reopen(&mut self) {
        match Recording::open(&self.path) {
            Ok(recording) => {
                self.pace.begin_round();
                self.recording = recording;
                self.epoch = self.epoch.wrapping_add(1);
            }
            Err(error) => self.fail(ReplayFailure::Reopen(error)),
        }
    }

    fn fail(&mut self, failure: ReplayFailure) {
        tracing::error!(error = %failure, "the replay ends here");
        // Only the first failure ends the replay, so the cell is empty.
        let _ = self.failure.set(failure);
        self.ended = true;
    }
}

impl Driver for ReplayDriver {
    fn info(&self) -> DriverInfo {
        DriverInfo {
            description: self.path.display().to_string(),
            serial: None,
            nominal_rate_hz: self.recording.nominal_rate_hz(),
        }
    }

    fn poll(&mut self, timeout: Duration, sink: &mut dyn Sink) -> SourceState {
        let mut deadline = Pace::deadline(timeout);
        for _ in 0..BATCH {
            if self.next.is_none() && !self.ended {
                self.read();
            }
            let Some((row, due)) = self.next else {
                if self.ended {
                    return SourceState::Ended;
                }
                continue;
            };
            let Some(arrival) = self.pace.arrival(due, deadline) else {
                return SourceState::Streaming;
            };
            self.next = None;
            sink.push(reading(&row, arrival, self.epoch));
            // Only the first row is waited for; the caller shall have it at once.
            deadline = arrival;
        }
        SourceState::Streaming
    }

    fn counters(&self) -> DriverCounters {
        self.counters
    }
}

fn reading(row: &Row, arrival: HostTime, epoch: u32) -> Reading {
    Reading {
        sensor_time: row.time,
        arrival,
        gyro: Gyro::new(row.gyro.vector),
        accel: Accel::new(row.accel.vector),
        mag: row.mag.map(|mag| Mag::new(mag.vector)),
        temperature_c: row.temperature_c,
        saturated: false,
        aiding: row.aiding,
        epoch,
    }
}
