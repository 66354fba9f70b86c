//! The world that all cameras share, checked.

use core::time::Duration;

use glam::{DQuat, DVec3};
use lodestone_schema::{NorthKind, ServiceKind, WorldState, name_of};

use crate::error::MessageError;
use crate::message::Message;

/// The world as it lies in shared memory.
pub type WorldMessage = lodestone_schema::World;

/// What all cameras share: since when, fixed by whom, turned to which north.
///
/// ```no_run
/// # let client = lodestone_client::Client::connect()?;
/// let world = client.world().latest()?;
/// if let Some(epoch) = world.epoch() {
///     println!("world {epoch}, fixed by {}", world.first_camera().unwrap_or("a camera"));
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldInfo {
    message: WorldMessage,
    state: WorldState,
    north: NorthKind,
}

impl TryFrom<WorldMessage> for WorldInfo {
    type Error = MessageError;

    fn try_from(message: WorldMessage) -> Result<Self, MessageError> {
        let unknown = |field, code| MessageError::UnknownCode { field, code };
        let state =
            WorldState::from_code(message.state).ok_or_else(|| unknown("state", message.state))?;
        let north =
            NorthKind::from_code(message.north).ok_or_else(|| unknown("north", message.north))?;
        name_of(&message.first_camera).ok_or(MessageError::BadName { field: "first_camera" })?;
        Ok(Self { message, state, north })
    }
}

impl Message for WorldInfo {
    type Raw = WorldMessage;
    const KIND: ServiceKind = ServiceKind::World;
    const SILENCE: Duration = Duration::from_secs(5);

    fn sequence(raw: &WorldMessage) -> u64 {
        raw.sequence
    }

    fn time_ns(raw: &WorldMessage) -> i64 {
        raw.time_ns
    }
}

impl WorldInfo {
    /// The message.
    pub const fn message(&self) -> &WorldMessage {
        &self.message
    }

    /// How far it is.
    pub const fn state(&self) -> WorldState {
        self.state
    }

    /// Its epoch, raised each time it is defined anew; `None` while it waits for a camera.
    pub const fn epoch(&self) -> Option<u32> {
        match self.state {
            WorldState::Waiting => None,
            WorldState::Fixed | WorldState::Restored => Some(self.message.epoch),
        }
    }

    /// Which north its y axis points to.
    pub const fn north(&self) -> NorthKind {
        self.north
    }

    /// Whether it is kept for the next run of the daemon.
    pub const fn is_kept(&self) -> bool {
        self.message.kept != 0
    }

    /// When it was fixed, ns since the UNIX epoch.
    pub fn t0_unix_ns(&self) -> Option<i64> {
        self.epoch().map(|_| self.message.t0_unix_ns)
    }

    /// The camera that fixed it.
    pub fn first_camera(&self) -> Option<&str> {
        name_of(&self.message.first_camera).filter(|name| !name.is_empty())
    }

    /// The first camera's rotation body to world at t0.
    pub fn first_orientation(&self) -> Option<DQuat> {
        Some(DQuat::from_array(self.message.first_orientation)).filter(|q| q.is_finite())
    }

    /// The magnetometer at the origin, in the first camera's axes, m.
    pub fn magnetometer_position_m(&self) -> Option<DVec3> {
        Some(DVec3::from_array(self.message.magnetometer_position_m)).filter(|v| v.is_finite())
    }

    /// Magnetic against true north, clockwise positive, rad.
    pub fn declination_rad(&self) -> Option<f64> {
        known(self.message.declination_rad)
    }

    /// Strength of the field at t0, µT.
    pub fn field_norm_ut(&self) -> Option<f64> {
        known(self.message.field_norm_ut)
    }

    /// Dip of the field at t0 below the horizon, rad.
    pub fn field_dip_rad(&self) -> Option<f64> {
        known(self.message.field_dip_rad)
    }

    /// Standard deviation of the first camera's heading at t0, rad.
    pub fn heading_sigma_rad(&self) -> Option<f64> {
        known(self.message.heading_sigma_rad)
    }

    /// Standard deviation of the first camera's tilt at t0, rad.
    pub fn tilt_sigma_rad(&self) -> Option<f64> {
        known(self.message.tilt_sigma_rad)
    }
}

fn known(value: f64) -> Option<f64> {
    Some(value).filter(|value| value.is_finite())
}
