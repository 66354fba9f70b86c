//! The `synthetic` driver: a physical world instead of a camera.
//!
//! The way of one sample:
//!
//! ```text
//! schedule ─> trajectory ─> kinematics ─┐
//!    │             earth's field ───────┼─> sensors ─> transport ─> sink
//!    └─ when, lost?, arrives when? ─────┴─────────────────┘
//! ```
//!
//! A trajectory is a smooth function of time; [`jet`] gives its velocity, acceleration and Euler
//! rates exactly; [`kinematics`] gives from them what an inertial sensor feels on the rotating
//! earth; [`sensor`] adds errors and reads in sensor axes; [`transport`] says which samples
//! arrive, and when. Every sample is a point sample, as the ZED 2 sends it: nothing is integrated
//! over the interval. Gyroscope and accelerometer show what was `imu_delay_s` ago, as their
//! low-pass filters do.
//!
//! The same configuration gives the same samples, whatever the speed; at speed 0 the arrival
//! times are the model's own, so that whole runs repeat bit by bit. (Without `world.year` the
//! earth's field is that of today.)

mod clock;
mod field;
mod jet;
mod kinematics;
mod machines;
mod pace;
mod random;
mod sensor;
mod settings;
mod trajectory;
mod transport;
mod truth;

#[cfg(test)]
mod beginning_tests;
#[cfg(test)]
mod tests;

use std::time::Duration;

use glam::DVec3;
use lodestone_config::model::{Camera, Disturbance, Steel, Synthetic, TrajectoryKind, World};
use lodestone_fusion::{Accel, Gyro, Mag, Rotation, SensorTime};
use thiserror::Error;

pub use field::{EarthField, FieldError};
pub use sensor::AxisMapError;
pub use settings::SettingError;
pub use truth::{Truth, TruthSource};

use super::{BATCH, Driver, DriverCounters, DriverInfo, Sink, SourceState};
use crate::reading::{Reading, RecordedAiding};
use clock::SensorClock;
use kinematics::{Earth, Mover, Seat};
use machines::Machines;
use pace::{Due, Pace};
use random::Stream;
use sensor::{SensorUnit, Stimulus};
use transport::{NOMINAL_RATE_HZ, Schedule, Slot};

