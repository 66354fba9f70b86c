//! Measurements by others: what they say, when they are believed, what became of them.

use glam::{DMat3, DQuat, DVec3};

use crate::aid_status::{AidKind, AidLedger};
use crate::covariance::{Block, ORIENTATION, POSITION, VELOCITY};
use crate::history::{History, Past, Surroundings};
use crate::parameters::{Parameters, VehicleParameters};
use crate::state::State;
use crate::time::SensorTime;
use crate::update::anchored::{AnchoredPose, Seen, by_anchor};
use crate::update::vector::{GATE, Whitened};
use crate::update::{UNKNOWN_HEADING, fix, non_holonomic, speed};

mod gate;
mod measurement;

use gate::{Gate, Verdict};
pub use measurement::{Aid, Anchor, Measurement};

/// Variance of a heading that was just found, before the pose that gave it counts, rad².
const HARDLY_KNOWN: f64 = 0.9 * UNKNOWN_HEADING;

/// Why a measurement was not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AidRefusal {
    /// There is no state to correct yet.
    #[error("the camera is not aligned yet")]
    NotAligned,
    /// It says something about a time to come.
    #[error("its time of validity is to come")]
    Future,
    /// Its time of validity lies before what is remembered.
    #[error("it is older than two seconds, or than the alignment")]
    TooOld,
    /// A value is not finite or beyond belief, a covariance none, or a quaternion not of unit length.
    #[error("its values make no sense")]
    Invalid,
    /// A speed, and no vehicle is configured.
    #[error("a speed needs a vehicle, and none is configured")]
    NoVehicle,
    /// It does not fit what is known.
    #[error("it does not fit")]
    Innovation,
}

/// What became of a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AidReport {
    /// Which aid it was.
    pub kind: AidKind,
    /// Why it was not used, if it was not.
    pub refusal: Option<AidRefusal>,
    /// Square of the innovation by its covariance, if it came to that; on average the count of numbers
    /// measured.
    pub nis: Option<f64>,
    /// It was refused for long and is believed after all: the position jumped, or may have.
    pub position_jumped: bool,
    /// It gave a heading where none was known: earlier poses do not compare.
    pub heading_found: bool,
}

impl AidReport {
    /// Nothing came of it yet.
    pub(crate) const fn of(kind: AidKind) -> Self {
        Self { kind, refusal: None, nis: None, position_jumped: false, heading_found: false }
    }
}

/// A measurement against the state, ready to be judged.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Candidate<const N: usize> {
    measured: Whitened<N>,
    /// What a doubtful state is uncertain in, and by how much, squared.
    doubt: (Block, f64),
}

impl<const N: usize> Candidate<N> {
    fn nis(&self, state: &State) -> f64 {
        self.measured.nis(state)
    }

    fn apply(&self, state: &mut State, verdict: Verdict) {
        if verdict == Verdict::Reopen {
            self.doubt(state);
        }
        self.measured.apply(state, 1.0);
    }

    fn doubt(&self, state: &mut State) {
        if self.nis(state) > GATE[N - 1] {
            state.covariance.add_variances(self.doubt.0, DVec3::splat(self.doubt.1));
        }
    }
}

/// A pose as it was offered.
#[derive(Clone, Copy, Debug)]
struct OfferedPose {
    /// Position, m, of a point at a lever arm, m.
    place: (DVec3, DVec3),
    orientation: DQuat,
    covariances: [DMat3; 2],
    anchor: Option<Anchor>,
}

impl OfferedPose {
    /// The pose against what it was expected to be.
    fn against(&self, past: &Past) -> Pose {
        let (position_m, lever_m) = self.place;
        let rows = [fix::position_rows(past, lever_m), fix::orientation_rows()];
        let seen = Seen {
            rows: rows.map(|rows| rows.map(|row| past.carry(&row))),
            residuals: [
                fix::position_residual(past, position_m, lever_m),
                fix::orientation_residual(past, self.orientation),
            ],
            arm_m: self.anchor.map_or(DVec3::ZERO, |anchor| position_m - anchor.position_m),
        };
        Pose { seen, covariances: self.covariances, anchor: self.anchor }
    }
}

/// A pose against the state: position, then orientation.
#[derive(Clone, Copy, Debug)]
struct Pose {
    seen: Seen,
    covariances: [DMat3; 2],
    anchor: Option<Anchor>,
}

impl Pose {
    /// Both by themselves, with all that they may be off by.
    fn candidates(&self) -> Result<[Candidate<3>; 2], AidRefusal> {
        let anchored = self.anchor.map(|anchor| by_anchor(&anchor, self.seen.arm_m));
        let [of_position, of_orientation] = anchored.unwrap_or([DMat3::ZERO; 2]);
        let candidate = |which: usize, block: Block, by_anchor: DMat3| {
            let residual = self.seen.residuals[which];
            let covariance = self.covariances[which] + by_anchor;
            let measured = Whitened::correlated(&self.seen.rows[which], residual, covariance);
            let doubt = (block, residual.length_squared());
            Ok(Candidate { measured: measured.ok_or(AidRefusal::Invalid)?, doubt })
        };
        Ok([candidate(0, POSITION, of_position)?, candidate(1, ORIENTATION, of_orientation)?])
    }
}

