//! What others measured, on its way to the estimator: from rows of a recording, and in wait for the grid.

use glam::{DMat3, DQuat, DVec3};
use lodestone_fusion::{Aid, Measurement, Rotation, SensorSpan, SensorTime};

use crate::reading::{Reading, RecordedFix, RecordedSpeed};

/// Measurements that may wait for the grid; those of a quarter of a second of several sources.
const WAITING: usize = 16;

/// Time that a measurement may be ahead of the newest sample, s. More is a wrong clock.
const AHEAD_S: f64 = 0.25;

/// Measurements whose time of validity the grid has not reached yet, in order of arrival.
#[derive(Clone, Debug)]
pub(crate) struct AidQueue {
    waiting: [Option<Aid>; WAITING],
    /// Where position fixes of a recording hold, from the body's origin in the body, m.
    antenna_m: DVec3,
}

/// A measurement found no place, or is too far ahead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Turned;

impl AidQueue {
    pub(crate) const fn new(antenna_m: DVec3) -> Self {
        Self { waiting: [None; WAITING], antenna_m }
    }

    /// Takes a measurement; the newest sample says what is ahead.
    pub(crate) fn push(&mut self, aid: Aid, newest: SensorTime) -> Result<(), Turned> {
        if (aid.time - newest).as_secs_f64() > AHEAD_S {
            return Err(Turned);
        }
        let slot = self.waiting.iter_mut().find(|slot| slot.is_none()).ok_or(Turned)?;
        *slot = Some(aid);
        Ok(())
    }

    /// The next measurement that is valid at a time or before.
    pub(crate) fn next_due(&mut self, now: SensorTime) -> Option<Aid> {
        let due = |slot: &&mut Option<Aid>| slot.is_some_and(|aid| aid.time <= now);
        self.waiting.iter_mut().find(due).and_then(Option::take)
    }

    /// Forgets what waits: another clock, or another filter.
    pub(crate) const fn clear(&mut self) -> u64 {
        let mut forgotten = 0;
        let mut k = 0;
        while k < WAITING {
            forgotten += self.waiting[k].is_some() as u64;
            self.waiting[k] = None;
            k += 1;
        }
        forgotten
    }

    /// What a reading of a recording brings.
    pub(crate) fn recorded(&self, reading: &Reading) -> [Option<Aid>; 2] {
        let at = |age_s: f32, measurement: Measurement| Aid {
            time: reading.sensor_time + SensorSpan::from_secs_f64(-f64::from(age_s)),
            measurement,
            anchor: None,
        };
        [
            reading.aiding.speed.map(|speed| at(speed.age_s, speed_of(&speed))),
            reading.aiding.fix.map(|fix| at(fix.age_s, fix_of(&fix, self.antenna_m))),
        ]
    }
}

fn speed_of(speed: &RecordedSpeed) -> Measurement {
    Measurement::Speed { speed_m_s: speed.speed_m_s, sigma_m_s: speed.sigma_m_s.map(f64::from) }
}

/// A fix without orientation is an antenna's, one with it the camera's own.
fn fix_of(fix: &RecordedFix, antenna_m: DVec3) -> Measurement {
    // A negative σ makes no sense: it keeps its sign, and the estimator refuses it.
    let isotropic = |sigma: f32| DMat3::IDENTITY * (f64::from(sigma) * f64::from(sigma.abs()));
    let (position_m, covariance) = (fix.position_m.into(), isotropic(fix.sigma_m));
    let pose = fix.orientation.and_then(|(turn, sigma)| {
        let [x, y, z, w] = turn.map(f64::from);
        Some((Rotation::from_quaternion(DQuat::from_xyzw(x, y, z, w))?, isotropic(sigma)))
    });
    match pose {
        Some((orientation, orientation_covariance)) => Measurement::Pose {
            position_m,
            covariance,
            lever_m: DVec3::ZERO,
            orientation,
            orientation_covariance,
        },
        // An orientation that is none spoils its position too: said by a covariance that is none.
        None if fix.orientation.is_some() => {
            Measurement::Position { position_m, covariance: DMat3::ZERO, lever_m: DVec3::ZERO }
        }
        None => Measurement::Position { position_m, covariance, lever_m: antenna_m },
    }
}