/// Why a synthetic camera cannot be made.
#[derive(Debug, Error)]
pub enum SyntheticError {
    /// A setting has no meaning.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The axis map is no rotation.
    #[error(transparent)]
    AxisMap(#[from] AxisMapError),
    /// The earth's field is not known.
    #[error(transparent)]
    Field(#[from] FieldError),
}

/// A simulated camera in a simulated world.
pub struct SyntheticDriver {
    info: DriverInfo,
    truth: TruthSource,
    world: WorldModel,
    sensors: SensorUnit,
    schedule: Schedule,
    pace: Pace,
    clock: SensorClock,
    /// When the source ends, s; infinite if never.
    end_s: f64,
    /// The next sample, not yet taken.
    next: Slot,
    dropped: u64,
}

/// Where the camera is and what surrounds it.
struct WorldModel {
    mover: Mover,
    earth: Earth,
    field: EarthField,
    disturbances: Vec<Disturbance>,
    machines: Machines,
    steel: Vec<Steel>,
    /// From the IMU to the magnetometer, body axes, m.
    magnetometer_arm: DVec3,
    /// Age of what the inertial sensors show, s.
    imu_delay_s: f64,
}

impl WorldModel {
    /// What perfect sensors would read at a time, not before that of the last call.
    fn stimulus(&mut self, time_s: f64) -> Stimulus {
        let motion = self.mover.at(time_s);
        let felt = self.mover.at(time_s - self.imu_delay_s);
        let added = self.disturbances.iter().map(|d| field::disturbance_at(d, time_s));
        let field = added.fold(self.field.world_ut, |sum, b| sum + b);
        let place = motion.position + motion.orientation.apply(self.magnetometer_arm);
        let field = self.steel.iter().fold(field, |sum, s| sum + field::steel_at(s, place));
        let vehicle = self.machines.field(time_s, motion.velocity.length());
        Stimulus {
            time_s,
            gyro: Gyro::new(self.earth.inertial_rate(&felt)),
            accel: Accel::new(self.earth.specific_force(&felt)),
            mag: Mag::new(motion.orientation.inverse().apply(field) + vehicle),
        }
    }
}

impl SyntheticDriver {
    /// Makes the camera and its world; `camera.synthetic` may be absent, then defaults hold.
    ///
    /// # Errors
    /// If a setting has no meaning, the axis map is no rotation, or the earth's field is not known
    /// at the world's place and date.
    pub fn new(camera: &Camera, world: &World) -> Result<Self, SyntheticError> {
        Self::make(camera, None, world)
    }

    /// Makes a camera that rides on a body, at its mounting; the body moves as the leading camera's
    /// settings say. All cameras that ride on one body move as one.
    ///
    /// # Errors
    /// As [`SyntheticDriver::new`].
    pub fn riding(camera: &Camera, leader: &Camera, world: &World) -> Result<Self, SyntheticError> {
        Self::make(camera, Some(leader), world)
    }

    fn make(
        camera: &Camera,
        leader: Option<&Camera>,
        world: &World,
    ) -> Result<Self, SyntheticError> {
        let synthetic = camera.synthetic.clone().unwrap_or_default();
        settings::check(&synthetic)?;
        let field = EarthField::of(world)?;
        let earth = Earth::at(world.latitude_deg, field.true_north_rad);
        let seed = synthetic.seed;
        let mover = mover(camera, leader, &synthetic);
        let clock = SensorClock::drawn(
            synthetic.transport.clock_error,
            synthetic.errors.quantise,
            &mut Stream::ClockOrigin.of(seed),
        );
        let rate_hz = transport::rate_hz(&synthetic.transport);
        let sensors = SensorUnit::new(camera, &synthetic, rate_hz)?;
        let mut schedule = Schedule::new(&synthetic.transport, seed);
        Ok(Self {
            info: info(camera, synthetic.trajectory),
            truth: TruthSource::new(mover.clone(), earth, clock),
            world: WorldModel {
                mover,
                earth,
                field,
                machines: Machines::drawn(&synthetic),
                disturbances: synthetic.disturbance,
                steel: world.steel.clone(),
                magnetometer_arm: DVec3::from_array(camera.magnetometer_position_m),
                imu_delay_s: camera.imu_delay_s,
            },
            sensors,
            next: schedule.next_slot(),
            schedule,
            pace: Pace::new(synthetic.speed),
            clock,
            end_s: if synthetic.duration_s > 0.0 { synthetic.duration_s } else { f64::INFINITY },
            dropped: 0,
        })
    }

    /// The truth at a time on the sensor's clock.
    pub fn truth_at(&self, sensor_time: SensorTime) -> Truth {
        self.truth.truth_at(sensor_time)
    }

    /// A handle on the truth for another thread.
    pub fn truth_source(&self) -> TruthSource {
        self.truth.clone()
    }

    /// Samples that were lost on their way, on purpose.
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Whether the next sample is behind the end.
    fn has_ended(&self) -> bool {
        self.next.time_s >= self.end_s
    }

    /// Takes the next sample and delivers it, unless it is lost.
    fn deliver(&mut self, due: Due, sink: &mut dyn Sink) {
        let slot = std::mem::replace(&mut self.next, self.schedule.next_slot());
        // A lost sample was taken all the same: its noise is drawn, the bias walks on.
        let measured = self.sensors.measure(&self.world.stimulus(slot.time_s));
        if slot.lost {
            self.dropped += 1;
            return;
        }
        sink.push(Reading {
            epoch: 0,
            sensor_time: self.clock.stamp(slot.time_s),
            arrival: match due {
                Due::All => self.pace.host_time(slot.due_s),
                Due::Until(now) => now,
            },
            gyro: measured.gyro,
            accel: measured.accel,
            mag: measured.mag,
            temperature_c: Some(measured.temperature_c),
            saturated: measured.saturated,
            aiding: RecordedAiding::NONE,
        });
    }

    fn is_due(&self, due: Due) -> bool {
        match due {
            Due::All => true,
            Due::Until(now) => self.pace.host_time(self.next.due_s) <= now,
        }
    }
}

impl Driver for SyntheticDriver {
    fn info(&self) -> DriverInfo {
        self.info.clone()
    }

    fn poll(&mut self, timeout: Duration, sink: &mut dyn Sink) -> SourceState {
        if self.has_ended() {
            return SourceState::Ended;
        }
        let due = self.pace.wait(self.next.due_s, timeout);
        // Delivered or dropped; what is left over is still due in the next poll.
        for _ in 0..BATCH {
            if self.has_ended() {
                return SourceState::Ended;
            }
            if !self.is_due(due) {
                break;
            }
            self.deliver(due, sink);
        }
        SourceState::Streaming
    }

    /// All zero: a simulated device neither garbles its reports nor goes away.
    fn counters(&self) -> DriverCounters {
        DriverCounters::default()
    }
}

/// The camera's own motion, or that of its seat on what the leading camera's settings move.
fn mover(camera: &Camera, leader: Option<&Camera>, own: &Synthetic) -> Mover {
    let moves = |synthetic: &Synthetic| {
        let mut drawn = Stream::Trajectory.of(synthetic.seed);
        Mover::new(trajectory::build(synthetic, &mut drawn))
    };
    let Some(leader) = leader else { return beginning(moves(own), camera, own.position_m) };
    let leading = leader.synthetic.clone().unwrap_or_default();
    beginning(moves(&leading).seated(seat(leader)), leader, leading.position_m).seated(seat(camera))
}

/// Moves the way of a body to where it truly begins: to the given place, else to where the camera, seated
/// as it is, stands at its start; else it begins at the origin.
fn beginning(mover: Mover, camera: &Camera, body_m: Option<[f64; 3]>) -> Mover {
    let start_m = || camera.start.map(|start| DVec3::from_array(start.position_m));
    match body_m {
        Some(place_m) => mover.unseated().beginning_at(place_m.into()),
        None => match start_m() {
            Some(place_m) => mover.beginning_at(place_m),
            None => mover,
        },
    }
}

/// Where a camera sits on its body.
fn seat(camera: &Camera) -> Seat {
    let [roll, pitch, yaw] = camera.mounting.roll_pitch_yaw_deg.map(f64::to_radians);
    Seat {
        position: DVec3::from_array(camera.mounting.position_m),
        rotation: Rotation::from_yaw_pitch_roll(yaw, pitch, roll),
    }
}

fn info(camera: &Camera, trajectory: TrajectoryKind) -> DriverInfo {
    let name = match trajectory {
        TrajectoryKind::Standing => "standing",
        TrajectoryKind::Walk => "walk",
        TrajectoryKind::Stairs => "stairs",
        TrajectoryKind::ModelVehicle => "model vehicle",
        TrajectoryKind::Car => "car",
        TrajectoryKind::Turns => "turns",
        TrajectoryKind::Tumble => "tumble",
        TrajectoryKind::Circles => "circles",
    };
    DriverInfo {
        description: format!("synthetic {name}"),
        serial: (camera.serial != 0).then_some(camera.serial),
        nominal_rate_hz: NOMINAL_RATE_HZ,
    }
}