/// The state of everything that others measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Aiding {
    history: History,
    gates: [Gate; AidKind::ALL.len()],
    last_speed: Option<SensorTime>,
    since_constraint_s: f64,
}

/// What a measurement is taken with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Setting {
    /// The end of the last step.
    pub(crate) now: SensorTime,
    pub(crate) parameters: Parameters,
    pub(crate) around: Surroundings,
    /// The camera stands, and its position stays.
    pub(crate) stands: bool,
    /// The heading counts from the start, not from north.
    pub(crate) heading_is_arbitrary: bool,
}

impl Aiding {
    pub(crate) const NEW: Self = Self {
        history: History::EMPTY,
        gates: [Gate::OPEN; AidKind::ALL.len()],
        last_speed: None,
        since_constraint_s: 0.0,
    };

    /// Takes the motion of a step; says whether the vehicle's constraint is due.
    pub(crate) fn note_motion(
        &mut self,
        step: &crate::grid::Increment,
        vehicle: Option<&VehicleParameters>,
    ) -> bool {
        self.history.push(step);
        self.since_constraint_s += step.span_s;
        let due = vehicle.is_some_and(|v| {
            v.non_holonomic && self.since_constraint_s + 1e-9 >= v.constraint_interval_s
        });
        if due {
            self.since_constraint_s = 0.0;
        }
        due
    }

    /// Corrects a state whose covariance has followed.
    pub(crate) fn take(
        &mut self,
        state: &mut State,
        aid: &Aid,
        ledger: &mut AidLedger,
        setting: &Setting,
    ) -> AidReport {
        let kind = aid.measurement.kind();
        let mut report = AidReport::of(kind);
        match self.judge(state, aid, setting, &mut report) {
            Ok(()) => ledger.note(kind, true),
            Err(refusal) => {
                ledger.note(kind, false);
                report.refusal = Some(refusal);
            }
        }
        report
    }

    fn judge(
        &mut self,
        state: &mut State,
        aid: &Aid,
        setting: &Setting,
        report: &mut AidReport,
    ) -> Result<(), AidRefusal> {
        if !aid.is_sound() {
            return Err(AidRefusal::Invalid);
        }
        let ago_s = (setting.now - aid.time).as_secs_f64();
        if ago_s < 0.0 {
            return Err(AidRefusal::Future);
        }
        let past = self.history.past(state, ago_s, &setting.around).ok_or(AidRefusal::TooOld)?;
        match aid.measurement {
            Measurement::Speed { speed_m_s, sigma_m_s } => {
                let vehicle = setting.parameters.vehicle.as_ref().ok_or(AidRefusal::NoVehicle)?;
                let since_s = self.since_last_speed_s(aid.time);
                let sigma_m_s = sigma_m_s.unwrap_or(vehicle.speed_sigma_m_s);
                let reading = (speed_m_s, sigma_m_s);
                let measured = speed::measurement(state, &past, reading, (since_s, vehicle));
                let residual = speed::residual(state, &past, speed_m_s, vehicle);
                let candidate = Candidate { measured, doubt: (VELOCITY, residual * residual) };
                self.decide(state, candidate, setting, report)
            }
            Measurement::Velocity { velocity_m_s, covariance, lever_m } => {
                let residual = fix::velocity_residual(&past, velocity_m_s, lever_m);
                let rows = (fix::velocity_rows(&past, lever_m), VELOCITY);
                let velocity = candidate(&past, rows, residual, covariance)?;
                self.decide(state, velocity, setting, report)
            }
            Measurement::Position { position_m, covariance, lever_m } => {
                let position = position(&past, position_m, lever_m, covariance)?;
                self.decide(state, position, setting, report)
            }
            Measurement::Pose {
                position_m,
                covariance,
                lever_m,
                orientation,
                orientation_covariance,
            } => {
                let offered = OfferedPose {
                    place: (position_m, lever_m),
                    orientation: orientation.quaternion(),
                    covariances: [covariance, orientation_covariance],
                    anchor: aid.anchor,
                };
                self.judge_pose(state, (&past, &offered), setting, report)
            }
        }
    }

    /// Where the heading is not known, the pose's is taken over first: by any angle, and no linear update
    /// reaches that far.
    fn judge_pose(
        &mut self,
        state: &mut State,
        (past, offered): (&Past, &OfferedPose),
        setting: &Setting,
        report: &mut AidReport,
    ) -> Result<(), AidRefusal> {
        let heading = state.covariance.variance(ORIENTATION.0 + 2);
        if !setting.heading_is_arbitrary && heading < UNKNOWN_HEADING {
            return self.decide_pose(state, &offered.against(past), setting, report);
        }
        let mut turned = *state;
        turned.turn_heading(fix::heading_residual(past, offered.orientation), HARDLY_KNOWN);
        turned.cut(setting.now);
        let past = self.history.past(&turned, past.ago_s, &setting.around);
        let pose = offered.against(&past.ok_or(AidRefusal::TooOld)?);
        self.decide_pose(&mut turned, &pose, setting, report)?;
        *state = turned;
        report.heading_found = true;
        Ok(())
    }

