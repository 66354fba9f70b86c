//! Poses of a recording's rows that came before the filter was aligned.
//!
//! A live lane has no pose before its alignment. A replay may wait: it holds the rows back, and once the
//! filter is aligned, sends an estimator back in time over them ([`Estimator::reversed`]). It begins with
//! the aligned state and its covariance, stands where the camera stood, and grows uncertain where it
//! moved. What lies before a gap stays unknown, and so does what lies further back than [`HELD_ROWS`].
//! Rows after the alignment are as the live lane gives them: nothing of the future is in them.

use std::collections::VecDeque;

use lodestone_fusion::{
    Accel, Accepted, Body, Estimate, Estimator, Grid, GridParameters, Gyro, ImuSample, SensorTime,
};
use lodestone_schema::Status;

/// Most rows that are held back: more than a minute at 400 Hz, 7 MB.
pub const HELD_ROWS: usize = 1 << 15;

/// A row that waits for its pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldRow {
    /// The row's time.
    pub time: SensorTime,
    /// What the lane said at it.
    pub status: Status,
    /// The calibrated sample, if the grid took it.
    pub sample: Option<ImuSample>,
}

/// The rows that wait.
#[derive(Debug, Default)]
pub struct Hindsight {
    held: VecDeque<HeldRow>,
}

impl Hindsight {
    /// Holds a row back; gives the oldest one where there are too many.
    pub fn hold(&mut self, row: HeldRow) -> Option<HeldRow> {
        let oldest = (self.held.len() >= HELD_ROWS).then(|| self.held.pop_front()).flatten();
        self.held.push_back(row);
        oldest
    }

    /// Whether nothing is held.
    pub fn is_empty(&self) -> bool {
        self.held.is_empty()
    }

    /// All that is held, in order, without a pose: there is none to come.
    pub fn give_up(&mut self) -> impl Iterator<Item = HeldRow> + '_ {
        self.held.drain(..)
    }

    /// All that is held, in order, with the poses that an estimator finds which goes back from a time
    /// within the latest sample.
    pub fn look_back(
        &mut self,
        (mut back, from): (Estimator, SensorTime),
        latest: &ImuSample,
        grid: GridParameters,
    ) -> Vec<(HeldRow, Option<Estimate>)> {
        let rows: Vec<HeldRow> = self.held.drain(..).collect();
        let mut poses = vec![None; rows.len()];
        let mut grid = Grid::new(grid);
        // The first sample of a grid only says when it begins.
        let mut covering = *latest;
        let _ = grid.push(reversed(&covering, from));
        for (row, pose) in rows.iter().zip(&mut poses).rev() {
            let Some(sample) = row.sample else { continue };
            // What a sample shows was felt since the one before: going back, it ends there.
            match grid.push(reversed(&covering, sample.time)) {
                Ok(Accepted::Continued { .. }) => {}
                Ok(_) => break,
                Err(_) => continue,
            }
            while let Some(step) = grid.next_step() {
                back.step(&step);
            }
            *pose = back.estimate_ahead(&grid.remainder()).map(|pose| pose.reversed());
            covering = sample;
        }
        keep_over_refused(&rows, &mut poses);
        rows.into_iter().zip(poses).collect()
    }
}

/// A row whose sample was refused has the pose of the one before, as in a lane.
fn keep_over_refused(rows: &[HeldRow], poses: &mut [Option<Estimate>]) {
    let mut last = None;
    for (row, pose) in rows.iter().zip(poses) {
        if row.sample.is_none() {
            *pose = last;
        }
        last = *pose;
    }
}

/// A sample in a time that runs backwards, with the time at which it then ends. The magnetometer has
/// had its say in the alignment.
fn reversed(sample: &ImuSample, ends: SensorTime) -> ImuSample {
    ImuSample {
        time: SensorTime::from_nanos(-ends.as_nanos()),
        gyro: Gyro::<Body>::new(-sample.gyro.vector),
        accel: Accel::<Body>::new(sample.accel.vector),
        mag: None,
        saturated: sample.saturated,
    }
}

#[cfg(test)]
mod tests;