    fn since_last_speed_s(&mut self, time: SensorTime) -> f64 {
        let last = self.last_speed.replace(time);
        last.map_or(f64::INFINITY, |last| (time - last).as_secs_f64().abs())
    }

    fn decide<const N: usize>(
        &mut self,
        state: &mut State,
        candidate: Candidate<N>,
        setting: &Setting,
        report: &mut AidReport,
    ) -> Result<(), AidRefusal> {
        let nis = candidate.nis(state);
        report.nis = Some(nis);
        let verdict = self.verdict(report.kind, nis <= GATE[N - 1], setting)?;
        report.position_jumped = verdict == Verdict::Reopen && candidate.doubt.0 == POSITION;
        // A standing camera's velocity is known; a speed that fits would only shift its position.
        let tells_nothing = setting.stands && candidate.doubt.0 == VELOCITY;
        if verdict == Verdict::Reopen || !tells_nothing {
            candidate.apply(state, verdict);
        }
        Ok(())
    }

    /// A pose whose orientation does not fit is wrong in its position too, and the other way round. One
    /// that was measured against an anchor may be off by as much as that one is.
    fn decide_pose(
        &mut self,
        state: &mut State,
        pose: &Pose,
        setting: &Setting,
        report: &mut AidReport,
    ) -> Result<(), AidRefusal> {
        let [position, orientation] = pose.candidates()?;
        let both = [position.nis(state), orientation.nis(state)];
        report.nis = Some(both[0] + both[1]);
        let fits = both.iter().all(|nis| *nis <= GATE[2]);
        let verdict = self.verdict(report.kind, fits, setting)?;
        report.position_jumped = verdict == Verdict::Reopen && both[0] > GATE[2];
        let Some(anchor) = pose.anchor else {
            position.apply(state, verdict);
            orientation.apply(state, verdict);
            return Ok(());
        };
        let adopted = AnchoredPose::new(&pose.seen, pose.covariances, anchor);
        let adopted = adopted.ok_or(AidRefusal::Invalid)?;
        if verdict == Verdict::Reopen {
            position.doubt(state);
            orientation.doubt(state);
        }
        adopted.apply(state);
        Ok(())
    }

    fn verdict(
        &mut self,
        kind: AidKind,
        fits: bool,
        setting: &Setting,
    ) -> Result<Verdict, AidRefusal> {
        let patience_s = setting.parameters.aiding.patience_s;
        match self.gates[kind as usize].judge(fits, setting.now, patience_s) {
            Verdict::Refuse => Err(AidRefusal::Innovation),
            verdict => Ok(verdict),
        }
    }

    /// Holds a vehicle to the directions in which it can move; gives the innovation if it came to that.
    pub(crate) fn constrain(
        &mut self,
        state: &mut State,
        ledger: &mut AidLedger,
        setting: &Setting,
    ) -> Option<AidReport> {
        let vehicle = setting.parameters.vehicle.as_ref()?;
        let past = self.history.past(state, 0.0, &setting.around)?;
        if !non_holonomic::applies(&past, vehicle) {
            return None;
        }
        let measured = non_holonomic::measurement(state, &past, setting.around.gravity, vehicle);
        let velocity = crate::update::vehicle::velocity(state, &past, vehicle);
        let doubt = velocity.y * velocity.y + velocity.z * velocity.z;
        let candidate = Candidate { measured, doubt: (VELOCITY, doubt) };
        let kind = AidKind::NonHolonomic;
        let mut report = AidReport::of(kind);
        report.refusal = self.decide(state, candidate, setting, &mut report).err();
        ledger.note(kind, report.refusal.is_none());
        Some(report)
    }
}

fn position(
    past: &Past,
    measured: DVec3,
    lever_m: DVec3,
    covariance: DMat3,
) -> Result<Candidate<3>, AidRefusal> {
    let residual = fix::position_residual(past, measured, lever_m);
    candidate(past, (fix::position_rows(past, lever_m), POSITION), residual, covariance)
}

fn candidate(
    past: &Past,
    (rows, block): ([crate::covariance::Row; 3], Block),
    residual: DVec3,
    covariance: DMat3,
) -> Result<Candidate<3>, AidRefusal> {
    let rows = rows.map(|row| past.carry(&row));
    let measured = Whitened::correlated(&rows, residual, covariance).ok_or(AidRefusal::Invalid)?;
    Ok(Candidate { measured, doubt: (block, residual.length_squared()) })
}
